//! Small JPEGs of what the cameras of a recording saw, and its masks at their size, at as many frames
//! as fit.

use bendtwin_capture::raw::{ColorImage, Frames, Recording, Region};
use jpeg_encoder::{ColorType, Encoder};
use rayon::prelude::*;

use super::labels;

/// Longest side of an image [pixels].
const SIDE: usize = 424;
/// Quality of JPEG, 1..=100.
const QUALITY: u8 = 70;
/// Most images, and most recorded pixels that are read for them: a bound on time.
const MAX_IMAGES: usize = 6_000;
const MAX_PIXELS: usize = 3_000_000_000;

/// The images of a recording.
pub(super) struct Images {
    /// Image k of a camera is of frame `k * every`.
    pub(super) every: usize,
    /// Shape [camera, image].
    pub(super) files: Vec<Vec<Small>>,
}

/// A small image and its masks.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Small {
    /// JPEG file; empty if it was not recorded.
    pub(super) jpeg: Vec<u8>,
    /// Masks as run lengths of [`labels`]; empty if there are none.
    pub(super) labels: Vec<u8>,
}

impl Small {
    fn len(&self) -> usize {
        self.jpeg.len() + self.labels.len()
    }
}

/// Columns and rows of the small image of an image of this size.
pub(super) fn small_size(width: usize, height: usize) -> [usize; 2] {
    let longest = width.max(height);
    if longest <= SIDE {
        return [width, height];
    }
    [width, height].map(|side| (side * SIDE / longest).max(1))
}

/// The images of a recording that take at most `budget` bytes, and its share of what `recordings`
/// recordings may take of time: every frame, every second one, every fourth and so on, the same of all
/// cameras. `tell` gets the share that is done.
pub(super) fn collect(
    recording: &Recording,
    budget: usize,
    recordings: usize,
    tell: &mut dyn FnMut(f64),
) -> Images {
    let recording = &recording.usable();
    let cameras = &recording.cameras;
    let mut readers: Vec<Option<Box<dyn Frames + '_>>> =
        (0..cameras.len()).map(|camera| recording.source.frames(camera).ok()).collect();
    let pixels: usize = cameras.iter().map(|c| c.width.saturating_mul(c.height)).sum();
    let frames = recording.frame_count;
    let times = |each: usize, most: usize| frames.saturating_mul(each).div_ceil(most / recordings);
    let mut every = times(cameras.len(), MAX_IMAGES).max(times(pixels, MAX_PIXELS)).max(1);
    // By frame and camera.
    let mut rows: Vec<Vec<Small>> = Vec::new();
    let (mut bytes, mut frame) = (0, 0);
    while frame < frames {
        let row: Vec<Small> = readers
            .par_iter_mut()
            .map(|reader| reader.as_mut().map(|r| read(&mut **r, frame)).unwrap_or_default())
            .collect();
        bytes += row.iter().map(Small::len).sum::<usize>();
        rows.push(row);
        while bytes > budget && !rows.is_empty() {
            // A single one that is too large goes, too.
            let first = usize::from(rows.len() == 1);
            rows = rows.into_iter().skip(first).step_by(2).collect();
            bytes = rows.iter().flatten().map(Small::len).sum();
            every *= 2;
        }
        frame = rows.len() * every;
        tell(frame.min(frames) as f64 / frames as f64);
        if rows.is_empty() {
            break;
        }
    }
    let mut files = vec![Vec::with_capacity(rows.len()); cameras.len()];
    for row in rows {
        files.iter_mut().zip(row).for_each(|(files, file)| files.push(file));
    }
    Images { every, files }
}

/// The small image of a frame, and its masks.
fn read(frames: &mut dyn Frames, frame: usize) -> Small {
    let color = frames.color(frame).ok().flatten();
    let jpeg = color.and_then(|image| encoded(&image)).unwrap_or_default();
    let mut mask = |region| frames.mask(frame, region).ok().flatten();
    let (object, hand) = (mask(Region::Object), mask(Region::Manipulator));
    Small { jpeg, labels: labels::runs(object.as_ref(), hand.as_ref()) }
}

/// The small JPEG of an image.
fn encoded(image: &ColorImage) -> Option<Vec<u8>> {
    let image = shrunk(image);
    let (width, height) = (u16::try_from(image.width).ok()?, u16::try_from(image.height).ok()?);
    let mut file = Vec::new();
    let encoder = Encoder::new(&mut file, QUALITY);
    encoder.encode(image.pixels.as_flattened(), width, height, ColorType::Rgb).ok()?;
    Some(file)
}

/// The small image of an image: each pixel is the mean of those that it covers.
fn shrunk(image: &ColorImage) -> ColorImage {
    let [width, height] = small_size(image.width, image.height);
    let mut small = ColorImage::filled(width, height, [0; 3]);
    if [width, height] == [image.width, image.height] {
        return image.clone();
    }
    let columns: Vec<[usize; 2]> =
        (0..width).map(|x| [x * image.width / width, (x + 1) * image.width / width]).collect();
    for (y, out) in small.pixels.chunks_mut(width).enumerate() {
        let [top, bottom] = [y * image.height / height, (y + 1) * image.height / height];
        let mut sums = vec![[0_u32; 3]; width];
        for row in top..bottom {
            let pixels = image.row(row);
            for (sum, [left, right]) in sums.iter_mut().zip(&columns) {
                for pixel in &pixels[*left..*right] {
                    sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += u32::from(*p));
                }
            }
        }
        for ((pixel, sum), [left, right]) in out.iter_mut().zip(&sums).zip(&columns) {
            let count = ((bottom - top) * (right - left)).max(1) as u32;
            *pixel = sum.map(|s| ((s + count / 2) / count) as u8);
        }
    }
    small
}

#[cfg(test)]
mod tests {
    use bendtwin_synth::{FilmOptions, Scene, film};

    use super::*;

    #[test]
    fn a_small_image_has_the_means_of_the_large_one() {
        let mut image = ColorImage::filled(848, 480, [10, 20, 30]);
        image.pixels[0] = [14, 20, 30];
        let small = shrunk(&image);
        assert_eq!((small.width, small.height), (424, 240));
        assert_eq!((small.pixels[0], small.pixels[1]), ([11, 20, 30], [10, 20, 30]));
        assert_eq!(small_size(480, 848), [240, 424]);
        assert_eq!(small_size(10_000, 1), [424, 1]);
        let odd = shrunk(&ColorImage::filled(1000, 333, [7; 3]));
        assert!(odd.pixels.iter().all(|p| *p == [7; 3]));
    }

    #[test]
    fn frames_are_left_out_until_the_rest_fits() {
        let recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
        let mut reported = Vec::new();
        let all = collect(&recording, usize::MAX, 1, &mut |done| reported.push(done));
        let count = |images: &Images| images.files.iter().map(Vec::len).collect::<Vec<_>>();
        let size = |images: &Images| images.files.iter().flatten().map(Small::len).sum::<usize>();
        assert_eq!(all.every, 1);
        assert_eq!(count(&all), vec![recording.frame_count; recording.cameras.len()]);
        assert!(reported.is_sorted() && reported.last() == Some(&1.0));
        let budget = size(&all) / 3;
        let some = collect(&recording, budget, 1, &mut |_| {});
        assert!(some.every == 4 && size(&some) <= budget);
        assert_eq!(count(&some)[0], recording.frame_count.div_ceil(4));
        assert_eq!(some.files[1][1], all.files[1][4]);
        let none = collect(&recording, 10, 1, &mut |_| {});
        assert_eq!((count(&none)[0], size(&none)), (0, 0));
        // A decoder of another make reads them.
        let camera = &recording.cameras[0];
        let size = small_size(camera.width, camera.height);
        let image = ColorImage::decode("a.jpg", &all.files[0][0].jpeg, size).unwrap();
        let made = recording.source.frames(0).unwrap().color(0).unwrap().unwrap();
        let differences = image.pixels.as_flattened().iter().zip(made.pixels.as_flattened());
        let sum: u32 = differences.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        assert!(f64::from(sum) / (3 * image.pixels.len()) as f64 <= 12.0, "{sum}");
    }
}

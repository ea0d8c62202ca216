//! The part of a recording that can be used: a damaged file counts as not recorded, and a number that
//! stands for no depth as 0. The report gives their number; one damaged file among thousands is no
//! reason to stop.

use std::sync::Arc;

use bendtwin_core::{Category, Problem as _};

use super::{ColorImage, DepthImage, Frames, Mask, Recording, Region, Source, Tracks};
use crate::Error;

/// Share of an image's pixels that share one depth if it stands for none, 0..=1. Chosen by hand:
/// measured depths repeat by chance, the largest of them hardly.
const MIN_FILLED_SHARE: f64 = 0.002;
/// Ratio of that depth to the largest other one. Chosen by hand: 65535 of any unit is far beyond
/// what is measured, a wall is not.
const FILLED_RATIO: f32 = 2.0;

impl Recording {
    /// The recording with damaged files read as not recorded, and pixels with
    /// [`DepthImage::fill_value`] as 0.
    #[must_use]
    pub fn usable(&self) -> Self {
        Self { source: Arc::new(Usable(self.source.clone())), ..self.clone() }
    }
}

impl DepthImage {
    /// The number that stands where nothing was measured [m], if it is not 0: shared by many pixels to
    /// the last bit, and far beyond all others. 65535 of an image file, say.
    pub fn fill_value(&self) -> Option<f32> {
        let (mut largest, mut count, mut second) = (0.0_f32, 0_usize, 0.0_f32);
        for &metres in self.pixels.iter().filter(|d| d.is_finite() && **d > 0.0) {
            if metres > largest {
                (second, largest, count) = (largest, metres, 1);
            } else if metres == largest {
                count += 1;
            } else {
                second = second.max(metres);
            }
        }
        let many = count as f64 > MIN_FILLED_SHARE * self.pixels.len() as f64;
        (many && second > 0.0 && largest > FILLED_RATIO * second).then_some(largest)
    }
}

#[derive(Debug)]
struct Usable(Arc<dyn Source>);

impl Source for Usable {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(UsableFrames(self.0.frames(camera)?)))
    }

    fn color_stem(&self, camera: usize, frame: usize) -> Option<String> {
        self.0.color_stem(camera, frame)
    }
}

struct UsableFrames<'a>(Box<dyn Frames + 'a>);

/// `None` for a damaged file; failures of the system stay errors.
fn unless_damaged<T>(read: Result<Option<T>, Error>) -> Result<Option<T>, Error> {
    match read {
        Err(error) if error.category() != Category::Internal => Ok(None),
        other => other,
    }
}

impl Frames for UsableFrames<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        unless_damaged(self.0.color(frame))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let mut depth = unless_damaged(self.0.depth(frame))?;
        if let Some(depth) = &mut depth
            && let Some(value) = depth.fill_value()
        {
            depth.pixels.iter_mut().filter(|d| **d == value).for_each(|d| *d = 0.0);
        }
        Ok(depth)
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        unless_damaged(self.0.mask(frame, region))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        unless_damaged(self.0.tracks())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_number_of_many_pixels_stands_for_no_depth() {
        let mut depth = DepthImage::filled(20, 20, 0.0);
        depth.pixels.iter_mut().enumerate().for_each(|(i, d)| *d = 0.5 + 0.001 * i as f32);
        assert_eq!(depth.fill_value(), None);
        depth.pixels[0] = 65.535;
        let mut large = DepthImage::filled(100, 100, 0.0);
        large.pixels[..400].copy_from_slice(&depth.pixels);
        assert_eq!(large.fill_value(), None, "one pixel may be an outlier");
        depth.pixels[..20].fill(65.535);
        assert_eq!(depth.fill_value(), Some(65.535));
        depth.pixels[..20].fill(1.2);
        assert_eq!(depth.fill_value(), None, "a wall is not far beyond all others");
        assert_eq!(DepthImage::filled(20, 20, 2.0).fill_value(), None);
    }

    #[derive(Debug)]
    struct Damaged;

    impl Source for Damaged {
        fn frames(&self, _: usize) -> Result<Box<dyn Frames + '_>, Error> {
            Ok(Box::new(Self))
        }
    }

    fn damage<T>() -> Result<Option<T>, Error> {
        Err(Error::Damaged { at: "a.png".to_owned(), fault: "it ends early".to_owned() })
    }

    impl Frames for Damaged {
        fn color(&mut self, _: usize) -> Result<Option<ColorImage>, Error> {
            damage()
        }

        fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
            let mut depth = DepthImage::filled(10, 10, 0.5);
            depth.pixels[..9].fill(65.535);
            if frame == 0 { Ok(Some(depth)) } else { damage() }
        }

        fn mask(&mut self, _: usize, _: Region) -> Result<Option<Mask>, Error> {
            damage()
        }

        fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
            damage()
        }
    }

    #[test]
    fn damaged_files_read_as_not_recorded() {
        let usable = Usable(Arc::new(Damaged));
        let mut frames = usable.frames(0).unwrap();
        let depth = frames.depth(0).unwrap().unwrap();
        assert_eq!((depth.pixels[0], depth.pixels[9]), (0.0, 0.5));
        assert_eq!(frames.depth(1).unwrap(), None);
        assert_eq!(frames.color(0).unwrap(), None);
        assert_eq!(frames.mask(0, Region::Object).unwrap(), None);
        assert_eq!(frames.tracks().unwrap(), None);
    }
}

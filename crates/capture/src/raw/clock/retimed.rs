//! Cameras that recorded at different rates, or began at different times, on common frames.

use std::{ops::Range, sync::Arc};

use crate::{
    Error, Limits,
    files::at_most,
    raw::{ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks, tracks::BYTES},
};

/// A camera's clock against the recording's frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::raw) struct Clock {
    /// Frames of the recording for each of the camera's images: 2 for a camera of half the rate.
    pub(in crate::raw) frames_per_image: f64,
    /// Frame of the recording in which the camera's image 0 was taken.
    pub(in crate::raw) offset: i64,
}

/// Most frames by which a camera may have begun earlier or later.
const MAX_OFFSET: u64 = 100_000;

impl Clock {
    /// The clocks of `cameras` cameras by their rates and offsets, each of which may be missing; `None`
    /// if all images are numbered by the frame. The recording has the highest rate.
    ///
    /// # Errors
    /// If a rate is no number above 0, or so low that frames are beyond counting.
    pub(in crate::raw) fn of(
        rates: &[f64],
        offsets: &[i64],
    ) -> Result<Option<(f64, Vec<Self>)>, Error> {
        let fps = rates.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is_plain = rates.iter().all(|rate| *rate == fps) && offsets.iter().all(|o| *o == 0);
        if is_plain {
            return Ok(None);
        }
        if let Some(rate) = rates.iter().find(|r| !(r.is_finite() && **r > 0.0 && fps / **r < 1e4))
        {
            return Err(Error::Lengths(format!(
                "a camera has {rate} frames per second, another {fps}: give the true rates"
            )));
        }
        if let Some(offset) = offsets.iter().find(|o| o.unsigned_abs() > MAX_OFFSET) {
            return Err(Error::Lengths(format!(
                "a camera is {offset} frames off: give the frame of the recording in which its first image was taken"
            )));
        }
        let clocks = rates.iter().zip(offsets);
        let clocks =
            clocks.map(|(rate, offset)| Self { frames_per_image: fps / rate, offset: *offset });
        Ok(Some((fps, clocks.collect())))
    }

    /// Frame of the recording in which an image was taken.
    pub(in crate::raw) fn frame(self, image: usize) -> i64 {
        (image as f64 * self.frames_per_image).round() as i64 + self.offset
    }

    /// Images by the frames `0..frame_count`, of `images` images.
    pub(in crate::raw) fn by_frame(self, images: usize, frame_count: usize) -> Vec<Option<usize>> {
        let mut by_frame = vec![None; frame_count];
        for image in 0..images {
            let place = usize::try_from(self.frame(image)).ok().and_then(|f| by_frame.get_mut(f));
            place.into_iter().for_each(|place| *place = Some(image));
        }
        by_frame
    }
}

/// Images of each camera by the frames of a recording, shape [camera][T]: an index into the source's own
/// frames, or nothing.
pub(in crate::raw) type Images = Vec<Vec<Option<usize>>>;

/// Frames from the first to the last in which every camera has an image: a twin begins where all see the
/// object.
///
/// # Errors
/// If no frame has an image of every camera.
pub(in crate::raw) fn shared(images: &Images) -> Result<Range<usize>, Error> {
    let has = |image: &Option<usize>| image.is_some();
    let start = images.iter().map(|of| of.iter().position(has)).max().flatten();
    let last = |of: &Vec<Option<usize>>| of.iter().rposition(has);
    let end = images.iter().map(last).min().flatten();
    match (start, end) {
        (Some(start), Some(end)) if start <= end && images.iter().all(|of| of.iter().any(has)) => {
            Ok(start..end + 1)
        }
        _ => Err(Error::Lengths(
            "the cameras have no time in common: correct their rates and offsets (docs/use/cameras.md#time)"
                .to_owned(),
        )),
    }
}

/// A source whose frames are chosen from those of another.
#[derive(Debug)]
pub(in crate::raw) struct Retimed {
    source: Arc<dyn Source>,
    images: Images,
    /// Most bytes of tracks.
    bytes: u64,
}

impl Retimed {
    /// The frames of `source` in another order.
    ///
    /// # Errors
    /// If there are more frames than a recording may have.
    pub(in crate::raw) fn new(
        source: Arc<dyn Source>,
        images: Images,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let most = images.iter().map(Vec::len).max().unwrap_or(0);
        at_most("frames of a recording", most, limits.recording_frames)?;
        Ok(Self { source, images, bytes: limits.total_bytes })
    }
}

impl Source for Retimed {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let images = self.images.get(camera).ok_or(Error::NoCamera(camera))?;
        Ok(Box::new(Reader { frames: self.source.frames(camera)?, images, bytes: self.bytes }))
    }

    fn files(&self) -> Vec<String> {
        self.source.files()
    }

    fn color_stem(&self, camera: usize, frame: usize) -> Option<String> {
        let image = self.images.get(camera)?.get(frame).copied().flatten()?;
        self.source.color_stem(camera, image)
    }
}

struct Reader<'a> {
    frames: Box<dyn Frames + 'a>,
    images: &'a [Option<usize>],
    bytes: u64,
}

impl Reader<'_> {
    fn image(&self, frame: usize) -> Option<usize> {
        self.images.get(frame).copied().flatten()
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        self.image(frame).map_or(Ok(None), |image| self.frames.color(image))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        self.image(frame).map_or(Ok(None), |image| self.frames.depth(image))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        self.image(frame).map_or(Ok(None), |image| self.frames.mask(image, region))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let Some(Tracks { count, points, visible }) = self.frames.tracks()? else {
            return Ok(None);
        };
        let bytes = (self.images.len() as u64).saturating_mul(count as u64).saturating_mul(BYTES);
        if bytes > self.bytes {
            return Err(Error::TooLarge { what: "tracks".to_owned(), bytes, limit: self.bytes });
        }
        let row = |image: Option<usize>| {
            let range = image.map(|image| image * count..(image + 1) * count);
            range.and_then(|range| Some((points.get(range.clone())?, visible.get(range)?)))
        };
        let mut retimed = Tracks { count, ..Tracks::default() };
        for image in self.images {
            match row(*image) {
                Some((points, visible)) => {
                    retimed.points.extend_from_slice(points);
                    retimed.visible.extend_from_slice(visible);
                }
                None => {
                    retimed.points.extend(std::iter::repeat_n([f32::NAN; 2], count));
                    retimed.visible.extend(std::iter::repeat_n(false, count));
                }
            }
        }
        Ok(Some(retimed))
    }
}

#[cfg(test)]
mod tests;

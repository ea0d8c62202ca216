//! Masks of a whole recording in memory, as run lengths: what a segmenter made, beside the recording
//! that it was made for.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
    sync::Arc,
};

use serde_json::json;
use zip::{ZipWriter, write::SimpleFileOptions};

use super::{
    ColorImage, DepthImage, Frames, Image, Mask, Recording, Region, Source, Tracks, encode,
};
use crate::Error;

/// Names of a camera's folders of masks, and the labels of what they show.
const FOLDERS: [(&str, Region); 2] = [("object", Region::Object), ("hand", Region::Manipulator)];

/// Masks of object and manipulator of all cameras and frames. A pixel shows one of them or neither.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskSet {
    cameras: Vec<CameraMasks>,
}

/// Masks of one camera.
#[derive(Clone, Debug, PartialEq, Eq)]
struct CameraMasks {
    /// Columns and rows.
    size: [usize; 2],
    /// Runs of equal pixels row by row; `None` where there is no mask. Shape [T].
    frames: Vec<Option<Box<[u8]>>>,
}

impl MaskSet {
    /// No masks, for cameras with images of these sizes as columns and rows, over a number of frames.
    pub fn new(sizes: impl IntoIterator<Item = [usize; 2]>, frame_count: usize) -> Self {
        let cameras = sizes.into_iter();
        let frames = || vec![None; frame_count];
        Self { cameras: cameras.map(|size| CameraMasks { size, frames: frames() }).collect() }
    }

    /// No masks, for the cameras and frames of a recording.
    pub fn empty(recording: &Recording) -> Self {
        let sizes = recording.cameras.iter().map(|camera| [camera.width, camera.height]);
        Self::new(sizes, recording.frame_count)
    }

    /// The masks that a recording has. A pixel in both masks shows the manipulator, which is in front
    /// of what it holds.
    ///
    /// # Errors
    /// If a mask is damaged.
    pub fn of(recording: &Recording) -> Result<Self, Error> {
        let mut set = Self::empty(recording);
        for camera in 0..recording.cameras.len() {
            let mut reader = recording.source.frames(camera)?;
            for frame in 0..recording.frame_count {
                let masks = FOLDERS.map(|(_, region)| reader.mask(frame, region));
                let [object, hand] = masks;
                set.set_masks(camera, frame, object?.as_ref(), hand?.as_ref());
            }
        }
        Ok(set)
    }

    /// `true` if no camera has a mask in any frame.
    pub fn is_empty(&self) -> bool {
        self.cameras.iter().all(|camera| camera.frames.iter().all(Option::is_none))
    }

    /// Sets what the pixels of an image show. An image of another size than the camera's, or of a
    /// camera or frame that does not exist, changes nothing.
    pub fn set(&mut self, camera: usize, frame: usize, shown: &Image<Option<Region>>) {
        let Some(of_camera) = self.cameras.get_mut(camera) else { return };
        let fits = of_camera.size == [shown.width, shown.height];
        if let Some(slot) = of_camera.frames.get_mut(frame)
            && fits
        {
            *slot = Some(runs(&shown.pixels));
        }
    }

    /// Sets the masks of an image; one that is absent shows nothing, and nothing is set without both.
    fn set_masks(
        &mut self,
        camera: usize,
        frame: usize,
        object: Option<&Mask>,
        hand: Option<&Mask>,
    ) {
        let Some(any) = object.or(hand) else { return };
        let shows = |mask: Option<&Mask>, i: usize| {
            mask.is_some_and(|mask| mask.pixels.get(i).copied().unwrap_or_default())
        };
        let shown = |i: usize| match (shows(object, i), shows(hand, i)) {
            (_, true) => Some(Region::Manipulator),
            (true, false) => Some(Region::Object),
            (false, false) => None,
        };
        let pixels = (0..any.pixels.len()).map(shown).collect();
        self.set(camera, frame, &Image { width: any.width, height: any.height, pixels });
    }

    /// What the pixels of an image show; `None` if it has no mask.
    pub fn shown(&self, camera: usize, frame: usize) -> Option<Image<Option<Region>>> {
        let of_camera = self.cameras.get(camera)?;
        let bytes = of_camera.frames.get(frame)?.as_deref()?;
        let [width, height] = of_camera.size;
        let mut pixels = Vec::with_capacity(width * height);
        for (length, shown) in Runs(bytes) {
            pixels.resize(pixels.len() + length, shown);
        }
        Some(Image { width, height, pixels })
    }

    /// The mask of a region in an image; `None` if it has no mask.
    pub fn mask(&self, camera: usize, frame: usize, region: Region) -> Option<Mask> {
        let Image { width, height, pixels } = self.shown(camera, frame)?;
        let pixels = pixels.into_iter().map(|shown| shown == Some(region)).collect();
        Some(Image { width, height, pixels })
    }

    /// Hands every mask as PNG to `put`, in the layout of a raw PhysTwin case, with its name inside
    /// the case: `mask/0/object/{stem}.png` and `mask/0/hand/{stem}.png` of camera 0 and so on, and
    /// `mask/mask_info_0.json`. `stem` names a frame of a camera.
    ///
    /// # Errors
    /// Those of `put`, or if an image has no pixels.
    pub fn export(
        &self,
        stem: impl Fn(usize, usize) -> String,
        mut put: impl FnMut(&str, Vec<u8>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for (camera, masks) in self.cameras.iter().enumerate() {
            let info = json!({ "object": "object", "hand": "hand" });
            put(&format!("mask/mask_info_{camera}.json"), info.to_string().into_bytes())?;
            for frame in 0..masks.frames.len() {
                for (folder, region) in FOLDERS {
                    let Some(mask) = self.mask(camera, frame, region) else { continue };
                    let name = format!("mask/{camera}/{folder}/{}.png", stem(camera, frame));
                    put(&name, encode::mask(&mask)?)?;
                }
            }
        }
        Ok(())
    }

    /// Writes the masks as a ZIP archive in that layout, each named by the number of its frame, with
    /// further files given by their names and contents.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_zip(&self, path: &Path, others: &[(&str, Vec<u8>)]) -> Result<(), Error> {
        let at = || path.display().to_string();
        let io = |source: std::io::Error| Error::Io { at: at(), source };
        let packed = |e: zip::result::ZipError| io(std::io::Error::other(e));
        let mut zip = ZipWriter::new(BufWriter::new(File::create(path).map_err(io)?));
        // PNG is compressed already.
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default());
        let mut put = |name: &str, bytes: Vec<u8>| {
            zip.start_file(name, options).map_err(packed)?;
            zip.write_all(&bytes).map_err(io)
        };
        self.export(|_, frame| frame.to_string(), &mut put)?;
        for (name, bytes) in others {
            put(name, bytes.clone())?;
        }
        zip.finish().map_err(packed)?.flush().map_err(io)
    }
}

/// Runs of equal pixels, each as one unsigned LEB128 number: `length * 4`, and 1 for the object or 2
/// for the manipulator.
fn runs(pixels: &[Option<Region>]) -> Box<[u8]> {
    let mut bytes = Vec::new();
    for run in pixels.chunk_by(|a, b| a == b) {
        let label = match run.first() {
            Some(Some(Region::Object)) => 1,
            Some(Some(Region::Manipulator)) => 2,
            _ => 0,
        };
        let mut number = run.len() as u64 * 4 + label;
        while number >= 0x80 {
            bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        bytes.push(number as u8);
    }
    bytes.into()
}

/// Reads what [`runs`] wrote.
struct Runs<'a>(&'a [u8]);

impl Iterator for Runs<'_> {
    type Item = (usize, Option<Region>);

    fn next(&mut self) -> Option<Self::Item> {
        let (mut number, mut shift) = (0_u64, 0);
        loop {
            let (byte, rest) = self.0.split_first()?;
            self.0 = rest;
            number |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                break;
            }
        }
        let shown = match number % 4 {
            1 => Some(Region::Object),
            2 => Some(Region::Manipulator),
            _ => None,
        };
        Some(((number / 4) as usize, shown))
    }
}

impl Recording {
    /// The recording with these masks, which replace those that it has.
    #[must_use]
    pub fn with_masks(self, masks: Arc<MaskSet>) -> Self {
        Self { source: Arc::new(Masked { source: self.source.clone(), masks }), ..self }
    }
}

/// A source whose masks are given.
#[derive(Debug)]
struct Masked {
    source: Arc<dyn Source>,
    masks: Arc<MaskSet>,
}

impl Source for Masked {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let frames = self.source.frames(camera)?;
        Ok(Box::new(MaskedFrames { frames, masks: &self.masks, camera }))
    }

    fn files(&self) -> Vec<String> {
        self.source.files()
    }

    fn color_stem(&self, camera: usize, frame: usize) -> Option<String> {
        self.source.color_stem(camera, frame)
    }
}

struct MaskedFrames<'a> {
    frames: Box<dyn Frames + 'a>,
    masks: &'a MaskSet,
    camera: usize,
}

impl Frames for MaskedFrames<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        self.frames.color(frame)
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        self.frames.depth(frame)
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        Ok(self.masks.mask(self.camera, frame, region))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        self.frames.tracks()
    }
}

#[cfg(test)]
mod tests;

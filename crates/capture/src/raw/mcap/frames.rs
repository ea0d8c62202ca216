//! The frames of an MCAP file, fetched one by one.

use std::fmt;

use super::{
    chunk::Chunk,
    images,
    messages::{self, ImageData, Kind, Wire},
    place::{Place, Store},
};
use crate::{
    Error,
    raw::{ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks, decode::Size},
};

/// Bytes of a message beside those of its pixels.
const OVERHEAD: u64 = 4 << 20;

/// Images of one kind from one camera.
#[derive(Debug)]
pub(super) struct Stream {
    pub(super) topic: String,
    pub(super) kind: Kind,
    pub(super) wire: Wire,
    /// Shape [T].
    pub(super) places: Vec<Option<Place>>,
    /// Metres of each 1 of depth, if that was declared.
    pub(super) unit_m: Option<f64>,
}

/// All images of one camera.
#[derive(Debug)]
pub(super) struct Streams {
    pub(super) size: Size,
    pub(super) color: Stream,
    pub(super) depth: Stream,
    pub(super) object: Option<Stream>,
    pub(super) manipulator: Option<Stream>,
}

/// A [`Source`] over an MCAP file.
pub(super) struct McapFrames {
    pub(super) store: Store,
    pub(super) chunks: Vec<Chunk>,
    pub(super) cameras: Vec<Streams>,
}

impl McapFrames {
    /// Pixels of all images.
    pub(super) fn pixels(&self) -> u64 {
        let of_stream = |s: &Stream| s.places.iter().flatten().count() as u64;
        let of_camera = |c: &Streams| {
            let masks = [&c.object, &c.manipulator].into_iter().flatten();
            let images: u64 = [&c.color, &c.depth].into_iter().chain(masks).map(of_stream).sum();
            (c.size[0] as u64).saturating_mul(c.size[1] as u64).saturating_mul(images)
        };
        self.cameras.iter().map(of_camera).fold(0, u64::saturating_add)
    }
}

impl fmt::Debug for McapFrames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("McapFrames").field("file", &self.store.name()).finish_non_exhaustive()
    }
}

impl Source for McapFrames {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let camera = self.cameras.get(camera).ok_or(Error::NoCamera(camera))?;
        Ok(Box::new(Reader { store: self.store.clone(), chunks: &self.chunks, camera }))
    }
}

/// Reads one camera.
struct Reader<'a> {
    store: Store,
    chunks: &'a [Chunk],
    camera: &'a Streams,
}

impl Reader<'_> {
    fn image<T>(
        &mut self,
        stream: &Stream,
        frame: usize,
        decode: impl FnOnce(&str, &ImageData<'_>, Size) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        let Some(Some(place)) = stream.places.get(frame) else { return Ok(None) };
        let size = self.camera.size;
        let cap = OVERHEAD + (size[0] as u64).saturating_mul(size[1] as u64).saturating_mul(16);
        let bytes = self.store.content(place, self.chunks, cap, stream.wire)?;
        let at = format!("{}, frame {frame}", stream.topic);
        let image = messages::image(stream.kind, stream.wire, &bytes).ok_or_else(|| {
            Error::Damaged { at: at.clone(), fault: "the message is not as its schema says".into() }
        })?;
        decode(&at, &image, size).map(Some)
    }
}

impl Frames for Reader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        self.image(&self.camera.color, frame, images::color)
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let unit_m = self.camera.depth.unit_m;
        let decode = |at: &str, image: &ImageData<'_>, size| images::depth(at, image, size, unit_m);
        self.image(&self.camera.depth, frame, decode)
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let stream = match region {
            Region::Object => &self.camera.object,
            Region::Manipulator => &self.camera.manipulator,
        };
        match stream {
            Some(stream) => self.image(stream, frame, images::mask),
            None => Ok(None),
        }
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(None)
    }
}

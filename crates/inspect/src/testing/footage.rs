//! Images of the scene without any fault, rendered once: most tests change only the calibration.

use std::sync::{Arc, LazyLock};

use bendtwin_capture::{
    Error,
    raw::{ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks},
};

use super::{FRAMES, healthy_scene};

/// The images of the scene without any fault, rendered once for all tests.
pub(super) static HEALTHY: LazyLock<Arc<Footage>> = LazyLock::new(|| {
    let scene = healthy_scene();
    let film = |camera| {
        let mut frames = scene.frames(camera).unwrap();
        let images = |frame| Images {
            color: frames.color(frame).unwrap().unwrap(),
            depth: frames.depth(frame).unwrap().unwrap(),
            object: frames.mask(frame, Region::Object).unwrap().unwrap(),
            manipulator: frames.mask(frame, Region::Manipulator).unwrap().unwrap(),
        };
        let images = (0..FRAMES).map(images).collect();
        (images, frames.tracks().unwrap())
    };
    Arc::new(Footage((0..3).map(film).collect()))
});

/// Rendered images and tracks of each camera.
#[derive(Debug)]
pub(super) struct Footage(Vec<(Vec<Images>, Option<Tracks>)>);

/// The images of one frame.
#[derive(Debug)]
struct Images {
    color: ColorImage,
    depth: DepthImage,
    object: Mask,
    manipulator: Mask,
}

impl Source for Footage {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        let (images, tracks) = &self.0[camera];
        Ok(Box::new(FootageReader { images, tracks }))
    }
}

struct FootageReader<'a> {
    images: &'a [Images],
    tracks: &'a Option<Tracks>,
}

impl Frames for FootageReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        Ok(self.images.get(frame).map(|i| i.color.clone()))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        Ok(self.images.get(frame).map(|i| i.depth.clone()))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        Ok(self.images.get(frame).map(|i| match region {
            Region::Object => i.object.clone(),
            Region::Manipulator => i.manipulator.clone(),
        }))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        Ok(self.tracks.clone())
    }
}

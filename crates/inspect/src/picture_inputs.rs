//! The material that pictures are drawn from: crops of a few frames and the first image of each
//! camera.

use bendtwin_capture::raw::{Camera, ColorImage, Recording};
use bendtwin_core::{Capture, Environment};

use crate::scan::{COMPARED_CAMERAS, CameraScan, crop::Crop};

/// Crops and first images of a recording's cameras; no cameras for an observed capture.
#[derive(Clone, Debug)]
pub(crate) struct PictureInputs {
    pub(crate) environment: Environment,
    pub(crate) cameras: Vec<CameraPictures>,
    /// The points of a capture.
    pub(crate) capture: Option<Capture>,
}

/// A camera's crops and first image.
#[derive(Clone, Debug)]
pub(crate) struct CameraPictures {
    pub(crate) camera: Camera,
    pub(crate) crops: Vec<Crop>,
    /// The first colour image and its frame.
    pub(crate) first_image: Option<(usize, ColorImage)>,
}

impl Default for PictureInputs {
    fn default() -> Self {
        Self { environment: Environment::Z_UP, cameras: Vec::new(), capture: None }
    }
}

impl PictureInputs {
    pub(crate) fn of(recording: &Recording, scans: Vec<CameraScan>) -> Self {
        let cameras = recording.cameras.iter().zip(scans).take(COMPARED_CAMERAS);
        let cameras = cameras.map(|(camera, scan)| CameraPictures {
            camera: camera.clone(),
            crops: scan.crops,
            first_image: scan.first_image,
        });
        Self { environment: recording.environment, cameras: cameras.collect(), capture: None }
    }
}

//! What pictures are drawn from: sketches of a few frames and the first image of each camera.

use bendtwin_capture::raw::{Camera, ColorImage, Recording};
use bendtwin_core::{Capture, Environment};

use crate::watch::{COMPARED_CAMERAS, Log, sketch::Sketch};

/// Sketches and stills of a recording; empty for an observed capture.
#[derive(Clone, Debug)]
pub(crate) struct Gallery {
    pub(crate) environment: Environment,
    pub(crate) walls: Vec<Wall>,
    /// The points of a capture.
    pub(crate) capture: Option<Capture>,
}

/// One camera's pictures.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) camera: Camera,
    pub(crate) sketches: Vec<Sketch>,
    /// The first colour image and its frame.
    pub(crate) still: Option<(usize, ColorImage)>,
}

impl Default for Gallery {
    fn default() -> Self {
        Self { environment: Environment::Z_UP, walls: Vec::new(), capture: None }
    }
}

impl Gallery {
    pub(crate) fn of(recording: &Recording, logs: Vec<Log>) -> Self {
        let walls = recording.cameras.iter().zip(logs).take(COMPARED_CAMERAS);
        let walls = walls.map(|(camera, log)| Wall {
            camera: camera.clone(),
            sketches: log.sketches,
            still: log.still,
        });
        Self { environment: recording.environment, walls: walls.collect(), capture: None }
    }
}

//! Paths of the object's and of the manipulator's middle over the frames, as each camera sees them.

use bendtwin_capture::raw::Recording;

use crate::{
    scan::{CameraScan, mask::MaskStats},
    statistics::median,
    vector::{Vector, distance, to_world},
};

/// The path of one thing as one camera saw it [m]; `None` where it did not, shape [T].
pub(crate) type Path = Vec<Option<Vector>>;

/// The paths as all cameras saw them.
#[derive(Debug, Default)]
pub(crate) struct Paths {
    pub(crate) object: Vec<Path>,
    pub(crate) manipulator: Vec<Path>,
}

impl Paths {
    pub(crate) fn of(recording: &Recording, scans: &[CameraScan]) -> Self {
        let path = |which: fn(&crate::scan::FrameStats) -> Option<&MaskStats>| {
            let one = |(camera, scan): (&bendtwin_capture::raw::Camera, &CameraScan)| {
                let frames = scan.frames.iter().enumerate();
                frames
                    .map(|(frame, stats)| {
                        let middle = which(stats)?.surface?.middle;
                        let at = to_world(camera.pose(frame), middle);
                        at.iter().all(|x| x.is_finite()).then_some(at)
                    })
                    .collect()
            };
            recording.cameras.iter().zip(scans).map(one).collect()
        };
        Self { object: path(|g| g.object.as_ref()), manipulator: path(|g| g.manipulator.as_ref()) }
    }
}

/// Largest distance of a path from its start [m], by the median of the cameras that saw it.
pub(crate) fn travel(paths: &[Path]) -> Option<f64> {
    median(paths.iter().filter_map(|path| {
        let start = path.iter().flatten().next()?;
        path.iter().flatten().map(|p| distance(*p, *start)).max_by(f64::total_cmp)
    }))
}

/// Distances moved from one frame to the next [m], by the median of the cameras; `None` where none
/// saw both frames.
pub(crate) fn steps(paths: &[Path], frames: usize) -> Vec<Option<f64>> {
    (0..frames).map(|frame| median(paths.iter().filter_map(|path| step(path, frame)))).collect()
}

/// Distance that one camera saw a thing move from the frame before to this one [m].
pub(crate) fn step(path: &Path, frame: usize) -> Option<f64> {
    let before = *path.get(frame.checked_sub(1)?)?;
    Some(distance(before?, (*path.get(frame)?)?))
}

//! Where the middle of the object and of the manipulator is in every frame, as each camera sees it.

use bendtwin_capture::raw::Recording;

use crate::{
    statistics::median,
    vector::{Vector, distance, to_world},
    watch::{Log, patch::Patch},
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
    pub(crate) fn of(recording: &Recording, logs: &[Log]) -> Self {
        let path = |which: fn(&crate::watch::Glance) -> Option<&Patch>| {
            let one = |(camera, log): (&bendtwin_capture::raw::Camera, &Log)| {
                let glances = log.glances.iter().enumerate();
                glances
                    .map(|(frame, glance)| {
                        let middle = which(glance)?.surface?.middle;
                        let at = to_world(camera.pose(frame), middle);
                        at.iter().all(|x| x.is_finite()).then_some(at)
                    })
                    .collect()
            };
            recording.cameras.iter().zip(logs).map(one).collect()
        };
        Self { object: path(|g| g.object.as_ref()), manipulator: path(|g| g.manipulator.as_ref()) }
    }
}

/// How far a path gets from where it starts [m], by the median of the cameras that saw it.
pub(crate) fn travel(paths: &[Path]) -> Option<f64> {
    median(paths.iter().filter_map(|path| {
        let start = path.iter().flatten().next()?;
        path.iter().flatten().map(|p| distance(*p, *start)).max_by(f64::total_cmp)
    }))
}

/// How far things move from one frame to the next [m], by the median of the cameras; `None` where none saw both frames.
pub(crate) fn steps(paths: &[Path], frames: usize) -> Vec<Option<f64>> {
    (0..frames).map(|frame| median(paths.iter().filter_map(|path| step(path, frame)))).collect()
}

/// How far one camera saw a thing move into a frame [m].
pub(crate) fn step(path: &Path, frame: usize) -> Option<f64> {
    let before = *path.get(frame.checked_sub(1)?)?;
    Some(distance(before?, (*path.get(frame)?)?))
}

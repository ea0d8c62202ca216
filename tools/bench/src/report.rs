//! Results of a benchmark, as data. Times are in seconds unless a name says otherwise; unknown
//! values are `null`.

use serde::Serialize;

use crate::{bound::IssueBound, fit::FitRun};

/// All results of one run of the benchmark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Version of the software.
    pub build: String,
    /// The device that computed.
    pub device: DeviceName,
    /// Basis of the issue bound; `None` if the device is not known.
    pub bound: Option<IssueBound>,
    /// Method of measurement, in sentences for the reader.
    pub method: String,
    /// Results by scene, in the order of measuring.
    pub scenes: Vec<SceneReport>,
}

/// The device, as described by its backend.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceName {
    /// `cpu` or `cuda`.
    pub kind: String,
    /// Name for people.
    pub name: String,
    /// Instances that run concurrently.
    pub lanes: usize,
}

/// Results of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneReport {
    /// Name of the scene.
    pub name: &'static str,
    /// True if it has triplets.
    pub bending: bool,
    /// Nodes.
    pub nodes: usize,
    /// Springs, those to control points included.
    pub springs: usize,
    /// Springs to control points.
    pub control_springs: usize,
    /// Triplets.
    pub triplets: usize,
    /// Control points.
    pub controls: usize,
    /// Substeps a frame.
    pub substeps: u32,
    /// Length of a substep [s].
    pub dt_s: f64,
    /// Mean stiffness of its springs [N per unit strain].
    pub stiffness: f32,
    /// Time to load the model.
    pub load_s: f64,
    /// Rollouts, by size of the batch.
    pub forward: Vec<Measured>,
    /// Gradients of windows of one frame, by size of the batch.
    pub gradient: Vec<Measured>,
    /// Memory in use, or at most in use, after rollouts and gradients [bytes].
    pub memory_bytes: Option<u64>,
    /// Whole fits, by scheme.
    pub fits: Vec<FitRun>,
}

/// Measurement of a batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Instances.
    pub batch: usize,
    /// Result; `None` if it was left out.
    pub run: Option<Run>,
    /// Reason why it was left out: too slow, or too large for the device.
    pub left_out: Option<String>,
}

/// Times of a batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// The backend's description of how it ran; `None` if it has one way only.
    pub shape: Option<String>,
    /// Frames of every instance.
    pub frames: usize,
    /// Calls timed, after one that warms up.
    pub repeats: usize,
    /// Median time of a call.
    pub median_s: f64,
    /// Shortest time of a call.
    pub best_s: f64,
    /// Frames a second, all instances together, by the median.
    pub frames_per_s: f64,
    /// Time of a frame of the whole batch [ms], by the median.
    pub frame_ms: f64,
    /// Time of a substep of the whole batch [us], by the median.
    pub us_per_substep: f64,
    /// The least time of a substep that the issue bound allows [us].
    pub bound_us_per_substep: Option<f64>,
    /// Bound over measured, 0..=1.
    pub of_bound: Option<f64>,
}

impl Measured {
    pub(crate) fn left_out(batch: usize, why: String) -> Self {
        Self { batch, run: None, left_out: Some(why) }
    }
}

impl SceneReport {
    /// The measurement of a batch of that size in a list, if it was made.
    pub fn run_of(list: &[Measured], batch: usize) -> Option<&Run> {
        list.iter().find(|m| m.batch == batch).and_then(|m| m.run.as_ref())
    }
}

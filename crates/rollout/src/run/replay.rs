//! The state of a twin in a frame of a capture: the twin follows the capture's own controls up to that
//! frame, as its ingest observed them.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_core::{CancelToken, Capture, Point, Twin};
use bendtwin_engine::{
    Backend, Objective,
    backend::{Instance, Outputs},
    model::State,
};
use bendtwin_eval::{check_capture, initial_state};

use crate::{
    error::Error,
    request::initial::{CaptureFrame, Start},
    twin::warm::Warm,
};

/// Memory of a control point in a frame of a replay: as stored, and as the engine reads it.
const REPLAYED: u64 = 40;

/// The part of a capture's sequence that a twin needs.
struct Motion {
    start_frame: usize,
    start: Arc<State>,
    /// Control points [m], shape [T, C, 3].
    controls: Vec<Point>,
    frame_count: usize,
}

/// The motions of all sequences of a capture, which are far smaller than what was observed.
pub struct Motions(Vec<Motion>);

impl Motions {
    /// The motions of a capture that a twin can follow.
    ///
    /// # Errors
    /// If its time base or its control points are others than the twin's.
    pub fn new(twin: &Twin, capture: &Capture) -> Result<Self, Error> {
        check_capture(capture).map_err(|e| Error::Capture(e.to_string()))?;
        if (twin.timing.fps - capture.fps).abs() > 1e-6 * capture.fps {
            return Err(Error::Capture(format!(
                "it has {} frames a second, the twin {}",
                capture.fps, twin.timing.fps
            )));
        }
        let controls = twin.graph.control_count();
        let sequences = capture.sequences.iter().map(|sequence| {
            if sequence.control_count() != controls {
                return Err(Error::Capture(format!(
                    "sequence `{}` has {} control points, the twin has {controls}",
                    sequence.name,
                    sequence.control_count()
                )));
            }
            Ok(Motion {
                start_frame: sequence.start_frame(),
                start: Arc::new(initial_state(&twin.graph, capture.fps, sequence)),
                controls: sequence.controls.clone(),
                frame_count: sequence.frame_count,
            })
        });
        sequences.collect::<Result<_, Error>>().map(Self)
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> u64 {
        let size = |m: &Motion| 12 * m.controls.len() + 24 * m.start.positions.len();
        self.0.iter().map(size).sum::<usize>() as u64
    }

    /// Memory that a replay takes [bytes].
    pub fn replay_bytes(&self) -> u64 {
        let controls = self.0.iter().map(|m| m.controls.len() as u64).max().unwrap_or(0);
        controls.saturating_mul(REPLAYED)
    }
}

/// The twin's state in a frame of a capture that it follows.
///
/// # Errors
/// If the capture has no such frame, the way there is more work than `work_limit`, or the twin diverges
/// on it.
pub fn replay(
    warm: &Warm,
    Motions(motions): &Motions,
    at: CaptureFrame,
    work_limit: u64,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<Start, Error> {
    let Some(motion) = motions.get(at.sequence) else {
        let fault = format!(
            "is {}: the capture has {} sequences (counted from 0)",
            at.sequence,
            motions.len()
        );
        return Err(Error::field("initial.capture_frame.sequence", fault));
    };
    if !(motion.start_frame..motion.frame_count).contains(&at.frame) {
        let fault = format!(
            "is {}: the sequence can be entered in frames {}..={}",
            at.frame,
            motion.start_frame,
            motion.frame_count.saturating_sub(1)
        );
        return Err(Error::field("initial.capture_frame.frame", fault));
    }
    let frames = at.frame - motion.start_frame;
    let (graph, timing) = (&warm.twin.graph, warm.twin.timing);
    let elements = (graph.node_count() + graph.springs.len() + graph.triplets.len()) as u128;
    let work = frames as u128 * u128::from(timing.substeps) * elements;
    if work > u128::from(work_limit) {
        return Err(Error::Request(rollout::Error::TooLarge {
            what: "the work of the replay",
            asked: u64::try_from(work).unwrap_or(u64::MAX),
            limit: work_limit,
            advice: "start at an earlier frame",
        }));
    }
    let width = graph.control_count();
    let row = |frame: usize| &motion.controls[frame * width..(frame + 1) * width];
    let controls = Arc::new(row(at.frame).to_vec());
    if frames == 0 {
        return Ok(Start::new(Arc::clone(&motion.start), controls));
    }
    let instance = Instance {
        model: warm.loaded.clone(),
        initial: Arc::clone(&motion.start),
        controls: Arc::new(
            motion.controls[motion.start_frame * width..(at.frame + 1) * width].to_vec(),
        ),
        frames,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs = Outputs { final_state: true, ..Outputs::default() };
    let rollout = backend.roll_out(&[instance], &outputs, cancel)?.into_iter().next();
    let rollout = rollout.unwrap_or_default();
    if let Some(divergence) = rollout.diverged {
        return Err(Error::ReplayDiverged { frame: motion.start_frame + divergence.frame });
    }
    match rollout.final_state {
        Some(state) => Ok(Start::new(Arc::new(state), controls)),
        None => {
            Err(bendtwin_engine::Error::Device("no final state was returned".to_owned()).into())
        }
    }
}

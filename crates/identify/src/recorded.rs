//! The recordings that a twin was fitted to, as scenes: what was observed of them, and how much it
//! weighs.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, Graph, Sequence, Skin, Twin, identifiability::Quantity};
use bendtwin_engine::{Backend, Model, backend, model::State};
use bendtwin_eval::{Error, Placement, initial_state, is_own_capture};

use crate::{
    directions::Direction,
    noise::{Noise, Residuals, residual},
    response::{Sample, Scene, Variation},
};

/// Frames of a sequence from its start that are simulated, at most.
const MOST_FRAMES: usize = 120;
/// Training sequences of a recording that are simulated, spread evenly; the others are taken to say as
/// much.
const MOST_SEQUENCES: usize = 2;
/// Other recordings that are simulated; the rest are taken to say as much.
const MOST_OTHERS: usize = 3;
/// Tracked points that are observed, spread evenly.
const MOST_TRACKED: usize = 150;
/// Approximate number of records of a sequence, from which the frames between two records follow.
const RECORDS: usize = 24;
/// Records of the frames after the training frames, at most.
const FUTURE_RECORDS: usize = 5;

/// Training frames of a sequence, and the frames after them.
pub(crate) struct SequenceRecords {
    pub(crate) scene: Scene,
    /// True for a sequence of the twin's own capture.
    pub(crate) is_own: bool,
    /// Frames between two records.
    pub(crate) every: usize,
    /// Observed points in records of the training frames.
    pub(crate) training: Vec<Sample>,
    /// Records after the training frames: frames of the scene.
    pub(crate) future: Vec<usize>,
    /// Training frames, of which `training` are samples.
    pub(crate) training_frames: usize,
    /// Number of tracked points that may be observed.
    pub(crate) tracked: usize,
    /// The residual; none for a sequence that is held out.
    pub(crate) noise: Option<Noise>,
    /// Number of sequences that it stands for.
    pub(crate) stands_for: f64,
}

/// Sequences of the recordings of a capture that a twin was fitted to. Recordings that the twin cannot be
/// registered to, and sequences in which it diverges, are left out.
pub(crate) fn recorded(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    cancel: &CancelToken,
) -> Result<Vec<SequenceRecords>, Error> {
    let mut all = Vec::new();
    let own = |r: &&Capture| is_own_capture(twin, r);
    for recording in capture.recordings().filter(own) {
        let chosen = chosen(&recording.sequences, true);
        for (sequence, stands_for) in chosen {
            let initial = initial_state(&twin.graph, recording.fps, sequence);
            let place = Place { twin, initial, is_own: true, stands_for };
            all.extend(place.recorded(backend, sequence, cancel)?);
        }
    }
    let others: Vec<&Capture> = capture.recordings().filter(|r| !own(r)).collect();
    let count = others.len().min(MOST_OTHERS);
    let share = others.len() as f64 / count.max(1) as f64;
    for recording in (0..count).map(|i| others[i * others.len() / count]) {
        for (sequence, stands_for) in chosen(&recording.sequences, false).into_iter().take(1) {
            let placed = match Placement::new(&twin.graph, &twin.skin, recording, sequence, cancel)
            {
                Ok(placed) => placed,
                Err(_) if !cancel.is_cancelled() => continue,
                Err(error) => return Err(error),
            };
            let there = placed.twin(twin, recording, sequence)?;
            let initial = State {
                positions: placed.positions,
                velocities: placed.velocities,
                ..State::default()
            };
            let stands_for = stands_for * share;
            let place = Place { twin: &there, initial, is_own: false, stands_for };
            all.extend(place.recorded(backend, sequence, cancel)?);
        }
    }
    Ok(all)
}

/// Some of the training sequences with the number of them that each stands for, and where they may be
/// asked about a held-out one.
fn chosen(sequences: &[Sequence], with_held_out: bool) -> Vec<(&Sequence, f64)> {
    let (held_out, training): (Vec<&Sequence>, Vec<&Sequence>) =
        sequences.iter().partition(|s| s.is_held_out());
    let count = training.len().min(MOST_SEQUENCES);
    let share = training.len() as f64 / count.max(1) as f64;
    let spread = (0..count).map(|i| (training[i * training.len() / count], share));
    let held_out = held_out.into_iter().take(usize::from(with_held_out)).map(|s| (s, 0.0));
    spread.chain(held_out).collect()
}

/// A twin at the start of a sequence.
struct Place<'a> {
    twin: &'a Twin,
    initial: State,
    is_own: bool,
    stands_for: f64,
}

impl Place<'_> {
    fn recorded(
        self,
        backend: &dyn Backend,
        sequence: &Sequence,
        cancel: &CancelToken,
    ) -> Result<Option<SequenceRecords>, Error> {
        let Self { twin, initial, is_own, stands_for } = self;
        let start = sequence.start_frame();
        let after_start = |end: usize| end.saturating_sub(start + 1);
        let frames = after_start(sequence.frame_count).min(MOST_FRAMES);
        let training_frames = after_start(sequence.train_frame_count).min(frames);
        // Frames after the training frames ask nothing where they are too far away.
        let frames = if is_own { frames } else { training_frames };
        if frames == 0 {
            return Ok(None);
        }
        let every = (frames / RECORDS).max(1);
        let count = sequence.control_count();
        let rows = start * count..(start + frames + 1) * count;
        let scene = Scene {
            model: Model::from(twin),
            reduction: None,
            hands: twin.hands(),
            initial: Arc::new(initial),
            controls: Arc::new(sequence.controls.get(rows).unwrap_or_default().to_vec()),
            frames,
            world: Arc::default(),
            motion: Arc::default(),
        };
        let points = tracked(twin);
        let skin = twin.skin.select(&points);
        let Some(base) = scene.base(backend, cancel)? else { return Ok(None) };
        let nodes = twin.graph.node_count();
        let seen = |frame: usize| -> Vec<bool> {
            let (points, visible) =
                (sequence.points_at(start + frame), sequence.visible_at(start + frame));
            let valid = sequence.motion_valid_at(start + frame);
            let is_seen = |p: &u32| {
                let p = *p as usize;
                let finite = points.get(p).is_some_and(|x| x.iter().all(|v| v.is_finite()));
                finite && visible[p] && valid[p]
            };
            skin.observed_points.iter().map(is_seen).collect()
        };
        let residuals = |frame: usize| -> Residuals {
            let at = base.positions.get((frame - 1) * nodes..frame * nodes).unwrap_or_default();
            if at.is_empty() {
                return Vec::new();
            }
            let (predicted, observed) = (skin.positions(at), sequence.points_at(start + frame));
            let of = |((predicted, p), seen): ((_, &u32), bool)| {
                seen.then(|| residual(predicted, observed[*p as usize]))
            };
            predicted.into_iter().zip(&skin.observed_points).zip(seen(frame)).map(of).collect()
        };
        let all: Vec<Residuals> = (1..=training_frames).map(residuals).collect();
        let noise = Noise::of(&all);
        let records = (every..=frames).step_by(every);
        let sample = |frame: usize| {
            let seen = seen(frame);
            let of: Vec<usize> = (0..points.len()).filter(|&i| seen[i]).collect();
            (!of.is_empty()).then(|| Sample { frame, skin: Arc::new(skin.select(&of)) })
        };
        let training =
            records.clone().filter(|f| *f <= training_frames).filter_map(sample).collect();
        let after: Vec<usize> = records.filter(|f| *f > training_frames).collect();
        let stride = after.len().div_ceil(FUTURE_RECORDS).max(1);
        Ok(Some(SequenceRecords {
            scene,
            is_own,
            every,
            training,
            future: after.into_iter().rev().step_by(stride).rev().collect(),
            training_frames,
            tracked: points.len(),
            noise,
            stands_for,
        }))
    }
}

impl SequenceRecords {
    /// The directions that the recording has no part in: grips of hands that were not there.
    pub(crate) fn has(&self, direction: &Direction) -> bool {
        self.is_own || direction.quantity != Quantity::Grip
    }

    /// Unknowns of the recording itself beside the directions: where its hands are, and the grips
    /// of hands that are not the twin's.
    pub(crate) fn nuisances(&self) -> Vec<Variation> {
        let hands = self.scene.hands.iter().max().map_or(0, |h| h + 1);
        let offsets = (0..hands)
            .flat_map(|hand| (0..3).map(move |axis| Variation::HandOffset { hand, axis }));
        let grip = |hand| Direction { quantity: Quantity::Grip, region: None, hand: Some(hand) };
        let grips = (0..hands).filter(|_| !self.is_own).map(|h| Variation::Along(grip(h)));
        offsets.chain(grips).collect()
    }
}

/// Points of a twin's skin that are tracked and not prescribed by a control point, some of them.
fn tracked(twin: &Twin) -> Vec<usize> {
    let (skin, graph): (&Skin, &Graph) = (&twin.skin, &twin.graph);
    let pinned: Vec<u32> =
        graph.pins.iter().map(|pin| graph.observed_points[pin.node as usize]).collect();
    let is_free = |&m: &usize| {
        let p = skin.observed_points[m];
        p != Graph::NOT_OBSERVED && !pinned.contains(&p)
    };
    let all: Vec<usize> = (0..skin.len()).filter(is_free).collect();
    let stride = all.len().div_ceil(MOST_TRACKED).max(1);
    all.into_iter().step_by(stride).collect()
}

/// A failure of the backend as one of the evaluation.
pub(crate) fn failed(error: backend::Error) -> Error {
    Error::Backend(error)
}

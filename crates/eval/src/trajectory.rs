//! Predictions: every sequence of a capture simulated from its start to its end, never re-seeded
//! from data.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, Graph, Point, Sequence, Twin};
use bendtwin_engine::{
    Backend, Loaded, Model, Objective,
    backend::{Divergence, Instance, Outputs},
    model::State,
};

use crate::Error;

/// Predicted node positions over one sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// Frame of the sequence in which it starts.
    pub start_frame: usize,
    /// Number of nodes N.
    pub node_count: usize,
    /// Positions [m], shape [frames, N, 3]; row 0 belongs to `start_frame`. After a divergence the
    /// last finite frame is repeated, so that every frame of the sequence has a row.
    pub positions: Vec<Point>,
    /// The divergence of the simulation, if any.
    pub diverged: Option<Divergence>,
}

impl Trajectory {
    /// Node positions in a frame of the sequence, shape [N, 3]; `None` before the start and after
    /// the end.
    pub fn at(&self, frame: usize) -> Option<&[Point]> {
        let row = frame.checked_sub(self.start_frame)?;
        let first = row.checked_mul(self.node_count)?;
        self.positions.get(first..first.checked_add(self.node_count)?)
    }
}

/// Simulates every sequence of a capture from its start, as one batch cut into slices that suit the
/// device.
///
/// # Errors
/// If the twin does not fit the capture, on cancellation, or if the backend fails.
pub fn predict(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    cancel: &CancelToken,
) -> Result<Vec<Trajectory>, Error> {
    check(twin, capture)?;
    predict_from(backend, twin, capture.fps, &capture.sequences, None, cancel)
}

/// Simulates checked sequences, from a given state if there is one.
pub(crate) fn predict_from(
    backend: &dyn Backend,
    twin: &Twin,
    fps: f64,
    sequences: &[Sequence],
    start: Option<&Arc<State>>,
    cancel: &CancelToken,
) -> Result<Vec<Trajectory>, Error> {
    let loaded = backend.load(Arc::new(Model::from(twin)))?;
    let mut trajectories = Vec::with_capacity(sequences.len());
    for slice in sequences.chunks(slice_len(backend)) {
        let whole = |s| {
            let own = instance(&loaded, fps, s, Objective::default());
            match start {
                Some(start) => Instance { initial: start.clone(), ..own },
                None => own,
            }
        };
        let batch: Vec<Instance> = slice.iter().map(whole).collect();
        let outputs = Outputs { every: 1, initial: true, ..Outputs::default() };
        let rollouts = backend.roll_out(&batch, &outputs, cancel)?;
        for ((rollout, sequence), instance) in rollouts.into_iter().zip(slice).zip(&batch) {
            let node_count = twin.graph.node_count();
            let mut positions = rollout.positions;
            if positions.is_empty() {
                positions.clone_from(&instance.initial.positions);
            }
            let wanted = (instance.frames + 1) * node_count;
            while node_count > 0 && positions.len() < wanted {
                positions.extend_from_within(positions.len() - node_count..);
            }
            trajectories.push(Trajectory {
                start_frame: sequence.start_frame(),
                node_count,
                positions,
                diverged: rollout.diverged,
            });
        }
    }
    Ok(trajectories)
}

/// Number of instances to submit together: enough to fill the device, few enough that others who
/// share it are served in between.
pub fn slice_len(backend: &dyn Backend) -> usize {
    2 * backend.device().lanes.max(1)
}

/// A rollout of a whole sequence from its start.
pub fn instance(model: &Loaded, fps: f64, sequence: &Sequence, objective: Objective) -> Instance {
    let start = sequence.start_frame();
    let controls = sequence.controls.get(start * sequence.control_count()..).unwrap_or_default();
    Instance {
        initial: Arc::new(initial_state(&model.model().graph, fps, sequence)),
        model: model.clone(),
        controls: Arc::new(controls.to_vec()),
        frames: sequence.frame_count.saturating_sub(start + 1),
        objective,
        world: Arc::default(),
        motion: Arc::default(),
    }
}

/// The state in which a rollout of a sequence starts.
///
/// A node that is a point seen in the start frame stands there. Any other node is displaced from
/// its rest position as the nearest node (at rest) that was seen. With two start frames the
/// velocity is the difference to the frame before, otherwise zero.
pub fn initial_state(graph: &Graph, fps: f64, sequence: &Sequence) -> State {
    let start = sequence.start_frame();
    if start >= sequence.frame_count {
        return State::rest(graph);
    }
    let (points, visible) = (sequence.points_at(start), sequence.visible_at(start));
    let before = start.checked_sub(1).map(|f| (sequence.points_at(f), sequence.visible_at(f)));
    let seen = |rows: (&[Point], &[bool]), p: u32| {
        let p = p as usize;
        let point = rows.0.get(p).copied().filter(|x| x.iter().all(|v| v.is_finite()));
        point.filter(|_| rows.1.get(p) == Some(&true))
    };
    let motion = |i: usize| {
        let p = graph.observed_points[i];
        let now = seen((points, visible), p)?;
        let velocity = match before {
            Some(rows) => seen(rows, p).map(|x| difference(now, x).map(|d| d * fps as f32)),
            None => Some([0.0; 3]),
        };
        Some((difference(now, graph.rest_positions[i]), velocity.unwrap_or_default()))
    };
    let known: Vec<Option<(Point, Point)>> = (0..graph.node_count()).map(motion).collect();
    let mut state = State::rest(graph);
    for i in 0..graph.node_count() {
        let guide = known[i].or_else(|| nearest_known(graph, &known, i));
        let Some((displacement, velocity)) = guide else { continue };
        state.positions[i] = std::array::from_fn(|a| graph.rest_positions[i][a] + displacement[a]);
        state.velocities[i] = velocity;
    }
    state
}

fn nearest_known(
    graph: &Graph,
    known: &[Option<(Point, Point)>],
    node: usize,
) -> Option<(Point, Point)> {
    let at = graph.rest_positions[node];
    let distance = |i: usize| {
        let d = difference(graph.rest_positions[i], at);
        d.iter().map(|x| x * x).sum::<f32>()
    };
    let candidates = known.iter().enumerate().filter_map(|(i, k)| k.map(|k| (distance(i), k)));
    candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k)
}

pub(crate) fn difference(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Checks that shapes agree, so that no later code has to.
pub(crate) fn check(twin: &Twin, capture: &Capture) -> Result<(), Error> {
    check_capture(capture)?;
    if (twin.timing.fps - capture.fps).abs() > 1e-6 * capture.fps.abs() {
        return Err(Error::Mismatch(format!(
            "it runs at {} frames a second, the capture at {}",
            twin.timing.fps, capture.fps
        )));
    }
    let points = capture.object.point_count;
    let beyond = |p: &&u32| **p != Graph::NOT_OBSERVED && **p as usize >= points;
    if let Some(p) = twin.graph.observed_points.iter().find(beyond) {
        return Err(Error::Mismatch(format!("a node is point {p} of {points}")));
    }
    for s in &capture.sequences {
        if s.control_count() != twin.graph.control_count() {
            return Err(Error::Mismatch(format!(
                "it has {} control points, sequence `{}` has {}",
                twin.graph.control_count(),
                s.name,
                s.control_count()
            )));
        }
    }
    Ok(())
}

/// Checks that the arrays of a capture have the declared shapes.
///
/// # Errors
/// The first contradiction.
pub fn check_capture(capture: &Capture) -> Result<(), Error> {
    let points = capture.object.point_count;
    for s in &capture.sequences {
        let fault =
            |text: String| Err(Error::Inconsistent(format!("sequence `{}`: {text}", s.name)));
        let frames = s.frame_count;
        if s.start_frame() >= frames || s.train_frame_count > frames {
            return fault(format!(
                "it has {frames} frames, starts in {} and trains on {}",
                s.start_frame(),
                s.train_frame_count
            ));
        }
        let arrays = [
            ("points", s.points.len()),
            ("visibilities", s.visible.len()),
            ("motion validities", s.motion_valid.len()),
        ];
        if let Some((what, len)) =
            arrays.into_iter().find(|(_, len)| Some(*len) != frames.checked_mul(points))
        {
            return fault(format!("{len} {what} for {frames} frames of {points}"));
        }
        let wide = [("control points", s.controls.len()), ("truth tracks", s.truth_tracks.len())];
        if let Some((what, len)) = wide.into_iter().find(|(_, len)| len % frames != 0) {
            return fault(format!("{len} {what} do not divide into {frames} frames"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;

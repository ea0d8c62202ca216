//! The uncorrected prediction of a sequence, and the observations beside it.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, Point, Sequence, Skin, quality::ErrorSummary};
use bendtwin_engine::{
    Backend, Loaded, Objective,
    backend::{Instance, Outputs},
    model::State,
};
use bendtwin_register::{Observation, bind_tracks};

use super::CorrectionPlan;
use crate::{
    Error,
    distance::{euclidean, is_finite},
    metrics::Reference,
    surface::Surface,
    trajectory::initial_state,
};

/// An uncorrected prediction up to a frame and beyond.
pub(super) struct Run<'a> {
    pub(super) loaded: &'a Loaded,
    pub(super) sequence: &'a Sequence,
    fps: f64,
    pub(super) frame: usize,
    /// Observed points that have a place on the twin, and their places.
    observed: Vec<usize>,
    places: Skin,
    /// Clean tracks with places, and their places; observed points if there are no tracks.
    tracks: Vec<usize>,
    truth: Skin,
    reference: Reference<'a>,
    /// State at the start.
    pub(super) start: Arc<State>,
    /// State at the frame.
    state: State,
    /// Node positions of the frames after it.
    pub(super) after: Vec<Vec<Point>>,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        backend: &dyn Backend,
        loaded: &'a Loaded,
        capture: &'a Capture,
        sequence: &'a Sequence,
        frame: usize,
        horizon: usize,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let graph = &loaded.model().graph;
        let first = sequence.start_frame();
        let start = initial_state(graph, capture.fps, sequence);
        let bind = |points: &[Point], known: &dyn Fn(usize) -> bool| {
            let chosen: Vec<usize> = (0..points.len()).filter(|&p| known(p)).collect();
            let at: Vec<Point> = chosen.iter().map(|&p| points[p]).collect();
            let bound = bind_tracks(graph, &start.positions, &at);
            bound.map(|bound| (chosen, bound)).ok_or_else(|| {
                Error::Mismatch("the points of its start frame have no place on it".into())
            })
        };
        let (points, visible) = (sequence.points_at(first), sequence.visible_at(first));
        let (observed, places) = bind(points, &|p| visible[p] && is_finite(&points[p]))?;
        let clean = sequence.truth_at(first);
        let (tracks, truth) = match clean.is_empty() {
            true => (observed.clone(), places.clone()),
            false => bind(clean, &|p| is_finite(&clean[p]))?,
        };
        let surface = &loaded.model().skin;
        let points = Surface::of_skin(graph, surface);
        let placed = surface.positions(&start.positions);
        let reference = Reference::new(capture, sequence, &points, &placed);
        let start = Arc::new(start);
        let (_, state) = roll(backend, loaded, sequence, &start, [first, frame], cancel)?;
        let end = (frame + horizon).min(sequence.frame_count - 1);
        let state = Arc::new(state);
        let (after, _) = roll(backend, loaded, sequence, &state, [frame, end], cancel)?;
        let state = Arc::unwrap_or_clone(state);
        let fps = capture.fps;
        Ok(Self {
            loaded,
            sequence,
            fps,
            frame,
            observed,
            places,
            tracks,
            truth,
            reference,
            start,
            state,
            after,
        })
    }

    /// Observation of a share of the points in a frame, beside a simulation that is in `state`
    /// there and had its nodes at `before` in the frames from the start on.
    pub(super) fn observe(
        &self,
        plan: &CorrectionPlan,
        share: f64,
        frame: usize,
        state: &State,
        before: &[Vec<Point>],
    ) -> Result<Observation, Error> {
        let (points, visible) = (self.sequence.points_at(frame), self.sequence.visible_at(frame));
        let seen = |p: usize| visible[p] && is_finite(&points[p]);
        let mut chosen: Vec<usize> =
            (0..self.observed.len()).filter(|&i| seen(self.observed[i])).collect();
        // A fixed order without structure, of which smaller shares are parts of larger ones.
        chosen.sort_by_key(|&i| (mixed(self.observed[i] as u64), i));
        chosen.truncate(((share * chosen.len() as f64).round() as usize).max(1));
        let places = self.places.select(&chosen);
        let now: Vec<Point> = chosen.iter().map(|&i| points[self.observed[i]]).collect();
        let back = frame.saturating_sub(plan.velocity_frames);
        let mut observation = Observation { points: now, ..Observation::default() };
        let row = back.checked_sub(self.sequence.start_frame()).filter(|_| back < frame);
        if let Some(then) = row.and_then(|row| before.get(row)) {
            let (points, visible) = (self.sequence.points_at(back), self.sequence.visible_at(back));
            let (was, is) = (places.positions(then), places.positions(&state.positions));
            let moving = places.positions(&moved(state, self.fps));
            let rate = (self.fps / (frame - back) as f64) as f32;
            for (k, &i) in chosen.iter().enumerate() {
                let p = self.observed[i];
                let now = observation.points[k];
                let known = visible[p] && is_finite(&points[p]);
                // The velocity at the end, from the difference over some frames: the prediction's
                // velocity is the same mean over the same frames.
                observation.velocities.push(std::array::from_fn(|a| {
                    let own = (moving[k][a] - is[k][a]) * self.fps as f32;
                    let change = (now[a] - points[p][a]) - (is[k][a] - was[k][a]);
                    if known { own + change * rate } else { own }
                }));
            }
        }
        observation.tracks = Some(places);
        Ok(observation)
    }

    /// Errors of node positions in the frames after the correction. With `held`, tracks are
    /// corrected by their error in that frame.
    pub(super) fn errors(&self, predicted: &[Vec<Point>], held: bool) -> Vec<ErrorSummary> {
        let observed = |frame: usize| match self.sequence.truth_count() {
            0 => (self.sequence.points_at(frame), self.sequence.visible_at(frame)),
            _ => (self.sequence.truth_at(frame), [].as_slice()),
        };
        let offset = |k: usize, at: &[Point], frame: usize| -> Option<Point> {
            let (points, visible) = observed(frame);
            let p = self.tracks[k];
            let seen = is_finite(&points[p]) && visible.get(p).is_none_or(|v| *v);
            seen.then(|| std::array::from_fn(|a| points[p][a] - at[k][a]))
        };
        let now = self.truth.positions(&self.state.positions);
        let mut errors = Vec::with_capacity(predicted.len());
        for (row, nodes) in predicted.iter().enumerate() {
            let frame = self.frame + 1 + row;
            let at = self.truth.positions(nodes);
            let (mut sum, mut count) = (0.0, 0_usize);
            for k in 0..self.tracks.len() {
                let Some(error) = offset(k, &at, frame) else { continue };
                let first = match held {
                    true => offset(k, &now, self.frame).unwrap_or_default(),
                    false => [0.0; 3],
                };
                sum += euclidean(error, first);
                count += 1;
            }
            let mut summary = ErrorSummary::default();
            if !held {
                let placed = self.loaded.model().skin.positions(nodes);
                summary = self.reference.measure(frame, &placed);
            }
            summary.track_m = (count > 0).then(|| sum / count as f64);
            errors.push(summary);
        }
        errors
    }
}

/// Node positions a frame later if velocities last [m].
fn moved(state: &State, fps: f64) -> Vec<Point> {
    let pairs = state.positions.iter().zip(&state.velocities);
    pairs.map(|(x, v)| std::array::from_fn(|a| x[a] + v[a] / fps as f32)).collect()
}

/// An order without structure (the finalizer of SplitMix64).
fn mixed(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Node positions of the frames after the first one of a span, and the state at its end. After a
/// divergence the last finite frame is repeated.
pub(super) fn roll(
    backend: &dyn Backend,
    loaded: &Loaded,
    sequence: &Sequence,
    initial: &Arc<State>,
    [from, to]: [usize; 2],
    cancel: &CancelToken,
) -> Result<(Vec<Vec<Point>>, State), Error> {
    let count = sequence.control_count();
    let controls = sequence.controls.get(from * count..(to + 1) * count).unwrap_or_default();
    let instance = Instance {
        model: loaded.clone(),
        initial: Arc::clone(initial),
        controls: Arc::new(controls.to_vec()),
        frames: to - from,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs = Outputs { every: 1, final_state: true, ..Outputs::default() };
    let rollout = backend.roll_out(&[instance], &outputs, cancel)?.into_iter().next();
    let rollout = rollout.unwrap_or_default();
    let nodes = initial.positions.len().max(1);
    let mut rows: Vec<Vec<Point>> =
        rollout.positions.chunks(nodes).map(<[Point]>::to_vec).collect();
    let last = rows.last().unwrap_or(&initial.positions).clone();
    rows.resize(to - from, last.clone());
    let state = rollout.final_state.unwrap_or_else(|| State {
        velocities: vec![[0.0; 3]; last.len()],
        positions: last,
        ..State::clone(initial)
    });
    Ok((rows, state))
}

//! Predictions from corrected states: at some frames the running simulation is corrected by what is
//! seen in that frame, and the frames after it are predicted from there, beside the prediction that
//! goes on uncorrected. No later frame is looked at.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, Point, Sequence, Twin, quality::ErrorSummary};
use bendtwin_engine::{
    Backend, Loaded, Model, Objective,
    backend::{Instance, Outputs},
    model::State,
};
use bendtwin_register::{CorrectOptions, Observation, Skin, correct};

use crate::{
    Error,
    distance::{euclidean, is_finite},
    metrics::{ErrorSums, Reference},
    trajectory::{check, initial_state},
};

/// Frames and observations of a comparison.
#[derive(Clone, Debug)]
pub struct CorrectionPlan {
    /// Frames at which the state is corrected.
    pub frames: Vec<usize>,
    /// Number of frames predicted from each.
    pub horizon: usize,
    /// Shares of the visible points that are observed, each a comparison of its own, 0..=1.
    pub shares: Vec<f64>,
    /// Frames back to which the velocities of points are measured; 0 observes none.
    pub velocity_frames: usize,
    /// Options of the correction.
    pub options: CorrectOptions,
}

/// Errors over the frames after a correction, means over frames and sequences.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CorrectionScore {
    /// Frame at which the state was corrected.
    pub frame: usize,
    /// Share of the visible points that were observed.
    pub share: f64,
    /// Number of them, mean over sequences.
    pub points: f64,
    /// Sequences that were compared.
    pub sequences: usize,
    /// Corrections that were refused; the uncorrected prediction counts there.
    pub refused: usize,
    /// Median distance of the observed points before and after the correction [mm], mean over
    /// sequences.
    pub residual_mm: [f64; 2],
    /// Errors without correction. Tracks are measured against the place between nodes that they had
    /// in the start frame.
    pub open_loop: ErrorSummary,
    /// Errors without correction, less what they were in the corrected frame; tracks alone.
    pub last_residual: ErrorSummary,
    /// Errors from the corrected state.
    pub corrected: ErrorSummary,
}

/// Compares predictions from corrected states with uncorrected ones, on the sequences that are held
/// out of fitting if there are any.
///
/// # Errors
/// If the twin does not fit the capture, if a frame has no frames before or after it, on
/// cancellation, or if the backend fails.
pub fn corrections(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    plan: &CorrectionPlan,
    cancel: &CancelToken,
) -> Result<Vec<CorrectionScore>, Error> {
    check(twin, capture)?;
    let loaded = backend.load(Arc::new(Model::from(twin)))?;
    let held_out = capture.sequences.iter().any(Sequence::is_held_out);
    let chosen: Vec<&Sequence> =
        capture.sequences.iter().filter(|s| s.is_held_out() == held_out).collect();
    let mut scores = Vec::new();
    for &frame in &plan.frames {
        let mut runs = Vec::with_capacity(chosen.len());
        for &sequence in &chosen {
            if frame <= sequence.start_frame() || frame + 1 >= sequence.frame_count {
                return Err(Error::Mismatch(format!(
                    "sequence `{}` has frames {} to {}, and none to predict after frame {frame}",
                    sequence.name,
                    sequence.start_frame(),
                    sequence.frame_count - 1
                )));
            }
            runs.push(Run::new(backend, &loaded, capture, sequence, frame, plan.horizon, cancel)?);
        }
        for &share in &plan.shares {
            scores.push(compare(backend, &runs, plan, share, cancel)?);
        }
    }
    Ok(scores)
}

/// An uncorrected prediction up to a frame and beyond.
struct Run<'a> {
    loaded: &'a Loaded,
    sequence: &'a Sequence,
    fps: f64,
    frame: usize,
    /// Observed points that have a place on the twin, and their places.
    places: Vec<usize>,
    skin: Skin,
    /// Clean tracks with places, and their places; observed points where there are none.
    tracks: Vec<usize>,
    truth: Skin,
    reference: Reference<'a>,
    /// State at the frame.
    state: State,
    /// Node positions of the frames up to `frame`, from the start, and after it.
    before: Vec<Vec<Point>>,
    after: Vec<Vec<Point>>,
}

impl<'a> Run<'a> {
    fn new(
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
            let skin = Skin::bind(&start.positions, &at);
            skin.map(|skin| (chosen, skin)).ok_or_else(|| {
                Error::Mismatch("the points of its start frame have no place on it".into())
            })
        };
        let (points, visible) = (sequence.points_at(first), sequence.visible_at(first));
        let (places, skin) = bind(points, &|p| visible[p] && is_finite(&points[p]))?;
        let clean = sequence.truth_at(first);
        let (tracks, truth) = match clean.is_empty() {
            true => (places.clone(), skin.clone()),
            false => bind(clean, &|p| is_finite(&clean[p]))?,
        };
        let reference = Reference::new(capture, sequence, graph, &start.positions);
        let start = Arc::new(start);
        let (mut before, state) = roll(backend, loaded, sequence, &start, [first, frame], cancel)?;
        before.insert(0, start.positions.clone());
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
            places,
            skin,
            tracks,
            truth,
            reference,
            state,
            before,
            after,
        })
    }

    /// What is seen of a share of the points in the frame.
    fn observe(&self, plan: &CorrectionPlan, share: f64) -> Result<Observation, Error> {
        let (points, visible) =
            (self.sequence.points_at(self.frame), self.sequence.visible_at(self.frame));
        let seen = |p: usize| visible[p] && is_finite(&points[p]);
        let mut chosen: Vec<usize> =
            (0..self.places.len()).filter(|&i| seen(self.places[i])).collect();
        // A fixed order without structure, of which smaller shares are parts of larger ones.
        chosen.sort_by_key(|&i| (mixed(self.places[i] as u64), i));
        chosen.truncate(((share * chosen.len() as f64).round() as usize).max(1));
        let skin = self.skin.select(&chosen);
        let now: Vec<Point> = chosen.iter().map(|&i| points[self.places[i]]).collect();
        let back = self.frame.saturating_sub(plan.velocity_frames);
        let mut observation = Observation { points: now, ..Observation::default() };
        let row = back.checked_sub(self.sequence.start_frame()).filter(|_| back < self.frame);
        if let Some(then) = row.and_then(|row| self.before.get(row)) {
            let (points, visible) = (self.sequence.points_at(back), self.sequence.visible_at(back));
            let (was, is) = (skin.positions(then)?, skin.positions(&self.state.positions)?);
            let moving = skin.positions(&moved(&self.state, self.fps))?;
            let rate = (self.fps / (self.frame - back) as f64) as f32;
            for (k, &i) in chosen.iter().enumerate() {
                let p = self.places[i];
                let now = observation.points[k];
                let known = visible[p] && is_finite(&points[p]);
                // The velocity at the end, from the difference over some frames: what the prediction
                // had over the same frames is the same mean of its own velocity.
                observation.velocities.push(std::array::from_fn(|a| {
                    let own = (moving[k][a] - is[k][a]) * self.fps as f32;
                    let change = (now[a] - points[p][a]) - (is[k][a] - was[k][a]);
                    if known { own + change * rate } else { own }
                }));
            }
        }
        observation.tracks = Some(skin);
        Ok(observation)
    }

    /// Errors of node positions in the frames after the correction. With `held`, tracks are
    /// corrected by their error in that frame.
    fn errors(&self, predicted: &[Vec<Point>], held: bool) -> Result<Vec<ErrorSummary>, Error> {
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
        let now = self.truth.positions(&self.state.positions)?;
        let mut errors = Vec::with_capacity(predicted.len());
        for (row, nodes) in predicted.iter().enumerate() {
            let frame = self.frame + 1 + row;
            let at = self.truth.positions(nodes)?;
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
                summary = self.reference.measure(frame, nodes);
            }
            summary.track_m = (count > 0).then(|| sum / count as f64);
            errors.push(summary);
        }
        Ok(errors)
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

fn compare(
    backend: &dyn Backend,
    runs: &[Run<'_>],
    plan: &CorrectionPlan,
    share: f64,
    cancel: &CancelToken,
) -> Result<CorrectionScore, Error> {
    let mut score = CorrectionScore { share, sequences: runs.len(), ..CorrectionScore::default() };
    let mut sums = [(); 3].map(|()| ErrorSums::default());
    let each = 1.0 / runs.len().max(1) as f64;
    for run in runs {
        score.frame = run.frame;
        let observation = run.observe(plan, share)?;
        score.points += each * observation.points.len() as f64;
        let controls = run.sequence.controls_at(run.frame);
        let model = run.loaded.model();
        let corrected = correct(model, &run.state, controls, &observation, &plan.options, cancel);
        let predicted = match corrected {
            Ok(corrected) => {
                score.residual_mm[0] += each * corrected.before.median_mm;
                score.residual_mm[1] += each * corrected.after.median_mm;
                let end = run.frame + run.after.len();
                let state = Arc::new(corrected.state);
                roll(backend, run.loaded, run.sequence, &state, [run.frame, end], cancel)?.0
            }
            Err(bendtwin_register::Error::NotExplained { .. }) => {
                score.refused += 1;
                run.after.clone()
            }
            Err(other) => return Err(other.into()),
        };
        let frames = run.after.len();
        for (sum, (nodes, held)) in
            sums.iter_mut().zip([(&run.after, false), (&run.after, true), (&predicted, false)])
        {
            sum.add(&run.errors(nodes, held)?, frames);
        }
    }
    score.open_loop = sums[0].summary();
    score.last_residual = sums[1].summary();
    score.corrected = sums[2].summary();
    Ok(score)
}

/// Node positions of the frames after the first one of a span, and the state at its end. After a
/// divergence the last finite frame is repeated.
fn roll(
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

#[cfg(test)]
mod tests;

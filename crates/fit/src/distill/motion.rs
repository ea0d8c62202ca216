//! The twin's motion under actions, cut into windows, and how far another model is from it there. A
//! window begins in a state of the exact twin, as a plan does.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, PlannersTwin, Point, Twin,
    geometry::{distance, wide},
};
use bendtwin_engine::{
    Backend, Loaded, Model, Objective,
    backend::{Instance, Outputs},
    model::State,
    planner::thinned,
};
use bendtwin_eval::slice_len;

use super::{actions::Action, large_skin};
use crate::Error;

/// Frames of a window, and windows of an action, of which each begins where the one before has ended.
pub(super) const FRAMES: usize = 30;
pub(super) const WINDOWS: usize = 2;

/// A part of the twin's motion under an action.
pub(super) struct Window {
    /// State of the twin in which it begins.
    pub(super) start: State,
    /// Control points [m], shape [frames + 1, C, 3].
    pub(super) controls: Vec<Point>,
    /// Nodes of the twin [m], shape [frames + 1, N, 3].
    pub(super) positions: Vec<Point>,
}

/// A rollout that was made.
struct Ran {
    /// Nodes [m], shape [frames + 1, nodes, 3].
    positions: Vec<Point>,
    /// State in which it ended; none if it diverged.
    end: Option<State>,
}

/// The motion of a twin from its rest shape under actions, window by window; without what diverges.
pub(super) fn follow(
    backend: &dyn Backend,
    twin: &Twin,
    actions: &[Action],
    cancel: &CancelToken,
) -> Result<Vec<Window>, Error> {
    let loaded = backend.load(Arc::new(Model::from(twin)))?;
    let width = twin.graph.control_count();
    let mut windows = Vec::with_capacity(actions.len() * WINDOWS);
    // The last state of each action, as long as it has not diverged.
    let mut states = vec![Some(State::rest(&twin.graph)); actions.len()];
    for part in 0..WINDOWS {
        let rows = part * FRAMES * width..((part + 1) * FRAMES + 1) * width;
        let going: Vec<usize> = (0..actions.len()).filter(|&a| states[a].is_some()).collect();
        let begin =
            |&a: &usize| Some((states[a].clone()?, actions[a].controls[rows.clone()].to_vec()));
        let begun: Vec<(State, Vec<Point>)> = going.iter().filter_map(begin).collect();
        let ran = run(backend, &loaded, &begun, cancel)?;
        for ((action, (start, controls)), Ran { positions, end }) in
            going.into_iter().zip(begun).zip(ran)
        {
            states[action] = end;
            if states[action].is_some() {
                windows.push(Window { start, controls, positions });
            }
        }
    }
    Ok(windows)
}

/// Rollouts from states with control points.
fn run(
    backend: &dyn Backend,
    model: &Loaded,
    begun: &[(State, Vec<Point>)],
    cancel: &CancelToken,
) -> Result<Vec<Ran>, Error> {
    let instance = |(start, controls): &(State, Vec<Point>)| Instance {
        model: model.clone(),
        initial: Arc::new(start.clone()),
        controls: Arc::new(controls.clone()),
        frames: FRAMES,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs = Outputs { every: 1, initial: true, final_state: true, ..Outputs::default() };
    let mut ran = Vec::with_capacity(begun.len());
    for slice in begun.chunks(slice_len(backend)) {
        let batch: Vec<Instance> = slice.iter().map(instance).collect();
        for rollout in backend.roll_out(&batch, &outputs, cancel)? {
            let end = rollout.final_state.filter(|_| rollout.diverged.is_none());
            ran.push(Ran { positions: rollout.positions, end });
        }
    }
    Ok(ran)
}

/// Mean and largest distance of the skin of a planner's twin from that of its twin over windows, and
/// the mean travel of the twin's skin in them [m]. One that diverges is infinitely far.
pub(super) fn deviation(
    backend: &dyn Backend,
    planner: &PlannersTwin,
    of: &Twin,
    windows: &[Window],
    cancel: &CancelToken,
) -> Result<[f64; 3], Error> {
    let loaded = backend.load(Arc::new(Model::from(&*planner.twin)))?;
    let start = |w: &Window| (thinned(planner, &w.start), w.controls.clone());
    let begun: Vec<_> = windows.iter().map(start).collect();
    let ran = run(backend, &loaded, &begun, cancel)?;
    // A twin without a skin is compared at its nodes.
    let all = large_skin(of);
    let points: Vec<usize> = match of.skin.is_empty() {
        true => (0..all.len()).collect(),
        false => (0..of.skin.len()).collect(),
    };
    let (there, here) = (all.select(&points), planner.twin.skin.select(&points));
    let (n, small) = (of.graph.node_count().max(1), planner.nodes.len().max(1));
    let (mut sum, mut most, mut travel, mut count) = (0.0, 0.0_f64, 0.0, 0_usize);
    for (window, Ran { positions, end }) in windows.iter().zip(ran) {
        if end.is_none() {
            return Ok([f64::INFINITY; 3]);
        }
        let first = there.positions(&window.positions[..n]);
        let frames = window.positions.chunks_exact(n).zip(positions.chunks_exact(small)).skip(1);
        for (large, small) in frames {
            let (large, small) = (there.positions(large), here.positions(small));
            for ((a, b), from) in large.iter().zip(&small).zip(&first) {
                let apart = distance(wide(*a), wide(*b));
                (sum, most, count) = (sum + apart, most.max(apart), count + 1);
                travel += distance(wide(*a), wide(*from));
            }
        }
    }
    let count = count.max(1) as f64;
    Ok([sum / count, most, travel / count])
}

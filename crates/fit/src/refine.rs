//! The first-order stage: Adam on every spring and triplet, all variants side by side in each batch.

mod schedule;
mod walk;

use std::sync::Arc;

use bendtwin_engine::{
    Backend,
    backend::{CancelToken, Gradient, GradientRequest, Instance},
    model::State,
};
use bendtwin_eval::initial_state;

use self::schedule::Step;
pub(crate) use self::walk::{Walk, WalkState};
use crate::{Error, search::window_instance, submit, task::Task};

/// One pass of all variants over the training frames.
///
/// A variant whose simulation or gradient is not finite goes back to its best parameters with half
/// the rate and sits out the rest of the pass; the others are not disturbed.
pub(crate) fn pass(
    task: &Task<'_>,
    walks: &mut [Walk<'_>],
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<(), Error> {
    let Some(pass) = walks.first().map(|w| w.state.pass) else { return Ok(()) };
    let initial: Vec<Arc<State>> = {
        let graph = &walks[0].graph;
        let of = |t: &crate::task::Training<'_>| initial_state(graph, task.capture.fps, t.sequence);
        task.training.iter().map(|t| Arc::new(of(t))).collect()
    };
    // States at the start of the next window, by variant and sequence.
    let mut states = vec![initial.clone(); walks.len()];
    walks.iter_mut().for_each(Walk::begin_pass);
    for step in schedule::steps(task, pass) {
        run_step(task, walks, &mut states, &step, backend, cancel)?;
    }
    for walk in walks.iter_mut() {
        walk.settle_substeps(backend)?;
    }
    score(task, walks, &initial, backend, cancel)?;
    walks.iter_mut().for_each(Walk::end_pass);
    Ok(())
}

/// Scores the parameters that the search left, so that no pass can end worse than it began.
pub(crate) fn score_start(
    task: &Task<'_>,
    walks: &mut [Walk<'_>],
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<(), Error> {
    let Some(first) = walks.first() else { return Ok(()) };
    let graph = first.graph.clone();
    let of = |t: &crate::task::Training<'_>| initial_state(&graph, task.capture.fps, t.sequence);
    let initial: Vec<Arc<State>> = task.training.iter().map(|t| Arc::new(of(t))).collect();
    score(task, walks, &initial, backend, cancel)
}

fn run_step(
    task: &Task<'_>,
    walks: &mut [Walk<'_>],
    states: &mut [Vec<Arc<State>>],
    step: &Step,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<(), Error> {
    let instances = |walk: &Walk<'_>, states: &[Arc<State>]| -> Vec<Instance> {
        let one = |&(s, first, count): &(usize, usize, usize)| {
            let training = &task.training[s];
            let objective = if count == training.frames {
                training.objective.clone()
            } else {
                training.window(first, count)
            };
            window_instance(&walk.loaded, training, states[s].clone(), first, count, objective)
        };
        step.windows.iter().map(one).collect()
    };
    // One batch for all variants whose gradients reach equally far, as they nearly always do.
    let mut results: Vec<Option<Vec<Gradient>>> = walks.iter().map(|_| None).collect();
    let mut reaches: Vec<usize> = walks.iter().filter(|w| w.is_active()).map(Walk::reach).collect();
    reaches.sort_unstable();
    reaches.dedup();
    for reach in reaches {
        let members: Vec<usize> = (0..walks.len())
            .filter(|&i| walks[i].is_active() && walks[i].reach() == reach)
            .collect();
        let batch: Vec<Instance> =
            members.iter().flat_map(|&i| instances(&walks[i], &states[i])).collect();
        let request = GradientRequest {
            cut_every: reach,
            final_state: step.goes_on,
            ..GradientRequest::default()
        };
        let mut gradients = submit::gradients(backend, &batch, &request, cancel)?.into_iter();
        for i in members {
            results[i] = Some(gradients.by_ref().take(step.windows.len()).collect());
        }
    }
    for ((walk, states), result) in walks.iter_mut().zip(states).zip(results) {
        let Some(own) = result else { continue };
        walk.learn(&own, backend)?;
        for (gradient, &(s, ..)) in own.into_iter().zip(&step.windows) {
            if let Some(state) = gradient.final_state {
                states[s] = Arc::new(state);
            }
        }
    }
    Ok(())
}

/// Measures every variant's parameters on all training frames and keeps the best.
fn score(
    task: &Task<'_>,
    walks: &mut [Walk<'_>],
    initial: &[Arc<State>],
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<(), Error> {
    let mut batch = Vec::new();
    for walk in walks.iter() {
        for (training, initial) in task.training.iter().zip(initial) {
            let objective = training.objective.clone();
            let (state, frames) = (initial.clone(), training.frames);
            batch.push(window_instance(&walk.loaded, training, state, 0, frames, objective));
        }
    }
    let losses = submit::losses(backend, &batch, cancel)?;
    for (walk, own) in walks.iter_mut().zip(losses.chunks(task.training.len())) {
        let loss = own.iter().map(|l| l.total).sum::<f64>() / own.len() as f64;
        walk.judge(loss, backend)?;
    }
    Ok(())
}

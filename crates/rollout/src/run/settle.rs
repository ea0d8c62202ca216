//! The settled state of a twin: its rest shape come to rest in a world, held by its control points
//! where they are at rest.
//!
//! The simulation has more drag, which changes the way there but not where forces balance. Nodes in
//! the world's ground or colliders start on their surfaces, since they push nothing out.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_core::{CancelToken, Point, geometry::distance};
use bendtwin_engine::{
    Backend, Objective,
    backend::{Instance, Outputs},
    model::State,
};
use bendtwin_register::leave_obstacles;

use crate::{error::Error, request::initial::Start, twin::warm::Warm, world::Still};

/// Drag while settling, at least [1/s]: about critical for what swings once a second.
const DRAG: f32 = 8.0;
/// Time between two judgements [s].
const INTERVAL_S: f64 = 0.25;
/// Longest time [s].
const LONGEST_S: f64 = 10.0;
/// A node that gets no farther than this in a second is at rest [m/s].
const AT_REST_M_S: f64 = 1e-3;

/// Lets a twin come to rest in a world.
///
/// # Errors
/// If that may take more work than `work_limit`, the twin diverges or never comes to rest, or the backend
/// fails.
pub fn settle(
    warm: &Warm,
    world: &Still,
    work_limit: u64,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<Start, Error> {
    let (graph, timing) = (&warm.twin.graph, warm.twin.timing);
    let interval = ((INTERVAL_S * timing.fps).ceil() as usize).max(1);
    let interval_s = interval as f64 * timing.frame_s();
    let intervals = (LONGEST_S / interval_s).ceil() as usize;
    let nodes = graph.node_count() as u128 * u128::from(1 + world.work());
    let elements = nodes + (graph.springs.len() + graph.triplets.len()) as u128;
    let work = (interval * intervals) as u128 * u128::from(timing.substeps) * elements;
    if work > u128::from(work_limit) {
        return Err(Error::Request(rollout::Error::TooLarge {
            what: "the work of letting the twin come to rest",
            asked: u64::try_from(work).unwrap_or(u64::MAX),
            limit: work_limit,
            advice: "start at rest or in a frame of a capture",
        }));
    }
    let model = world.load(&warm.loaded, DRAG, backend)?;
    let mut state = State::rest(graph);
    leave_obstacles(model.model(), &world.around_now(), &mut state);
    let mut state = Arc::new(state);
    let (world, motion) = world.around(interval);
    let at_rest = Arc::new(graph.control_rest.clone());
    let controls: Arc<Vec<Point>> = Arc::new(at_rest.repeat(interval + 1));
    let outputs = Outputs { final_state: true, ..Outputs::NONE };
    let mut speed_m_s = f64::INFINITY;
    for passed in 0..intervals {
        let instance = Instance {
            model: model.clone(),
            initial: Arc::clone(&state),
            controls: Arc::clone(&controls),
            frames: interval,
            objective: Objective::default(),
            world: Arc::clone(&world),
            motion: Arc::clone(&motion),
        };
        let rollout = backend.roll_out(&[instance], &outputs, cancel)?.into_iter().next();
        let rollout = rollout.unwrap_or_default();
        if let Some(divergence) = rollout.diverged {
            let frames = passed * interval + divergence.frame;
            return Err(Error::SettlingDiverged { after_s: frames as f64 * timing.frame_s() });
        }
        let next = rollout.final_state.ok_or_else(|| {
            bendtwin_engine::Error::Device("no final state was returned".to_owned())
        })?;
        let moved = next.positions.iter().zip(&state.positions);
        let farthest = moved.map(|(a, b)| distance(*a, *b)).fold(0.0f32, f32::max);
        speed_m_s = f64::from(farthest) / interval_s;
        state = Arc::new(next);
        if speed_m_s < AT_REST_M_S {
            let still =
                State { velocities: vec![[0.0; 3]; graph.node_count()], ..State::clone(&state) };
            return Ok(Start::new(Arc::new(still), at_rest));
        }
    }
    Err(Error::NeverAtRest { speed_m_s, after_s: LONGEST_S })
}

#[cfg(test)]
mod tests;

//! States of slots as messages.

use bendtwin_core::{Graph, Point};
use bendtwin_engine::model::State;
use bendtwin_proto::v1::{SessionStates, Tensor, initial_state::GivenState};

use super::Session;
use crate::{
    request::{grasping, initial::Start},
    twin::warm::Warm,
};

/// The states of slots of a session of a twin, as an initial state takes them.
pub fn session_states(session: &Session, warm: &Warm, slots: &[usize]) -> SessionStates {
    let (starts, frames) = session.states(slots);
    let states = Some(given(&starts, &warm.twin.graph, session.setup.grasps.len()));
    let slots = slots.iter().map(|&s| s as u32).collect();
    SessionStates { states, slots, frames }
}

/// States in the form that an initial state with `grasps` grasps takes.
fn given(starts: &[Start], graph: &Graph, grasps: usize) -> GivenState {
    let (n, r, c) = (graph.node_count(), graph.rods.len(), graph.control_count());
    let points = |of: fn(&State) -> &Vec<Point>| {
        let all: Vec<Point> = starts.iter().flat_map(|s| of(&s.state)).copied().collect();
        Some(Tensor::pack_points(&[starts.len(), n], &all))
    };
    let twists = || {
        let own =
            |s: &Start| (0..r).map(|i| s.state.twists.get(i).copied().unwrap_or(0.0)).collect();
        let all: Vec<f32> = starts.iter().flat_map(|s| -> Vec<f32> { own(s) }).collect();
        Tensor::pack(&[starts.len(), r], &all)
    };
    let all = |of: fn(&Start) -> &[Point]| {
        let all: Vec<Point> = starts.iter().flat_map(of).copied().collect();
        Some(Tensor::pack_points(&[starts.len(), c], &all))
    };
    let is_held_back = starts.iter().any(|s| s.commanded.is_some());
    GivenState {
        positions: points(|s| &s.positions),
        velocities: points(|s| &s.velocities),
        twists: (r > 0).then(twists),
        controls: all(|s| &s.controls),
        commanded_controls: is_held_back.then(|| all(Start::commanded)).flatten(),
        grasping: (grasps > 0)
            .then(|| grasping::pack(starts.iter().map(|s| Some(&*s.state)), grasps, n)),
    }
}

/// A single state in the form that an initial state takes, without the batch dimension.
pub(super) fn given_one(start: &Start, graph: &Graph, grasps: usize) -> GivenState {
    let mut state = given(std::slice::from_ref(start), graph, grasps);
    let GivenState { positions, velocities, twists, controls, grasping, commanded_controls } =
        &mut state;
    let of_grasps =
        grasping.iter_mut().flat_map(|g| [&mut g.phases, &mut g.holders, &mut g.places]);
    let of_nodes = [positions, velocities, twists, controls, commanded_controls];
    for tensor in of_nodes.into_iter().chain(of_grasps).flatten() {
        tensor.shape.remove(0);
    }
    state
}

//! States of a twin as those of its planner's twin, and back.

use bendtwin_core::PlannersTwin;

use crate::{
    model::State,
    world::{Grasping, Hold, Phase},
};

/// The first closed grasp of a twin's state that holds only nodes missing from its planner's twin:
/// after [`thinned`] it would hold nothing.
pub fn lost_grasp(planner: &PlannersTwin, grasping: &Grasping) -> Option<usize> {
    let is_own = |hold: &Hold| planner.nodes.binary_search(&hold.node).is_ok();
    let is_lost = |grasp: usize| {
        let mut holds =
            grasping.holds.iter().filter(|hold| hold.grasp as usize == grasp).peekable();
        holds.peek().is_some() && !holds.any(is_own)
    };
    let closed = |(_, phase): &(usize, &Phase)| **phase == Phase::Closed;
    let mut grasps = grasping.phases.iter().enumerate().filter(closed).map(|(grasp, _)| grasp);
    grasps.find(|&grasp| is_lost(grasp))
}

/// The state of a planner's twin, taken from that of its twin: its nodes alone. Holds of other nodes are left
/// out; [`lost_grasp`] says whether that opens a grasp.
pub fn thinned(planner: &PlannersTwin, state: &State) -> State {
    let own = |hold: &Hold| {
        let place = planner.nodes.binary_search(&hold.node).ok()?;
        Some(Hold { node: place as u32, ..*hold })
    };
    State {
        positions: planner.select(&state.positions),
        velocities: planner.select(&state.velocities),
        twists: state.twists.clone(),
        grasping: Grasping {
            phases: state.grasping.phases.clone(),
            holds: state.grasping.holds.iter().filter_map(own).collect(),
        },
    }
}

/// The state of a twin, whose skin has `skin_points` points, from that of its planner's twin: its nodes are
/// carried. [`thinned`], it is the same state again.
pub fn carried(planner: &PlannersTwin, skin_points: usize, state: &State) -> State {
    let of_twin =
        |hold: &Hold| planner.nodes.get(hold.node as usize).map(|&node| Hold { node, ..*hold });
    State {
        positions: planner.positions(skin_points, &state.positions),
        velocities: planner.velocities(skin_points, &state.positions, &state.velocities),
        twists: state.twists.clone(),
        grasping: Grasping {
            phases: state.grasping.phases.clone(),
            holds: state.grasping.holds.iter().filter_map(of_twin).collect(),
        },
    }
}

//! States to start from, and those that rollouts end in.

use bendtwin_core::Point;
use bendtwin_proto::v1::{self, Tensor, initial_state::GivenState};

use super::Reply;
use crate::resources::resource;

resource! { GivenState =>
/// A state of a twin with N nodes and C control points. A rollout that starts from the final state
/// of another continues exactly as if the other had not stopped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Positions [m], shape [N].
    pub positions: Vec<Point>,
    /// Velocities [m/s], shape [N]; empty means at rest.
    pub velocities: Vec<Point>,
    /// Twists of rods [rad]; empty means zero.
    pub twists: Vec<f32>,
    /// Control points [m], shape [C]; empty: where pins say, others at rest.
    pub controls: Vec<Point>,
    /// Control points as grippers would have them if the ground did not hold them back [m], shape [C]:
    /// from there poses carry them on. Empty: as `controls`.
    pub commanded_controls: Vec<Point>,
    /// Holds of grasps; none without grasps.
    pub grasping: Option<Grasping>,
}
}

resource! { v1::Grasping =>
/// Holds of G grasps in a state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grasping {
    /// 0 open, 1 closed, 2 slipped; shape [G].
    pub phases: Vec<u32>,
    /// g + 1 for a node that grasp g holds, 0 for none; shape [N].
    pub holders: Vec<u32>,
    /// Places of held nodes in the coordinates of their grippers [m], shape [N].
    pub places: Vec<Point>,
}
}

impl From<&State> for GivenState {
    fn from(state: &State) -> Self {
        let points = |points: &[Point]| {
            (!points.is_empty()).then(|| Tensor::pack_points(&[points.len()], points))
        };
        let numbers = |numbers: &[u32]| Some(Tensor::pack(&[numbers.len()], numbers));
        Self {
            positions: points(&state.positions),
            velocities: points(&state.velocities),
            twists: (!state.twists.is_empty())
                .then(|| Tensor::pack(&[state.twists.len()], &state.twists)),
            controls: points(&state.controls),
            commanded_controls: points(&state.commanded_controls),
            grasping: state.grasping.as_ref().map(|g| v1::Grasping {
                phases: numbers(&g.phases),
                holders: numbers(&g.holders),
                places: points(&g.places),
            }),
        }
    }
}

impl State {
    /// A single state of `rows` states whose arrays are stored one after another here.
    pub(crate) fn row(&self, rows: usize, row: usize) -> Self {
        Self {
            positions: one(&self.positions, rows, row),
            velocities: one(&self.velocities, rows, row),
            twists: one(&self.twists, rows, row),
            controls: one(&self.controls, rows, row),
            commanded_controls: one(&self.commanded_controls, rows, row),
            grasping: self.grasping.as_ref().map(|all| all.row(rows, row)),
        }
    }
}

impl Grasping {
    fn row(&self, rows: usize, row: usize) -> Self {
        Self {
            phases: one(&self.phases, rows, row),
            holders: one(&self.holders, rows, row),
            places: one(&self.places, rows, row),
        }
    }
}

impl Reply {
    /// The final state of the `row`-th of `instances`; none if final states were not asked for, or
    /// there is no such row.
    pub fn state(&self, row: usize) -> Option<State> {
        let rows = self.instances.len();
        if row >= rows || self.final_positions.is_empty() {
            return None;
        }
        let grasping = self.final_grasping.as_ref().map(|all| all.row(rows, row));
        Some(State {
            positions: one(&self.final_positions, rows, row),
            velocities: one(&self.final_velocities, rows, row),
            twists: one(&self.final_twists, rows, row),
            controls: one(&self.final_controls, rows, row),
            commanded_controls: one(&self.final_commanded_controls, rows, row),
            grasping,
        })
    }
}

/// Part `row` of `rows` equal parts.
fn one<T: Clone>(all: &[T], rows: usize, row: usize) -> Vec<T> {
    let width = all.len() / rows;
    all[row * width..(row + 1) * width].to_vec()
}

//! A rollout's reply, unpacked.

use std::ops::RangeInclusive;

use bendtwin_core::{Fidelity, Point, ids::WorkerId};
use bendtwin_proto::v1::{
    RollOutResponse,
    roll_out_response::{self as wire, Deviation, Timing},
};
use serde::Serialize;

use super::Grasping;
use crate::resources::resource;

resource! { RollOutResponse =>
/// The reply to a rollout, or a part of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reply {
    /// The first instance that it covers.
    pub first_instance: usize,
    /// The frames that it covers, 1-based, if the reply is divided in time. Costs, final states and
    /// diagnostics then come with the last frames of an instance.
    pub window: Option<RangeInclusive<usize>>,
    /// Cost of each instance covered, shape [B']; infinite where it diverged or is unfinished.
    pub costs: Vec<f64>,
    /// Names of the costs.
    pub cost_names: Vec<String>,
    /// Weighted costs by name, shape [B', names].
    pub cost_terms: Vec<f64>,
    /// The instances that the arrays below are of, shape [R]; best first if only the best were
    /// asked for.
    pub instances: Vec<usize>,
    /// Recorded frames, 1-based, shape [T'].
    pub frames: Vec<usize>,
    /// Recorded positions [m], shape [R, T', nodes].
    pub positions: Vec<Point>,
    /// Final positions [m], shape [R, N].
    pub final_positions: Vec<Point>,
    /// Final velocities [m/s], shape [R, N].
    pub final_velocities: Vec<Point>,
    /// Final twists [rad], shape [R, rods].
    pub final_twists: Vec<f32>,
    /// Final control points [m], shape [R, C].
    pub final_controls: Vec<Point>,
    /// Control points as grippers would have them if the ground did not hold them back [m], shape
    /// [R, C]; with poses.
    pub final_commanded_controls: Vec<Point>,
    /// Holds of grasps in the final states, one after another; none without grasps.
    pub final_grasping: Option<Grasping>,
    /// d cost / d actions as the request gave them, [R, K, C, 3] or [R, K, G, 7].
    pub action_gradients: Vec<f32>,
    /// Mass of the object; none if it is not known, and forces are per unit mass [kg].
    pub mass_kg: Option<f64>,
    /// d cost / d control positions, shape [R, F + 1, C].
    pub control_gradients: Vec<Point>,
    /// d cost / d initial positions, shape [R, N]. Of an instance that diverged all gradients are
    /// NaN.
    pub initial_position_gradients: Vec<Point>,
    /// d cost / d initial velocities, shape [R, N].
    pub initial_velocity_gradients: Vec<Point>,
    /// Norm of d cost / d positions, shape [R, F + 1].
    pub gradient_norms: Vec<f64>,
    /// True where a gradient exploded on its way back, and says little; shape [R].
    pub gradient_exploded: Vec<bool>,
    /// Velocities in the recorded frames [m/s], as `positions`.
    pub velocities: Vec<Point>,
    /// Weighted costs by frame and name, shape [R, F + 1, names]; frame 0 is the start.
    pub frame_costs: Vec<f64>,
    /// Control positions that were simulated [m], shape [R, F + 1, C].
    pub controls: Vec<Point>,
    /// Diagnostics of each instance covered, if requested.
    pub diagnostics: Vec<Diagnostics>,
    /// Costs of the members of an ensemble, of which `costs` are a statistic or beside those of their mean
    /// motion, shape [B', E].
    pub member_costs: Vec<f64>,
    /// 1 for each instance that meets all conditions of success, otherwise 0, and with an ensemble the
    /// share of members, shape [B']; empty without conditions.
    pub successes: Vec<f32>,
    /// Root mean square distance of the other members of an ensemble from the first, whose
    /// `positions` are returned unless they are those of the mean [m], shape [actions, recorded frames, K]; NaN where one diverged.
    pub spread: Vec<f32>,
    /// Forces, if asked for.
    pub forces: Option<Forces>,
    /// Motion that is not plausible.
    pub implausible: Vec<Implausible>,
    /// The instances that diverged.
    pub diverged: Vec<Divergence>,
    /// The instances that were not simulated within the request's time limit.
    pub unfinished: Vec<usize>,
    /// Times of the rollout.
    pub timing: Timing,
    /// The worker that computed it.
    pub worker: Option<WorkerId>,
    /// Fidelity of the answer.
    pub fidelity: Fidelity,
    /// Substeps per frame that were simulated.
    pub substeps: u32,
    /// Deviation of the fast variant or the planner's twin, if one of them answered.
    pub deviation: Option<Deviation>,
}
}

resource! { wire::Diagnostics =>
/// Physical sanity of an instance, up to where it diverged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Diagnostics {
    /// Largest |l/l0 - 1| of any spring between nodes.
    pub max_strain: f32,
    /// Largest strain of springs to control points.
    pub max_control_strain: f32,
    /// Largest mean speed of a node over a frame [m/s].
    pub max_speed_m_s: f32,
    /// Kinetic energy at the end [J]; without a mass of the object as if a node of the twin weighed
    /// 1 kg, and NaN where it diverged.
    pub kinetic_energy: f32,
    /// Elastic energy at the end [J], likewise.
    pub elastic_energy: f32,
    /// Nodes on the ground at the end.
    pub ground_contacts: u32,
    /// Farthest that a hand or gripper was held back at the ground [m]; 0 if none was.
    pub stopped_hand_m: f32,
}
}

resource! { wire::Forces =>
/// Mean forces on the object over each frame [N]; per unit mass if its mass is not known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// Forces from control points, shape [R, F, C, 3].
    pub controls: Vec<Point>,
    /// Forces from grasps, shape [R, F, G, 6]: force, then torque about the gripper's origin at the
    /// end of the frame [N m], along the world's axes.
    pub grasps: Vec<f32>,
    /// Forces from the ground, shape [R, F, 3].
    pub ground: Vec<Point>,
    /// Forces from colliders, shape [R, F, K, 6], about the origin of what carries them.
    pub colliders: Vec<f32>,
}
}

resource! { wire::Implausible =>
/// Motion of an instance beyond a limit of what is plausible.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Implausible {
    /// The instance.
    pub instance: usize,
    /// START_GAP, CONTROL_SPEED, STRAIN, CONTROL_IN_OBSTACLE or GRASP_FORCE.
    pub reason: String,
    /// Most that was found, in the unit of the limit.
    pub found: f64,
    /// The limit.
    pub limit: f64,
    /// The frame in which it was found; 0 if it is not known.
    pub frame: usize,
    /// With GRASP_FORCE the grasp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<usize>,
}
}

resource! { wire::Divergence =>
/// Divergence of an instance: its first state that is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Divergence {
    /// The instance.
    pub instance: usize,
    /// Frame in which it diverged, 1-based.
    pub frame: usize,
    /// The first node concerned.
    pub node: usize,
}
}

impl Reply {
    /// The instance of lowest cost; none if the reply covers no instance.
    pub fn best(&self) -> Option<usize> {
        let best = self.costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        best.map(|(i, _)| self.first_instance + i)
    }

    /// Recorded positions of the `row`-th instance of `instances` in the `frame`-th of `frames`
    /// [m]; none if there is no such row.
    pub fn recorded(&self, row: usize, frame: usize) -> Option<&[Point]> {
        let rows = self.instances.len() * self.frames.len();
        let width = self.positions.len().checked_div(rows)?;
        let start = (row * self.frames.len() + frame) * width;
        (frame < self.frames.len()).then(|| self.positions.get(start..start + width)).flatten()
    }
}

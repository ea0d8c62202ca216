//! A rollout's reply, unpacked.

use std::ops::RangeInclusive;

use bendtwin_core::{Fidelity, Point, ids::WorkerId};
use bendtwin_proto::v1::{self, RollOutResponse, Tensor, roll_out_response as wire};
use serde::Serialize;

use super::Grasping;
use crate::Error;

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
    pub timing: RolloutTiming,
    /// The worker that computed it.
    pub worker: Option<WorkerId>,
    /// Fidelity of the answer.
    pub fidelity: Fidelity,
    /// Substeps per frame that were simulated.
    pub substeps: u32,
    /// Deviation of the fast variant or the planner's twin, if one of them answered.
    pub deviation: Option<Deviation>,
}

/// Distance from the exact twin: of the fast variant, when both follow the twin's own capture, or
/// of the planner's twin, when both follow the actions that measured it. It is not a bound for this
/// rollout: with faster or larger motions, or other surroundings, 5 to 16 times as much was
/// observed for fast variants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deviation {
    /// Between a node here and there, mean over nodes and frames [m].
    pub mean_m: f64,
    /// The largest [m].
    pub max_m: f64,
    /// For comparison: mean distance of the exact twin's nodes from their starts [m].
    pub mean_travel_m: f64,
    /// Frames of each recording, at most.
    pub frames: u32,
}

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

/// Motion of an instance beyond a limit of what is plausible.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Implausible {
    /// The instance.
    pub instance: usize,
    /// START_GAP, CONTROL_SPEED, STRAIN or CONTROL_IN_OBSTACLE.
    pub reason: String,
    /// Most that was found, in the unit of the limit.
    pub found: f64,
    /// The limit.
    pub limit: f64,
    /// The frame in which it was found; 0 if it is not known.
    pub frame: usize,
}

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

/// Times of a rollout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RolloutTiming {
    /// Waiting for the device [s].
    pub queue_s: f64,
    /// Computing [s].
    pub compute_s: f64,
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

impl TryFrom<RollOutResponse> for Reply {
    type Error = Error;
    fn try_from(wire: RollOutResponse) -> Result<Self, Error> {
        let timing = wire.timing.unwrap_or_default();
        let fidelity = match wire.fidelity() {
            v1::Fidelity::Fast => Fidelity::Fast,
            v1::Fidelity::Planner => Fidelity::Planner,
            v1::Fidelity::Exact | v1::Fidelity::Unspecified => Fidelity::Exact,
        };
        let worker = match wire.worker.as_str() {
            "" => None,
            name => Some(name.parse().map_err(Error::malformed)?),
        };
        Ok(Self {
            first_instance: wire.first_instance as usize,
            window: wire.window.map(|w| w.first_frame as usize..=w.last_frame as usize),
            costs: values(wire.costs, "costs")?,
            cost_names: wire.cost_names,
            cost_terms: values(wire.cost_terms, "cost_terms")?,
            instances: indices(wire.instances, "instances")?,
            frames: indices(wire.frames, "frames")?,
            positions: points(wire.positions, "positions")?,
            final_positions: points(wire.final_positions, "final_positions")?,
            final_velocities: points(wire.final_velocities, "final_velocities")?,
            final_twists: floats(wire.final_twists, "final_twists")?,
            final_controls: points(wire.final_controls, "final_controls")?,
            final_commanded_controls: points(
                wire.final_commanded_controls,
                "final_commanded_controls",
            )?,
            final_grasping: wire.final_grasping.map(grasping).transpose()?,
            action_gradients: floats(wire.action_gradients, "action_gradients")?,
            mass_kg: wire.mass_kg,
            control_gradients: points(wire.control_gradients, "control_gradients")?,
            initial_position_gradients: points(
                wire.initial_position_gradients,
                "initial_position_gradients",
            )?,
            initial_velocity_gradients: points(
                wire.initial_velocity_gradients,
                "initial_velocity_gradients",
            )?,
            gradient_norms: values(wire.gradient_norms, "gradient_norms")?,
            gradient_exploded: indices(wire.gradient_exploded, "gradient_exploded")?
                .into_iter()
                .map(|flag| flag != 0)
                .collect(),
            velocities: points(wire.velocities, "velocities")?,
            frame_costs: values(wire.frame_costs, "frame_costs")?,
            controls: points(wire.controls, "controls")?,
            diagnostics: wire.diagnostics.into_iter().map(Diagnostics::from).collect(),
            member_costs: values(wire.member_costs, "member_costs")?,
            spread: floats(wire.spread, "spread")?,
            forces: wire.forces.map(Forces::try_from).transpose()?,
            implausible: wire.implausible.into_iter().map(Implausible::from).collect(),
            diverged: wire.diverged.into_iter().map(Divergence::from).collect(),
            unfinished: indices(wire.unfinished, "unfinished")?,
            timing: RolloutTiming { queue_s: timing.queue_s, compute_s: timing.compute_s },
            worker,
            fidelity,
            substeps: wire.substeps,
            deviation: wire.deviation.map(Deviation::from),
        })
    }
}

impl From<wire::Diagnostics> for Diagnostics {
    fn from(d: wire::Diagnostics) -> Self {
        Self {
            max_strain: d.max_strain,
            max_control_strain: d.max_control_strain,
            max_speed_m_s: d.max_speed_m_s,
            kinetic_energy: d.kinetic_energy,
            elastic_energy: d.elastic_energy,
            ground_contacts: d.ground_contacts,
            stopped_hand_m: d.stopped_hand_m,
        }
    }
}

impl TryFrom<wire::Forces> for Forces {
    type Error = Error;
    fn try_from(wire: wire::Forces) -> Result<Self, Error> {
        Ok(Self {
            controls: points(wire.controls, "forces.controls")?,
            grasps: floats(wire.grasps, "forces.grasps")?,
            ground: points(wire.ground, "forces.ground")?,
            colliders: floats(wire.colliders, "forces.colliders")?,
        })
    }
}

impl From<wire::Implausible> for Implausible {
    fn from(i: wire::Implausible) -> Self {
        let (instance, frame) = (i.instance as usize, i.frame as usize);
        Self { instance, reason: i.reason, found: i.found, limit: i.limit, frame }
    }
}

impl From<wire::Deviation> for Deviation {
    fn from(d: wire::Deviation) -> Self {
        Self { mean_m: d.mean_m, max_m: d.max_m, mean_travel_m: d.mean_travel_m, frames: d.frames }
    }
}

impl From<wire::Divergence> for Divergence {
    fn from(d: wire::Divergence) -> Self {
        Self { instance: d.instance as usize, frame: d.frame as usize, node: d.node as usize }
    }
}

pub(super) fn grasping(wire: v1::Grasping) -> Result<Grasping, Error> {
    let numbers = |tensor: Option<Tensor>, name| -> Result<Vec<u32>, Error> {
        let tensor = tensor.unwrap_or_default();
        Ok(tensor.unpack::<u32>(name).map_err(Error::malformed)?.1)
    };
    Ok(Grasping {
        phases: numbers(wire.phases, "phases")?,
        holders: numbers(wire.holders, "holders")?,
        places: points(wire.places, "places")?,
    })
}

fn values(tensor: Option<Tensor>, name: &'static str) -> Result<Vec<f64>, Error> {
    let Some(tensor) = tensor.filter(|t| !t.is_absent()) else { return Ok(Vec::new()) };
    Ok(tensor.unpack::<f64>(name).map_err(Error::malformed)?.1)
}

pub(super) fn floats(tensor: Option<Tensor>, name: &'static str) -> Result<Vec<f32>, Error> {
    let Some(tensor) = tensor.filter(|t| !t.is_absent()) else { return Ok(Vec::new()) };
    Ok(tensor.unpack::<f32>(name).map_err(Error::malformed)?.1)
}

fn indices(tensor: Option<Tensor>, name: &'static str) -> Result<Vec<usize>, Error> {
    let Some(tensor) = tensor.filter(|t| !t.is_absent()) else { return Ok(Vec::new()) };
    let (_, values) = tensor.unpack::<u32>(name).map_err(Error::malformed)?;
    Ok(values.into_iter().map(|v| v as usize).collect())
}

pub(super) fn points(tensor: Option<Tensor>, name: &'static str) -> Result<Vec<Point>, Error> {
    let Some(tensor) = tensor.filter(|t| !t.is_absent()) else { return Ok(Vec::new()) };
    Ok(tensor.unpack_points(name).map_err(Error::malformed)?.1)
}

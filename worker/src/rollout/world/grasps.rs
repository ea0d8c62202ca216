//! Grasps of a request as the engine knows them.

use std::sync::Arc;

use bendtwin_core::Twin;
use bendtwin_engine::{
    Model, stable_substeps,
    world::{Attachment, Grasp, Region},
};
use bendtwin_proto::v1::{self, grasp};

use super::{GripperOfControl, shapes::three};
use crate::rollout::error::Error;

/// Largest eigenvalue of dt² K + 2 dt C of a stable substep.
const STABLE: f64 = 4.0;
/// Part of that which loading a model keeps free, so that a hold of chosen stiffness has room.
const FREE: f64 = 0.16;

/// The object that is held.
pub(super) struct Held<'a> {
    pub(super) twin: &'a Twin,
    /// The model of it that is simulated.
    pub(super) model: &'a Model,
    pub(super) map: GripperOfControl,
}

/// The `index`-th grasp of a checked request.
pub(super) fn read(wire: v1::Grasp, index: usize, held: &Held<'_>) -> Result<Grasp, Error> {
    let field = |part: &str| format!("grasps[{index}].{part}");
    let attachment = attachment(&wire, held, &field)?;
    let region = match wire.region {
        None => return Err(Error::field(field("region"), "is missing")),
        Some(grasp::Region::Sphere(sphere)) => {
            Region::Sphere { center: three(&sphere.center), radius_m: sphere.radius_m }
        }
        Some(grasp::Region::Cuboid(cuboid)) => {
            Region::Box { low: three(&cuboid.low), high: three(&cuboid.high) }
        }
        Some(grasp::Region::Nodes(nodes)) => {
            let (_, mut nodes) = nodes.unpack::<u32>(&field("nodes"))?;
            nodes.sort_unstable();
            Region::Nodes(Arc::new(nodes))
        }
        Some(grasp::Region::Hand(hand)) => {
            Region::Controls(Arc::new(controls(hand.hand, wire.gripper, held, &field)?))
        }
    };
    let unit = newtons_per_unit(held.twin);
    let max_force = wire.max_force_n.map_or(f32::INFINITY, |force| (force / unit) as f32);
    Ok(Grasp { body: wire.gripper, region, attachment, max_force })
}

/// Newtons of a force of 1 at unit node mass.
pub(in crate::rollout) fn newtons_per_unit(_twin: &Twin) -> f64 {
    1.0
}

/// Control points of a hand, which must be carried by the grasp's gripper.
fn controls(
    hand: u32,
    gripper: u32,
    held: &Held<'_>,
    field: &impl Fn(&str) -> String,
) -> Result<Vec<u32>, Error> {
    let count = held.twin.graph.control_count() as u32;
    let controls: Vec<u32> = (0..count).filter(|_| hand == 0).collect();
    if controls.is_empty() {
        let fault = format!("is {hand}: the twin has control points of hand 0 alone");
        return Err(Error::field(field("hand.hand"), fault));
    }
    let carrier = |c: u32| held.map.as_ref().and_then(|map| map.get(c as usize)).copied();
    match controls.iter().find(|c| carrier(**c) != Some(gripper)) {
        None => Ok(controls),
        Some(c) => {
            let other = carrier(*c).unwrap_or(0);
            let fault = format!(
                "is {gripper}, but control point {c} of hand {hand} is carried by gripper {other}: name that, or change `poses.gripper_of_control`"
            );
            Err(Error::field(field("gripper"), fault))
        }
    }
}

/// A hold's springs. Without numbers, the stiffest with critical damping that is stable whatever the
/// twin's own springs are: with s = dt sqrt(k / m) the hold adds s² + 4 s, for which loading keeps
/// [`FREE`] free.
fn attachment(
    wire: &v1::Grasp,
    held: &Held<'_>,
    field: &impl Fn(&str) -> String,
) -> Result<Attachment, Error> {
    if wire.attachment() != grasp::Attachment::Springs {
        return Ok(Attachment::Pin);
    }
    let (model, unit) = (held.model, newtons_per_unit(held.twin));
    let (given, damping) = (f64::from(wire.stiffness) / unit, f64::from(wire.damping) / unit);
    let dt = model.timing.dt_s();
    let masses = model.graph.masses.iter().copied().map(f64::from);
    let mass = masses.fold(f64::INFINITY, f64::min).min(f64::MAX);
    let critical = |stiffness: f64| 2.0 * (stiffness * mass).sqrt();
    let share = (STABLE + FREE).sqrt() - 2.0;
    let chosen = mass * (share / dt).powi(2);
    let stiffness = if given > 0.0 { given } else { chosen };
    let damping = if damping > 0.0 { damping } else { critical(stiffness) };
    let needed = (dt * dt * stiffness + 2.0 * dt * damping) / mass;
    if needed > FREE * (1.0 + 1e-9) {
        // There may be more room than what loading keeps free: the share grows with dt at least.
        let own = STABLE * dt / stable_substeps(model).dt_s;
        if needed > STABLE - own {
            let fault = format!(
                "and damping are too much for the twin's {} substeps: a stiffness of {:.4e} with a damping of 0, which stands for critical, is stable, and chosen for 0",
                model.timing.substeps,
                unit * chosen
            );
            return Err(Error::field(field("stiffness"), fault));
        }
    }
    Ok(Attachment::Spring { stiffness: stiffness as f32, damping: damping as f32 })
}

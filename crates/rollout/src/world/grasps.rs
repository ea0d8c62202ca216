//! Grasps of a request as the engine knows them.

use std::sync::Arc;

use bendtwin_core::Twin;
use bendtwin_engine::{
    Model,
    world::{Attachment, Grasp, Region, largest_stiffness, spring_share},
};
use bendtwin_proto::v1::{self, grasp};

use super::{GripperOfControl, shapes::three};
use crate::error::Error;

/// The object that is held.
pub(super) struct HoldContext<'a> {
    pub(super) twin: &'a Twin,
    /// The model of it that is simulated.
    pub(super) model: &'a Model,
    pub(super) map: GripperOfControl,
}

/// The `index`-th grasp of a checked request.
pub(super) fn read(wire: v1::Grasp, index: usize, held: &HoldContext<'_>) -> Result<Grasp, Error> {
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
    let unit = held.twin.newtons_per_unit();
    let max_force = wire.max_force_n.map_or(f32::INFINITY, |force| (force / unit) as f32);
    Ok(Grasp { body: wire.gripper, region, attachment, max_force })
}

/// Control points of a hand, which must be carried by the grasp's gripper.
fn controls(
    hand: u32,
    gripper: u32,
    held: &HoldContext<'_>,
    field: &impl Fn(&str) -> String,
) -> Result<Vec<u32>, Error> {
    let hands = held.twin.hands();
    let of = hands.iter().zip(0u32..).filter(|(of, _)| **of == hand);
    let controls: Vec<u32> = of.map(|(_, control)| control).collect();
    if controls.is_empty() {
        let count = hands.iter().max().map_or(0, |last| last + 1);
        let fault = format!("is {hand}: the twin has {count} hands (counted from 0)");
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

/// Springs of a hold. Without numbers, the stiffest with critical damping that is stable,
/// independent of the twin's springs.
fn attachment(
    wire: &v1::Grasp,
    held: &HoldContext<'_>,
    field: &impl Fn(&str) -> String,
) -> Result<Attachment, Error> {
    if wire.attachment() != grasp::Attachment::Springs {
        return Ok(Attachment::Pin);
    }
    let (model, unit) = (held.model, held.twin.newtons_per_unit() as f32);
    let masses = model.graph.masses.iter().copied();
    let lightest = masses.fold(f32::MAX, f32::min);
    let critical = |stiffness: f32| 2.0 * (stiffness * lightest).sqrt();
    let chosen = stiffest(model, critical);
    let stiffness = if wire.stiffness > 0.0 { wire.stiffness / unit } else { chosen };
    let damping = if wire.damping > 0.0 { wire.damping / unit } else { critical(stiffness) };
    if spring_share(model, stiffness, damping) > 1.0 {
        let fault = format!(
            "and damping are too much for the twin's {} substeps: {:.4e} with a damping of 0, which stands for critical, is stable, and chosen for 0",
            model.timing.substeps,
            unit * chosen
        );
        return Err(Error::field(field("stiffness"), fault));
    }
    Ok(Attachment::Spring { stiffness, damping })
}

/// The largest stiffness, within a thousandth, that is stable with its damping.
fn stiffest(model: &Model, damping: impl Fn(f32) -> f32) -> f32 {
    // Damping takes its own share, so it is less than the largest without any.
    let (mut low, mut high) = (0.0, largest_stiffness(model).min(f32::MAX));
    for _ in 0..64 {
        if high - low <= 1e-3 * low {
            break;
        }
        // Between their orders of magnitude once there is one.
        let middle = if low > 0.0 { f32::midpoint(low, high) } else { high / 16.0 };
        if spring_share(model, middle, damping(middle)) <= 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

//! Costs of lists of points: their order, and their winding around a line.

use bendtwin_proto::v1::{
    Capsule, Tensor, World,
    collider::{Carrier, Shape},
    cost::{
        Order, Winding,
        winding::{Around, Axis},
    },
};

use super::named;
use crate::rollout::{
    Error,
    request::{
        numbers::{unit, vector, within_range},
        tensors::given,
        world::FARTHEST_M,
    },
};

/// Most turns around a line, either way.
const MOST_TURNS: f32 = 100.0;
/// Shortest axis of a capsule that has a direction [m].
const SHORTEST_AXIS_M: f32 = 1e-6;

pub(super) fn order(order: &Order, field: &impl Fn(&str) -> String) -> Result<(), Error> {
    let Order { nodes, skin_points, direction, gap_m } = order;
    at_least_two([nodes, skin_points].map(Option::as_ref), "order", field)?;
    unit(direction, &field("order.direction"))?;
    within_range(Some(*gap_m), &field("order.gap_m"), 0.0..=FARTHEST_M)
}

/// Checks a winding; `world` is that of the request, or absent if the request is in that of a session,
/// which the worker knows.
pub(super) fn winding(
    winding: &Winding,
    world: Option<&World>,
    field: &impl Fn(&str) -> String,
) -> Result<(), Error> {
    let Winding { nodes, skin_points, around, turns } = winding;
    at_least_two([nodes, skin_points].map(Option::as_ref), "winding", field)?;
    match around {
        None => {
            return Err(Error::field(field("winding.around"), "is missing: give axis or collider"));
        }
        Some(Around::Axis(Axis { point, direction })) => {
            vector(point, &field("winding.axis.point"), FARTHEST_M)?;
            unit(direction, &field("winding.axis.direction"))?;
        }
        Some(Around::Collider(number)) => {
            let collider = world.and_then(|world| world.colliders.get(*number as usize));
            if let Some(collider) = collider {
                let has_axis = match &collider.shape {
                    Some(Shape::Capsule(capsule)) => has_length(capsule),
                    _ => false,
                };
                let is_fixed = matches!(collider.carrier, None | Some(Carrier::Fixed(_)));
                if !has_axis || !is_fixed {
                    let fault = format!(
                        "names collider {number}, which is no fixed capsule with a length: give the line as `axis`"
                    );
                    return Err(Error::field(field("winding.collider"), fault));
                }
            }
        }
    }
    within_range(Some(*turns), &field("winding.turns"), -MOST_TURNS..=MOST_TURNS)
}

fn at_least_two(
    [nodes, skin_points]: [Option<&Tensor>; 2],
    kind: &str,
    field: &impl Fn(&str) -> String,
) -> Result<(), Error> {
    let (points, _) = named(nodes, skin_points, kind, field)?;
    if points.shape[..] == [1] {
        let set = if given(nodes).is_some() { "nodes" } else { "skin_points" };
        let fault = "has one point: at least two are needed, in their order";
        return Err(Error::field(field(&format!("{kind}.{set}")), fault));
    }
    Ok(())
}

/// True if the axis of a capsule has a direction; one whose ends are no points is refused later.
fn has_length(capsule: &Capsule) -> bool {
    let ends = capsule.from.iter().zip(&capsule.to);
    ends.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) > SHORTEST_AXIS_M
}

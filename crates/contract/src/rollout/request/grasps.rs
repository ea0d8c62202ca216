//! Grasps: regions, attachments, and when they are closed.

use bendtwin_proto::v1::{
    Grasp, Tensor,
    grasp::{Attachment, Region},
    tensor::Dtype,
};

use super::{
    Asked, Error, Moves, Price, TwinShape,
    initial::state_bytes,
    mul,
    numbers::least,
    sum,
    tensors::{given, index_list, indices, known_nodes, required},
    world::{cuboid, gripper, parts, sphere},
};

/// A node that a grasp may hold [bytes].
const HOLD: u64 = 20;

pub(in crate::rollout) fn check(grasps: &[Grasp], moves: &Moves) -> Result<(), Error> {
    parts("grasps", grasps.len())?;
    let mut hands = Vec::new();
    for (i, grasp) in grasps.iter().enumerate() {
        let field = |part: &str| format!("grasps[{i}].{part}");
        gripper(grasp.gripper, &field("gripper"), moves)?;
        match &grasp.region {
            None => {
                let fault = "is missing: give sphere, cuboid, nodes or hand";
                return Err(Error::field(field("region"), fault));
            }
            Some(Region::Sphere(s)) => sphere(s, &field("sphere"))?,
            Some(Region::Cuboid(c)) => cuboid(c, &field("cuboid"))?,
            Some(Region::Nodes(nodes)) => index_list(Some(nodes), &field("nodes")).map(drop)?,
            Some(Region::Hand(hand)) if hands.contains(&hand.hand) => {
                let fault = format!("is {}, which an earlier grasp has", hand.hand);
                return Err(Error::field(field("hand.hand"), fault));
            }
            Some(Region::Hand(hand)) => hands.push(hand.hand),
        }
        attachment(grasp, field)?;
        if let Some(closed) = given(grasp.closed.as_ref()) {
            self::closed(closed, &field("closed"), moves)?;
        }
        if let Some(force) = grasp.max_force_n
            && !(force.is_finite() && force > 0.0)
        {
            let fault = format!("is {force}: it must be finite and above 0, or absent for never");
            return Err(Error::field(field("max_force_n"), fault));
        }
    }
    Ok(())
}

pub(in crate::rollout) fn check_for(grasps: &[Grasp], twin: &TwinShape) -> Result<(), Error> {
    for (i, grasp) in grasps.iter().enumerate() {
        if let Some(Region::Nodes(nodes)) = &grasp.region {
            distinct_nodes(nodes, &format!("grasps[{i}].nodes"), twin)?;
        }
    }
    Ok(())
}

fn attachment(grasp: &Grasp, field: impl Fn(&str) -> String) -> Result<(), Error> {
    let Ok(attachment) = Attachment::try_from(grasp.attachment) else {
        let fault = format!("has the unknown value {}: use PIN or SPRINGS", grasp.attachment);
        return Err(Error::field(field("attachment"), fault));
    };
    for (part, value) in [("stiffness", grasp.stiffness), ("damping", grasp.damping)] {
        least(value, &field(part), 0.0)?;
        let is_hand = matches!(grasp.region, Some(Region::Hand(_)));
        if value > 0.0 && (attachment != Attachment::Springs || is_hand) {
            let fault = if is_hand {
                "is that of the capture's hand, held as it was fitted: leave it out"
            } else {
                "belongs to SPRINGS: leave it out, or set `attachment` to SPRINGS"
            };
            return Err(Error::field(field(part), fault));
        }
    }
    Ok(())
}

fn closed(closed: &Tensor, field: &str, moves: &Moves) -> Result<(), Error> {
    let (tensor, shape) = required(Some(closed), field, Dtype::Uint32)?;
    let fits = match (&shape[..], moves.knots) {
        ([1], _) => true,
        ([own] | [_, own], Some(k)) if own != &k => false,
        ([_], _) => true,
        ([instances, _], Some(_)) => *instances == moves.instances,
        // Instances come with the actions too.
        ([_, _], None) => true,
        _ => false,
    };
    if !fits {
        let k = moves.knots.map_or("K".to_owned(), |knots| knots.to_string());
        let b = moves.instances;
        let fault = format!(
            "has shape {shape:?}, not [1], [{k}] or [{b}, {k}]: a value for each knot, or one for all"
        );
        return Err(Error::field(field, fault));
    }
    match indices(tensor).find(|value| *value > 1) {
        Some(value) => Err(Error::field(field, format!("has {value}: 1 is closed and 0 is open"))),
        None => Ok(()),
    }
}

/// Refuses nodes that the twin has not, and a node named twice.
fn distinct_nodes(nodes: &Tensor, field: &str, twin: &TwinShape) -> Result<(), Error> {
    known_nodes(nodes, field, twin.nodes)?;
    let mut sorted: Vec<u32> = indices(nodes).collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(Error::field(field, format!("names node {} twice", pair[0]))),
        None => Ok(()),
    }
}

/// Nodes that grasps hold, and times at which they are closed.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let grasps = &asked.request.grasps;
    if grasps.is_empty() {
        return Price::default();
    }
    let regions = grasps
        .iter()
        .filter(|grasp| matches!(grasp.region, Some(Region::Sphere(_) | Region::Cuboid(_))));
    Price {
        work_of_node: regions.count() as u64,
        // What grasps hold at the end says which nodes they took.
        prepared: sum(&[state_bytes(asked), mul(&[asked.boundaries, grasps.len() as u64])]),
        ..Price::default()
    }
}

/// Memory of what the grasps of a state hold [bytes].
pub(super) fn hold_bytes(asked: &Asked<'_>) -> u64 {
    if asked.request.grasps.is_empty() { 0 } else { mul(&[HOLD, asked.twin.nodes]) }
}

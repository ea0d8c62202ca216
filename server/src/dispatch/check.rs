//! What can be said about a rollout request without physics: whether its
//! tensors fit the twin and one another, and whether it stays within limits.
//! Workers check the rest.

use bendtwin_proto::{
    tensor::TensorError,
    v1::{RollOutRequest, Tensor, cost, initial_state, roll_out_request::Actions, tensor::Dtype},
};
use bendtwin_store::TwinFacts;

use crate::{
    failure::{Error, Result},
    options::Limits,
};

const MOST_FRAMES: u64 = 100_000;
const MOST_COSTS: usize = 64;

/// Checks a request against the twin that it names.
pub(super) fn check(request: &RollOutRequest, twin: &TwinFacts, limits: &Limits) -> Result<()> {
    let (nodes, controls) = (u64::from(twin.node_count), u64::from(twin.control_count));
    let [batch, knots] = actions(request, controls)?;
    let frames = match request.frames {
        0 => knots - 1,
        n => u64::from(n),
    };
    if !(1..=MOST_FRAMES).contains(&frames) {
        return Err(Error::invalid("frames", format!("is {frames}: use 1..={MOST_FRAMES}")));
    }
    if batch > limits.rollout_instances {
        let most = limits.rollout_instances;
        let fault = format!("has {batch} instances, the limit is {most}: split the batch");
        return Err(Error::invalid("actions", fault));
    }
    let points = batch.saturating_mul(frames).saturating_mul(nodes);
    if points > limits.rollout_points {
        let most = limits.rollout_points;
        return Err(Error::invalid(
            "frames",
            format!("times instances times nodes is {points}, the limit is {most}: ask for less"),
        ));
    }
    initial(request, batch, nodes)?;
    costs(request)?;
    reply_size(request, [batch, frames, nodes, controls], limits)
}

/// The batch size B and the number of knots K.
fn actions(request: &RollOutRequest, controls: u64) -> Result<[u64; 2]> {
    let shape = match &request.actions {
        None => return Err(Error::invalid("actions", "are missing: give trajectories or poses")),
        Some(Actions::Trajectories(t)) => {
            let shape = tensor(t.positions.as_ref(), "trajectories.positions", FLOATS)?;
            if shape.get(2).is_some_and(|c| *c != controls) {
                return Err(Error::invalid(
                    "trajectories.positions",
                    format!("has shape {shape:?} but the twin has {controls} control points"),
                ));
            }
            ranked(shape, 3, "trajectories.positions", "[B, K, C, 3]")?
        }
        Some(Actions::Poses(p)) => {
            if let Some(map) = p.gripper_of_control.as_ref().filter(|t| !t.is_absent()) {
                let shape = tensor(Some(map), "poses.gripper_of_control", &[Dtype::Uint32])?;
                if shape != [controls] {
                    return Err(Error::invalid(
                        "poses.gripper_of_control",
                        format!("has shape {shape:?}, not [{controls}]"),
                    ));
                }
            }
            let shape = tensor(p.poses.as_ref(), "poses.poses", FLOATS)?;
            ranked(shape, 7, "poses.poses", "[B, K, G, 7]")?
        }
    };
    let [batch, knots] = shape;
    if batch == 0 || knots < 2 {
        let fault = format!("hold {batch} instances of {knots} rows: give at least 1 and 2");
        return Err(Error::invalid("actions", fault));
    }
    Ok([batch, knots])
}

fn initial(request: &RollOutRequest, batch: u64, nodes: u64) -> Result<()> {
    let Some(initial_state::State::Given(given)) =
        request.initial.as_ref().and_then(|i| i.state.as_ref())
    else {
        return Ok(());
    };
    let positions = tensor(given.positions.as_ref(), "initial.given.positions", FLOATS)?;
    if positions != [nodes, 3] && positions != [batch, nodes, 3] {
        let fault = format!("has shape {positions:?}, not [{nodes}, 3] or [{batch}, {nodes}, 3]");
        return Err(Error::invalid("initial.given.positions", fault));
    }
    if let Some(velocities) = given.velocities.as_ref().filter(|t| !t.is_absent()) {
        let velocities = tensor(Some(velocities), "initial.given.velocities", FLOATS)?;
        if velocities != positions {
            let fault = format!("has shape {velocities:?}, not that of the positions");
            return Err(Error::invalid("initial.given.velocities", fault));
        }
    }
    if let Some(twists) = given.twists.as_ref().filter(|t| !t.is_absent()) {
        // How many rods the twin has is for the worker to say.
        let twists = tensor(Some(twists), "initial.given.twists", FLOATS)?;
        let batched = positions.len() == 3;
        if twists.len() != positions.len() - 1 || batched && twists[0] != batch {
            let fault = format!("has shape {twists:?} beside positions of shape {positions:?}");
            return Err(Error::invalid("initial.given.twists", fault));
        }
    }
    Ok(())
}

fn costs(request: &RollOutRequest) -> Result<()> {
    if request.costs.len() > MOST_COSTS {
        return Err(Error::invalid("costs", format!("are more than {MOST_COSTS}")));
    }
    for cost in &request.costs {
        if !cost.weight.is_finite() {
            return Err(Error::invalid("costs.weight", "is not finite"));
        }
        if cost.name.len() > 128 || cost.name.chars().any(char::is_control) {
            return Err(Error::invalid("costs.name", "is longer than 128 bytes or not printable"));
        }
        match &cost.kind {
            None => return Err(Error::invalid("costs.kind", "is missing")),
            Some(cost::Kind::TargetCloud(c)) => {
                tensor(c.points.as_ref(), "costs.target_cloud.points", FLOATS)?;
            }
            Some(cost::Kind::Keypoints(k)) => {
                tensor(k.nodes.as_ref(), "costs.keypoints.nodes", &[Dtype::Uint32])?;
                tensor(k.targets.as_ref(), "costs.keypoints.targets", FLOATS)?;
            }
            Some(cost::Kind::Smoothness(_)) => {}
        }
    }
    Ok(())
}

/// Refuses replies that could not be sent anyway before they are computed.
fn reply_size(
    request: &RollOutRequest,
    [batch, frames, nodes, controls]: [u64; 4],
    limits: &Limits,
) -> Result<()> {
    let Some(returns) = &request.returns else { return Ok(()) };
    let chosen = match &returns.nodes {
        Some(t) if !t.is_absent() => {
            tensor(Some(t), "returns.nodes", &[Dtype::Uint32])?.iter().product()
        }
        _ => nodes,
    };
    let instances = match returns.best {
        0 => batch,
        best => u64::from(best).min(batch),
    };
    let width =
        if returns.encoding() == bendtwin_proto::v1::returns::Encoding::Int16 { 2 } else { 4 };
    let recorded = frames.checked_div(u64::from(returns.every_frames)).unwrap_or(0);
    let values =
        |rows: u64, columns: u64| instances.saturating_mul(rows).saturating_mul(columns * 3);
    let mut bytes = values(recorded, chosen).saturating_mul(width);
    if returns.final_state {
        bytes = bytes.saturating_add(values(2, nodes).saturating_mul(4));
    }
    if returns.control_gradients {
        bytes = bytes.saturating_add(values(frames + 1, controls).saturating_mul(4));
    }
    if bytes > limits.rollout_bytes as u64 {
        return Err(Error::invalid(
            "returns",
            format!(
                "would be {bytes} bytes, the limit is {}: ask for fewer nodes, every k-th frame or \
                 the best instances only",
                limits.rollout_bytes
            ),
        ));
    }
    Ok(())
}

const FLOATS: &[Dtype] = &[Dtype::Float32];

/// The shape of a tensor whose type is one of those and whose bytes account for it.
fn tensor(tensor: Option<&Tensor>, name: &'static str, types: &[Dtype]) -> Result<Vec<u64>> {
    let tensor = tensor.ok_or_else(|| Error::invalid(name, "is missing"))?;
    let invalid = |TensorError { name, fault }| Error::Invalid { field: name, fault };
    let shape = tensor.checked_shape(name).map_err(invalid)?;
    if !types.contains(&tensor.dtype()) {
        let fault =
            format!("has dtype {}, not {}", tensor.dtype().as_str_name(), types[0].as_str_name());
        return Err(Error::invalid(name, fault));
    }
    Ok(shape.into_iter().map(|d| d as u64).collect())
}

fn ranked(shape: Vec<u64>, last: u64, name: &'static str, want: &str) -> Result<[u64; 2]> {
    match shape[..] {
        [batch, knots, _, width] if width == last => Ok([batch, knots]),
        _ => Err(Error::invalid(name, format!("has shape {shape:?}, not {want}"))),
    }
}

#[cfg(test)]
mod tests;

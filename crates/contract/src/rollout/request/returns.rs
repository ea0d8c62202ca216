//! Returns: what the reply is to hold.

use bendtwin_proto::v1::{PointSet, Returns, RollOutRequest, returns::Encoding};

use super::{
    Error, TwinShape,
    tensors::{given, index_list, known_nodes, known_skin_points},
    vary::members,
};
use crate::rollout::points::{point_set, recorded};

const NODES: &str = "returns.nodes";
const SKIN_POINTS: &str = "returns.skin_points";
const POINT_SET: &str = "returns.point_set";

pub(super) fn check(request: &RollOutRequest) -> Result<(), Error> {
    let Some(returns) = &request.returns else { return Ok(()) };
    if Encoding::try_from(returns.encoding).is_err() {
        let fault = format!("has the unknown value {}: use FLOAT32 or INT16", returns.encoding);
        return Err(Error::field("returns.encoding", fault));
    }
    point_set(returns.point_set, POINT_SET)?;
    let chosen = [
        (NODES, &returns.nodes, PointSet::Nodes),
        (SKIN_POINTS, &returns.skin_points, PointSet::Skin),
    ];
    for (field, tensor, of) in chosen {
        if let Some(tensor) = given(tensor.as_ref()) {
            index_list(Some(tensor), field)?;
            if recorded(returns) != of {
                let set = of.as_str_name();
                let fault = format!("are of another point set: set `{POINT_SET}` to {set}");
                return Err(Error::field(field, fault));
            }
        }
    }
    let gradients = [
        ("returns.control_gradients", returns.control_gradients),
        ("returns.action_gradients", returns.action_gradients),
        ("returns.initial_gradients", returns.initial_gradients),
        ("returns.gradient_norms", returns.gradient_norms),
    ];
    if let Some((field, _)) = gradients.into_iter().find(|(_, wanted)| *wanted)
        && request.costs.is_empty()
    {
        let fault = "needs at least one cost to differentiate: add one to `costs`";
        return Err(Error::field(field, fault));
    }
    if returns.velocities && returns.every_frames == 0 {
        let fault = "are recorded with positions: set `returns.every_frames`, 1 say";
        return Err(Error::field("returns.velocities", fault));
    }
    if returns.spread && returns.every_frames == 0 {
        let fault = "is of recorded points: set `returns.every_frames`, 1 say";
        return Err(Error::field("returns.spread", fault));
    }
    if returns.spread && members(request) < 2 {
        let fault = "is between the members of an ensemble: give an `ensemble` of two or more";
        return Err(Error::field("returns.spread", fault));
    }
    Ok(())
}

/// True if a reply has the spread of an ensemble, and arrays of its first member alone.
pub fn has_spread(request: &RollOutRequest) -> bool {
    request.returns.as_ref().is_some_and(|returns| returns.spread)
}

/// True if a reply needs a run backward.
pub fn has_gradients(returns: &Returns) -> bool {
    returns.control_gradients
        || returns.action_gradients
        || returns.initial_gradients
        || returns.gradient_norms
}

pub(super) fn check_for(returns: Option<&Returns>, twin: &TwinShape) -> Result<(), Error> {
    let Some(returns) = returns else { return Ok(()) };
    if recorded(returns) == PointSet::Skin {
        has_skin(twin, POINT_SET)?;
    }
    if let Some(nodes) = given(returns.nodes.as_ref()) {
        known_nodes(nodes, NODES, twin.nodes)?;
    }
    match given(returns.skin_points.as_ref()) {
        Some(points) => known_skin_points(points, SKIN_POINTS, twin.skin_points),
        None => Ok(()),
    }
}

/// Refuses the skin of a twin that has neither a skin nor surface nodes.
pub(super) fn has_skin(twin: &TwinShape, field: &str) -> Result<(), Error> {
    if twin.skin_points == Some(0) {
        let fault = "is SKIN, and the twin has no surface: use NODES";
        return Err(Error::field(field, fault));
    }
    Ok(())
}

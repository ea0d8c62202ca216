//! Returns: what the reply is to hold.

use super::{
    Error, TwinShape,
    tensors::{given, known_nodes, node_list},
};
use crate::v1::{Returns, RollOutRequest, returns::Encoding};

const NODES: &str = "returns.nodes";

pub(super) fn check(request: &RollOutRequest) -> Result<(), Error> {
    let Some(returns) = &request.returns else { return Ok(()) };
    if Encoding::try_from(returns.encoding).is_err() {
        let fault = format!("has the unknown value {}: use FLOAT32 or INT16", returns.encoding);
        return Err(Error::field("returns.encoding", fault));
    }
    if let Some(nodes) = given(returns.nodes.as_ref()) {
        node_list(Some(nodes), NODES)?;
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
    Ok(())
}

/// True if a reply needs a run backward.
pub fn has_gradients(returns: &Returns) -> bool {
    returns.control_gradients
        || returns.action_gradients
        || returns.initial_gradients
        || returns.gradient_norms
}

pub(super) fn check_for(returns: Option<&Returns>, twin: &TwinShape) -> Result<(), Error> {
    match returns.and_then(|r| given(r.nodes.as_ref())) {
        Some(nodes) => known_nodes(nodes, NODES, twin.nodes),
        None => Ok(()),
    }
}

//! The rules of the contract on requests that are right but for one thing.

mod encoded;
mod pictures;
mod plans;
mod prices;
mod registrations;
mod rollouts;

use bendtwin_contract::rollout::TwinShape;

/// 5 nodes that hang from a control point.
const TWIN: TwinShape = TwinShape {
    nodes: 5,
    springs: 4,
    triplets: 3,
    controls: 1,
    skin_points: Some(9),
    rods: Some(0),
    substeps: 10,
    fast_substeps: None,
    planner: None,
    has_capture: false,
};

//! Point sets that requests name: what costs measure, and what is recorded.

use bendtwin_proto::v1::{Cost, PointSet, Returns, cost::Kind};

use super::{Error, request::tensors::given, twin::TwinShape};

/// Refuses a point set that this build does not know.
pub(super) fn point_set(wire: i32, field: &str) -> Result<(), Error> {
    match PointSet::try_from(wire) {
        Ok(_) => Ok(()),
        Err(_) => {
            let fault = format!("has the unknown value {wire}: use NODES or SKIN");
            Err(Error::field(field, fault))
        }
    }
}

/// Point set whose distance to target points is measured: that of a target cloud or of a coverage.
pub fn measured(asked: PointSet) -> PointSet {
    match asked {
        PointSet::Unspecified | PointSet::Skin => PointSet::Skin,
        PointSet::Nodes => PointSet::Nodes,
    }
}

/// Point set whose positions and velocities are recorded.
pub fn recorded(returns: &Returns) -> PointSet {
    match returns.point_set() {
        PointSet::Unspecified | PointSet::Nodes => PointSet::Nodes,
        PointSet::Skin => PointSet::Skin,
    }
}

/// Number of points that are recorded, K.
pub(super) fn recorded_count(returns: &Returns, twin: &TwinShape) -> u64 {
    let (chosen, all) = match recorded(returns) {
        PointSet::Skin => (&returns.skin_points, twin.most_skin_points()),
        _ => (&returns.nodes, twin.nodes),
    };
    given(chosen.as_ref()).map_or(all, |t| t.shape.iter().product())
}

/// True if a cost measures named nodes, which a planner's twin places as points of its skin.
pub(super) fn measures_nodes(cost: &Cost) -> bool {
    match &cost.kind {
        Some(Kind::Keypoints(keypoints)) => given(keypoints.skin_points.as_ref()).is_none(),
        Some(_) | None => false,
    }
}

/// True if a cost places the skin.
pub(super) fn is_at_skin(cost: &Cost) -> bool {
    match &cost.kind {
        Some(Kind::TargetCloud(cloud)) => measured(cloud.point_set()) == PointSet::Skin,
        Some(Kind::Coverage(coverage)) => measured(coverage.point_set()) == PointSet::Skin,
        Some(Kind::Keypoints(keypoints)) => given(keypoints.skin_points.as_ref()).is_some(),
        Some(Kind::Order(order)) => given(order.skin_points.as_ref()).is_some(),
        Some(Kind::Winding(winding)) => given(winding.skin_points.as_ref()).is_some(),
        Some(_) | None => false,
    }
}

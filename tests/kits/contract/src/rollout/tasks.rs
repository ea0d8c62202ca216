//! Costs of order, winding and coverage with one fault each.

use bendtwin_proto::v1::{
    Cost, Tensor,
    cost::{
        Coverage, Kind, Order, Winding,
        winding::{Around, Axis},
    },
};

use super::{Named, cost, with, zeros};

fn list(points: &[u32]) -> Option<Tensor> {
    Some(Tensor::pack(&[points.len()], points))
}

/// Costs for a twin with `n` nodes.
pub(super) fn costs(n: u64) -> Named<Vec<Cost>> {
    let of = |kind| vec![cost(Some(kind))];
    let order = |change: &dyn Fn(&mut Order)| {
        let direction = vec![0.0, 1.0, 0.0];
        let mut order = Order { nodes: list(&[0, 1]), direction, gap_m: 0.01, skin_points: None };
        change(&mut order);
        of(Kind::Order(order))
    };
    let winding = |change: &dyn Fn(&mut Winding)| {
        let axis = Axis { point: vec![0.0; 3], direction: vec![0.0, 0.0, 1.0] };
        let around = Some(Around::Axis(axis));
        let mut winding = Winding { nodes: list(&[0, 1]), around, turns: 1.0, skin_points: None };
        change(&mut winding);
        of(Kind::Winding(winding))
    };
    let axis = |point: &[f32], direction: &[f32]| {
        let around = Axis { point: point.to_vec(), direction: direction.to_vec() };
        winding(&|w| w.around = Some(Around::Axis(around.clone())))
    };
    let coverage = |points: Option<Tensor>, reach_m, point_set| {
        of(Kind::Coverage(Coverage { points, reach_m, point_set }))
    };
    let cloud = || Some(zeros(&[2, 3]));
    const POINTS: &str = "`costs[0].coverage.points`";
    const REACH: &str = "`costs[0].coverage.reach_m`";
    vec![
        ("the order of nothing", "`costs[0].order.nodes`", order(&|o| o.nodes = None)),
        ("the order of one node", "`costs[0].order.nodes`", order(&|o| o.nodes = list(&[0]))),
        (
            "the order of one point of the skin",
            "`costs[0].order.skin_points`",
            order(&|o| (o.nodes, o.skin_points) = (None, list(&[0]))),
        ),
        (
            "the order of nodes and of the skin",
            "`costs[0].order.skin_points`",
            order(&|o| o.skin_points = list(&[0, 1])),
        ),
        (
            "the order of a node that is not there",
            "`costs[0].order.nodes`",
            order(&|o| o.nodes = list(&[0, n as u32])),
        ),
        (
            "an order along two numbers",
            "`costs[0].order.direction`",
            order(&|o| o.direction.truncate(2)),
        ),
        (
            "an order along a long direction",
            "`costs[0].order.direction`",
            order(&|o| o.direction = vec![1.0; 3]),
        ),
        ("a negative gap", "`costs[0].order.gap_m`", order(&|o| o.gap_m = -0.01)),
        ("a gap that is NaN", "`costs[0].order.gap_m`", order(&|o| o.gap_m = f32::NAN)),
        ("the winding of one node", "`costs[0].winding.nodes`", winding(&|w| w.nodes = list(&[0]))),
        (
            "the winding of a node that is not there",
            "`costs[0].winding.nodes`",
            winding(&|w| w.nodes = list(&[n as u32, 0])),
        ),
        (
            "the winding of a skin point that is not there",
            "`costs[0].winding.skin_points`",
            winding(&|w| (w.nodes, w.skin_points) = (None, list(&[0, u32::MAX]))),
        ),
        ("a winding around nothing", "`costs[0].winding.around`", winding(&|w| w.around = None)),
        (
            "a winding around a collider that is not there",
            "`costs[0].winding.collider`",
            winding(&|w| w.around = Some(Around::Collider(0))),
        ),
        (
            "a winding around an axis without a point",
            "`costs[0].winding.axis.point`",
            axis(&[], &[0.0, 0.0, 1.0]),
        ),
        (
            "a winding around an axis without direction",
            "`costs[0].winding.axis.direction`",
            axis(&[0.0; 3], &[0.0; 3]),
        ),
        ("101 turns", "`costs[0].winding.turns`", winding(&|w| w.turns = -101.0)),
        ("turns that are NaN", "`costs[0].winding.turns`", winding(&|w| w.turns = f32::NAN)),
        ("no points to cover", POINTS, coverage(None, 0.01, 0)),
        ("an empty list of points to cover", POINTS, coverage(Some(zeros(&[0, 3])), 0.01, 0)),
        ("points to cover by frame", POINTS, coverage(Some(zeros(&[2, 1, 3])), 0.01, 0)),
        ("NaN in the points to cover", POINTS, coverage(Some(with(&[1, 3], f32::NAN)), 0.01, 0)),
        ("no reach", REACH, coverage(cloud(), 0.0, 0)),
        ("a reach that is NaN", REACH, coverage(cloud(), f32::NAN, 0)),
        ("coverage by an unknown set", "`costs[0].coverage.point_set`", coverage(cloud(), 0.01, 9)),
    ]
}

//! Order, winding and coverage in closed form, and where their gradients end.

use std::{f64::consts::TAU, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{
    Backend, PointSet, Term,
    backend::{Gradient, GradientRequest},
    constants::LEAST_RADIUS_M,
    objective::WeightedTerm,
};

use crate::{
    expect::{Outcome, close, ensure},
    scene::{Scene, difference, norm},
};

const UP: Point = [0.0, 0.0, 1.0];

/// Nodes in these places, with a term at the start.
fn at_start(places: &[Point], term: Term) -> Scene {
    let mut scene = Scene::of(places);
    scene.last(0);
    scene.objective.groups = vec!["here".into()];
    scene.objective.terms = Arc::new(vec![WeightedTerm { frame: 0, weight: 1.0, group: 0, term }]);
    scene
}

fn gradient(scene: &Scene, backend: &dyn Backend) -> Result<(Gradient, Vec<Point>), String> {
    let request = GradientRequest { initial: true, ..GradientRequest::PARAMS };
    let gradient = scene.gradient(backend, &request)?;
    let by_nodes = gradient.initial.clone().map(|s| s.positions).unwrap_or_default();
    Ok((gradient, by_nodes))
}

fn all(count: usize) -> Arc<Vec<u32>> {
    Arc::new((0..count as u32).collect())
}

/// `count` nodes on a helix of some turns around an upright line.
fn helix(line: Point, turns: f64, count: usize) -> Vec<Point> {
    let at = |i: usize| {
        let part = i as f64 / (count - 1) as f64;
        let (sine, cosine) = (TAU * turns * part).sin_cos();
        let way = [0.05 * cosine, 0.05 * sine, 0.2 * part];
        std::array::from_fn(|k| line[k] + way[k] as f32)
    };
    (0..count).map(at).collect()
}

/// A helix of two and a half turns, either way around and either way along: to 1e-6 of a turn.
pub(crate) fn a_helix_winds_as_often_as_it_turns(backend: &dyn Backend) -> Outcome {
    let origin = [0.3, -0.2, 0.1];
    for (turns, direction, expected) in
        [(2.5, UP, 2.5), (-2.5, UP, -2.5), (2.5, [0.0, 0.0, -1.0], -2.5)]
    {
        let winding = |turns: f32| Term::Winding {
            of: PointSet::Nodes,
            points: all(40),
            origin,
            direction,
            turns,
        };
        let places = helix(origin, turns, 40);
        let met = at_start(&places, winding(expected)).loss(backend)?.total;
        close("the helix that is wanted", met, 0.0, 1e-12)?;
        let missed = at_start(&places, winding(expected + 1.5)).loss(backend)?.total;
        close("one and a half turns too few", missed, 2.25, 1e-5)?;
    }
    Ok(())
}

/// Nodes on the line have no angle, and leave values and gradients finite: what remains of the helix
/// are its turns without the two angles that its middle node was in.
pub(crate) fn points_on_the_line_have_no_angle(backend: &dyn Backend) -> Outcome {
    let origin = [0.3, -0.2, 0.1];
    let turned = |places: &[Point]| {
        let points = all(places.len());
        let of = PointSet::Nodes;
        at_start(places, Term::Winding { of, points, origin, direction: UP, turns: 0.0 })
    };
    let mut places = helix(origin, 1.0, 21);
    for away in [0.0, 0.5 * LEAST_RADIUS_M as f32] {
        // A multiple of the rounding of 0.3.
        places[10] = [origin[0] + away, origin[1], 0.4];
        let (gradient, by_nodes) = gradient(&turned(&places), backend)?;
        close("18 of 20 angles", gradient.loss.total, 0.9 * 0.9, 1e-5)?;
        ensure(by_nodes.iter().flatten().all(|x| x.is_finite()), || format!("{by_nodes:?}"))?;
        ensure(by_nodes[10] == [0.0; 3], || format!("{:?} on the line", by_nodes[10]))?;
    }
    let on_line: Vec<Point> = (0..4).map(|i| [origin[0], origin[1], 0.1 * i as f32]).collect();
    let (gradient, by_nodes) = gradient(&turned(&on_line), backend)?;
    ensure(gradient.loss.total == 0.0 && by_nodes == [[0.0; 3]; 4], || format!("{by_nodes:?}"))
}

/// The gradient turns the ends of a chain around the line: 2 (turns - wanted) / (2 pi r) along the
/// circle, opposite at the two, and nothing between. To 1e-4 of that.
pub(crate) fn only_the_ends_of_a_chain_turn(backend: &dyn Backend) -> Outcome {
    let origin = [0.1, 0.0, 0.0];
    let places = helix(origin, 1.25, 30);
    let of = PointSet::Nodes;
    let term = Term::Winding { of, points: all(30), origin, direction: UP, turns: 2.0 };
    let (_, by_nodes) = gradient(&at_start(&places, term), backend)?;
    let size = 2.0 * 0.75 / (TAU * 0.05);
    // The chain begins at angle 0 and ends at a quarter turn.
    let ends = [(0, [0.0, size, 0.0]), (29, [size, 0.0, 0.0])];
    for (node, expected) in ends {
        let apart = difference(by_nodes[node], expected.map(|x| x as f32));
        close(&format!("the gradient of node {node}"), norm(apart), 0.0, 1e-4 * size)?;
    }
    ensure(by_nodes[1..29].iter().all(|g| *g == [0.0; 3]), || format!("{by_nodes:?}"))
}

/// Points at least the gap apart along the direction, sideways wherever; one that is 2 cm behind costs
/// (gap + 2 cm)² of as many neighbours as there are, and is pulled forward.
pub(crate) fn points_in_order_cost_nothing(backend: &dyn Backend) -> Outcome {
    let order = |points: Vec<u32>| Term::Order {
        of: PointSet::Nodes,
        points: Arc::new(points),
        direction: [0.0, 1.0, 0.0],
        gap_m: 0.03,
    };
    let places = [0.0, 0.04, 0.08, 0.12].map(|y| [0.3 - 5.0 * y, y, y * y]);
    let (gradient_of_sorted, by_nodes) =
        gradient(&at_start(&places, order(vec![0, 1, 2, 3])), backend)?;
    ensure(gradient_of_sorted.loss.total == 0.0 && by_nodes == [[0.0; 3]; 4], || {
        format!("{} of sorted points", gradient_of_sorted.loss.total)
    })?;
    let mut swapped = places;
    swapped[2][1] = 0.02;
    let (gradient, by_nodes) = gradient(&at_start(&swapped, order(vec![0, 1, 2, 3])), backend)?;
    close("one point behind", gradient.loss.total, 0.05 * 0.05 / 3.0, 1e-8)?;
    let pull = 2.0 * 0.05 / 3.0;
    for (node, expected) in [(0, 0.0), (1, pull), (2, -pull), (3, 0.0)] {
        close(&format!("node {node}"), f64::from(by_nodes[node][1]), expected, 1e-6)?;
        ensure(by_nodes[node][0] == 0.0 && by_nodes[node][2] == 0.0, || "sideways".to_owned())?;
    }
    Ok(())
}

/// Points under nodes are covered, one at the reach is 1 - exp(-1/2) uncovered, far ones wholly, and
/// none pulls then. To 1e-6.
pub(crate) fn covered_points_cost_nothing(backend: &dyn Backend) -> Outcome {
    let places = [[0.0; 3], [0.1, 0.0, 0.0]];
    let covering = |targets: Vec<Point>| {
        let targets = Arc::new(targets);
        let term = Term::Coverage { of: PointSet::Nodes, targets, reach_m: 0.01 };
        at_start(&places, term)
    };
    close("all covered", covering(places.to_vec()).loss(backend)?.total, 0.0, 0.0)?;
    let at_reach = covering(vec![[0.1, 0.01, 0.0]]).loss(backend)?.total;
    close("at the reach", at_reach, 1.0 - (-0.5_f64).exp(), 1e-6)?;
    let (far, by_nodes) = gradient(&covering(vec![[0.0, 9.0, 0.0]; 3]), backend)?;
    ensure(far.loss.total == 1.0 && by_nodes == [[0.0; 3]; 2], || format!("{by_nodes:?}"))?;
    let half = covering(vec![places[0], [0.1, 0.0, 5.0]]).loss(backend)?.total;
    close("one of two", half, 0.5, 1e-6)
}

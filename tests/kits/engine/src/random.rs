//! Seeded random models and motions, public so that backends can be compared on them.

pub(crate) mod tasks;
pub(crate) mod world;

use std::sync::Arc;

use bendtwin_core::{
    Contact, Environment, Graph, NodeKind, Params, Pin, Plane, Point, Timing,
    environment::ControlVelocity, settings::TripletReference,
};
use bendtwin_engine::{
    Model, Objective, PointLoss, PointSet, Term, model::State, objective::WeightedTerm,
};
use bendtwin_graph::{
    Connectivity, LeftOut, NodeSample, SurfacePoints, Triplets, bind_skin, connect, rest_geometry,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use self::tasks::task_terms;

/// Composition of a random model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomOptions {
    /// Nodes, scattered 3 cm apart.
    pub nodes: usize,
    /// Control points near nodes, each with a few control springs.
    pub controls: usize,
    /// Nodes pinned to further control points.
    pub pins: usize,
    /// Objects, side by side along x, about to touch.
    pub objects: u32,
    /// With bending triplets.
    pub bending: bool,
    /// With dashpots, bending damping and drag.
    pub damping: bool,
    /// With gravity and a slightly tilted ground just below.
    pub ground: bool,
    /// With contact between objects and within them.
    pub contact: bool,
    /// With contact of the skin, which is around the nodes.
    pub skin_contact: bool,
    /// With a rod, clamped at the four outermost nodes; takes four pins.
    pub rod: bool,
}

impl Default for RandomOptions {
    fn default() -> Self {
        Self {
            nodes: 24,
            controls: 2,
            pins: 1,
            objects: 1,
            bending: true,
            damping: true,
            ground: false,
            contact: false,
            skin_contact: false,
            rod: false,
        }
    }
}

const SPACING_M: f32 = 0.03;

/// A random model: a pure function of its arguments. Stable at its own
/// substep (0.25 ms) with a margin of several times.
pub fn random_model(seed: u64, options: &RandomOptions) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sample = scatter(&mut rng, options);
    let connectivity = Connectivity {
        radius_m: f64::from(1.7 * SPACING_M),
        max_neighbours: 8,
        control_radius_m: f64::from(1.5 * SPACING_M),
        control_neighbours: 4,
        triplets: options
            .bending
            .then_some(Triplets { max_per_node: 4, reference: TripletReference::OppositePairs }),
        rods: false,
    };
    let mut graph = connect(&sample, &connectivity);
    graph.rods.extend(options.rod.then(|| along(&graph)).flatten());
    let skin = bind_skin(&graph, &around(&mut rng, &graph));
    let params = params(&mut rng, &graph, &sample, options);
    let gravity = if options.ground { [0.3, 0.0, -9.81] } else { [0.0; 3] };
    let ground = options.ground.then(|| {
        let (sine, cosine) = 0.1_f32.sin_cos();
        Plane { normal: [sine, 0.0, cosine], offset_m: -0.01 }
    });
    Model {
        graph: Arc::new(graph),
        skin: Arc::new(skin),
        params,
        environment: Environment { gravity, ground },
        timing: Timing { fps: 100.0, substeps: 40 },
        control_velocity: if options.rod || seed.is_multiple_of(2) {
            ControlVelocity::True
        } else {
            ControlVelocity::Ignored
        },
    }
}

/// Surface points up to a spacing away from surface nodes, two for each.
fn around(rng: &mut ChaCha8Rng, graph: &Graph) -> SurfacePoints {
    let nodes = &graph.rest_positions[..graph.surface_count()];
    let mut beside = |p: &Point| p.map(|x| x + SPACING_M * (2.0 * rng.random::<f32>() - 1.0));
    let positions: Vec<Point> = nodes.iter().flat_map(|p| [beside(p), beside(p)]).collect();
    SurfacePoints { observed_points: vec![Graph::NOT_OBSERVED; positions.len()], positions }
}

fn scatter(rng: &mut ChaCha8Rng, options: &RandomOptions) -> NodeSample {
    let n = options.nodes;
    let side = SPACING_M * (n as f32).cbrt();
    let mut points: Vec<Point> = Vec::with_capacity(n);
    // Best of several candidates: random, but without nearly coincident nodes.
    for _ in 0..n {
        let candidates: [Point; 8] =
            std::array::from_fn(|_| std::array::from_fn(|_| side * rng.random::<f32>()));
        let room = |c: &Point| {
            let gaps = points.iter().map(|p| distance_squared(*p, *c));
            gaps.fold(f32::INFINITY, f32::min)
        };
        points.extend(candidates.iter().max_by(|a, b| room(a).total_cmp(&room(b))).copied());
    }
    let object = |p: &Point| (p[0] / side * options.objects as f32) as u32;
    let object_ids = points.iter().map(|p| object(p).min(options.objects.max(1) - 1)).collect();
    let kinds = (0..n).map(|i| match i * 5 / n.max(1) {
        0..=2 => NodeKind::Observed,
        3 => NodeKind::Completed,
        _ => NodeKind::Interior,
    });
    let kinds: Vec<NodeKind> = kinds.collect();
    let observed = |(i, k): (usize, &NodeKind)| {
        if *k == NodeKind::Observed { i as u32 } else { Graph::NOT_OBSERVED }
    };
    let mut near_node = || {
        let at = points.get(rng.random_range(0..n.max(1))).copied().unwrap_or_default();
        at.map(|x| x + SPACING_M * (rng.random::<f32>() - 0.5))
    };
    let mut control_rest: Vec<Point> = (0..options.controls).map(|_| near_node()).collect();
    let outer = outermost(&points);
    let pins = (0..options.pins.min(n)).map(|i| {
        let node = if options.rod { outer[i] } else { i * n / options.pins };
        control_rest.push(points[node].map(|x| x + 0.01));
        let control = control_rest.len() as u32 - 1;
        Pin { node: node as u32, control, offset_m: [-0.01; 3] }
    });
    NodeSample {
        pins: pins.collect(),
        observed_points: kinds.iter().enumerate().map(|(i, k)| observed((i, k))).collect(),
        kinds,
        object_ids,
        control_rest,
        edges: None,
        rest_shape: None,
        point_spacing_m: 0.0,
        spacing_scale: 1.0,
        surface: Default::default(),
        left_out: LeftOut::default(),
        positions: points,
    }
}

/// Nodes from the outermost in x inwards, from both sides in turn two by two: the first four can
/// clamp a rod.
fn outermost(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    let mut outer = Vec::with_capacity(order.len());
    while !order.is_empty() {
        outer.extend(order.drain(..order.len().min(2)));
        outer.extend(order.drain(order.len().saturating_sub(2)..));
    }
    outer
}

/// A rod through up to nine nodes in the order of their x, so that it does not fold back; none if
/// its ends are not pinned.
fn along(graph: &Graph) -> Option<Vec<u32>> {
    let mut order: Vec<u32> = (0..graph.node_count() as u32).collect();
    order.sort_by(|&a, &b| {
        let x = |i: u32| graph.rest_positions[i as usize][0];
        x(a).total_cmp(&x(b))
    });
    let [first, second, inner @ .., third, fourth] = &order[..] else { return None };
    let stride = inner.len().div_ceil(5).max(1);
    let inner = inner.iter().step_by(stride);
    let rod: Vec<u32> =
        [first, second].into_iter().chain(inner).chain([third, fourth]).copied().collect();
    let ends = [first, second, third, fourth];
    let is_clamped = ends.iter().all(|i| graph.pins.iter().any(|p| p.node == **i));
    is_clamped.then_some(rod)
}

fn params(
    rng: &mut ChaCha8Rng,
    graph: &Graph,
    sample: &NodeSample,
    options: &RandomOptions,
) -> Params {
    let (e, t) = (graph.springs.len(), graph.triplets.len());
    let damping = if options.damping { 1.0 } else { 0.0 };
    let mut values = |n: usize, low: f32, high: f32| -> Vec<f32> {
        (0..n).map(|_| low * (high / low).powf(rng.random::<f32>())).collect()
    };
    let (rest_lengths_m, rest_angles_rad) = rest_geometry(graph, sample);
    Params {
        spring_stiffness: values(e, 20.0, 200.0),
        spring_dashpot: values(e, 0.1, 1.0).iter().map(|x| x * damping).collect(),
        rest_lengths_m: rest_lengths_m
            .iter()
            .zip(values(e, 0.97, 1.03))
            .map(|(l, s)| l * s)
            .collect(),
        bend_stiffness: values(t, 3e-3, 0.1),
        bend_damping: values(t, 3e-4, 1e-2).iter().map(|x| x * damping).collect(),
        rest_angles_rad: rest_angles_rad
            .iter()
            .zip(values(t, 0.9, 1.0))
            .map(|(a, s)| a * s)
            .collect(),
        twist_stiffness: values(graph.rods.len(), 0.1, 1.0),
        twist_damping: values(graph.rods.len(), 3e-4, 3e-3).iter().map(|x| x * damping).collect(),
        rest_twists_rad: values(graph.rods.len(), 0.3, 3.0).iter().map(|x| 1.0 - x).collect(),
        drag: damping * 2.0,
        contact: Contact {
            ground_restitution: 0.4,
            ground_friction: 0.3,
            object_restitution: 0.6,
            object_friction: 0.2,
            collision_distance_m: 0.6 * SPACING_M,
            between_objects: options.contact,
            within_object: options.contact,
            skin: options.skin_contact,
        },
    }
}

/// A random start near the rest shape and random smooth paths of the control
/// points: the initial state and the controls, shape [frames + 1, C, 3].
pub fn random_motion(seed: u64, model: &Model, frames: usize) -> (State, Vec<Point>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x006d_6f76_6500);
    let mut around =
        |size: f32| -> Point { std::array::from_fn(|_| size * (2.0 * rng.random::<f32>() - 1.0)) };
    let sum = |a: Point, b: Point| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let graph = &model.graph;
    let state = State {
        positions: graph.rest_positions.iter().map(|p| sum(*p, around(0.1 * SPACING_M))).collect(),
        velocities: graph.rest_positions.iter().map(|_| around(0.2)).collect(),
        twists: graph.rods.iter().map(|_| around(1.5)[0]).collect(),
        ..State::default()
    };
    let paths: Vec<(Point, Point)> =
        graph.control_rest.iter().map(|_| (around(0.002), around(0.01))).collect();
    let controls = (0..=frames).flat_map(|f| {
        let (f, paths) = (f as f32, &paths);
        graph.control_rest.iter().zip(paths).map(move |(rest, (steady, swing))| {
            let swing = swing.map(|s| s * (0.3 * f).sin());
            sum(*rest, sum(steady.map(|s| s * f), swing))
        })
    });
    let controls = controls.collect();
    (state, controls)
}

/// A half space that the lower part of a model's rest shape is outside of, and a box around its
/// middle.
fn regions(model: &Model, nodes: Option<Arc<Vec<u32>>>) -> [Term; 2] {
    let rest = &model.graph.rest_positions;
    let extreme = |pick: fn(f32, f32) -> f32| -> Point {
        let first = rest.first().copied().unwrap_or_default();
        rest.iter().fold(first, |a, b| std::array::from_fn(|k| pick(a[k], b[k])))
    };
    let (least, most) = (extreme(f32::min), extreme(f32::max));
    let between =
        |t: f32| -> Point { std::array::from_fn(|k| least[k] + t * (most[k] - least[k])) };
    let normal = [0.0, 0.6, 0.8];
    let offset_m = between(0.6).iter().zip(normal).map(|(x, n)| x * n).sum();
    [
        Term::Above { nodes: nodes.clone(), normal, offset_m },
        Term::Within { nodes, low: between(0.35), high: between(0.6) },
    ]
}

/// A random objective over surface nodes with every kind of term, a group each.
pub(crate) fn random_objective(seed: u64, model: &Model, frames: usize) -> Objective {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x006c_6f73_7300);
    let mut terms = Vec::new();
    let surface = model.graph.surface_count();
    for frame in 1..=frames {
        let mut near = |node: u32| -> Point {
            let at = model.graph.rest_positions[node as usize];
            // All a little to one side, so that common motion matters.
            at.map(|x| x + SPACING_M * (2.0 * rng.random::<f32>() - 0.7))
        };
        let nodes: Vec<u32> =
            (0..surface as u32).filter(|i| !(i + frame as u32).is_multiple_of(3)).collect();
        let targets: Vec<Point> = nodes.iter().map(|&i| near(i)).collect();
        let loss = match frame % 3 {
            0 => PointLoss::Distance,
            1 => PointLoss::SmoothL1 { beta_m: 0.02 },
            _ => PointLoss::SquaredDistance,
        };
        let points: Vec<u32> = (0..model.skin.len() as u32).step_by(2).collect();
        let skin_targets: Vec<Point> = targets.iter().cycle().take(points.len()).copied().collect();
        let of = PointSet::Skin;
        let some = frame.is_multiple_of(2).then(|| Arc::new(nodes.clone()));
        let [above, within] = regions(model, some);
        let [order, winding, coverage] = task_terms(model, PointSet::Nodes, &nodes);
        let [skin_order, skin_winding, skin_coverage] = task_terms(model, of, &points);
        let all = [
            (0, 1.5, Term::Chamfer { of: PointSet::Nodes, targets: targets.clone() }),
            (
                1,
                0.7,
                Term::Track { of: PointSet::Nodes, points: nodes, targets: targets.clone(), loss },
            ),
            (2, 0.3, Term::Acceleration),
            (3, 0.1, Term::Strain { limit: 0.01 }),
            (4, 0.8, above),
            (5, 1.1, within),
            (6, 0.9, order),
            (7, 0.02, winding),
            (8, 0.1, coverage),
            (9, 1.2, Term::Chamfer { of, targets: targets.clone() }),
            (10, 0.6, Term::Track { of, points, targets: skin_targets, loss }),
            (11, 0.8, skin_order),
            (12, 0.03, skin_winding),
            (13, 0.2, skin_coverage),
        ];
        // Without nodes at the surface there is no skin, and there are no targets.
        let all = all.into_iter().filter(|(group, ..)| *group < 9 || !targets.is_empty());
        terms.extend(all.map(|(group, weight, term)| WeightedTerm { frame, weight, group, term }));
    }
    let groups = [
        "chamfer",
        "track",
        "acceleration",
        "strain",
        "above",
        "within",
        "order",
        "winding",
        "coverage",
        "skin chamfer",
        "skin track",
        "skin order",
        "skin winding",
        "skin coverage",
    ];
    Objective { groups: groups.map(str::to_owned).to_vec(), terms: Arc::new(terms) }
}

fn distance_squared(a: Point, b: Point) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

//! Thins a twin: keeps some of its nodes, connects them again, with parameters that preserve the
//! energies of the elements that they replace, and softens them until few substeps are stable.
//!
//! **Nodes** are spread over the surface and the interior. Each stands for the nodes that are nearest to
//! it and has their mass, but not less than half of the mean, which would need finer substeps.
//! **Springs.** An affine strain ε of the object has the energy Σ k ε² l / 2 in springs of stiffness k
//! and rest length l, and Σ γ ε̇² l² is lost in dashpots γ: local means of k and γ are scaled so that
//! both sums are kept. A curvature κ has Σ kθ κ² l² / 2 in triplets with arms of mean length l, which is
//! kept, too. Springs of a control point keep the sums of k / l and of γ there.

use bendtwin_core::{
    Graph, NodeKind, Params, PlannersTwin, Point, Skin, Twin, geometry::point_distance,
    settings::TripletReference, twin::Provenance,
};
use bendtwin_engine::{Model, fidelity::Reduction};
use bendtwin_graph::{
    Connectivity, LeftOut, MIN_REST_LENGTH_M, NodeSample, SurfacePoints, Triplets, bind_skin,
    connect, farthest_points, mean_spacing, rest_geometry,
};

use super::SOFTENED;

/// Spring radius over the distance of the nodes to their sixth neighbours, and springs that a node
/// opens.
const REACH: f64 = 1.4;
const NEIGHBOURS: usize = 8;
/// Triplets of a surface node.
const TRIPLETS: usize = 2;
/// Radius of control springs over that distance, and springs that a control point opens.
const HOLD: f64 = 0.8;
const HOLDS: usize = 3;
/// Least mass of a node, over the mean.
const LEAST_MASS: f32 = 0.5;

/// The planner's twin with `nodes` nodes, before it is softened.
pub(super) fn thin(twin: &Twin, nodes: usize) -> PlannersTwin {
    let graph = &twin.graph;
    let nodes = chosen(graph, nodes);
    let (graph, params) = match nodes.len() == graph.node_count() {
        true => (graph.clone(), twin.params.clone()),
        false => joined(twin, &nodes),
    };
    let skin = bound(twin, &graph);
    let small = Twin {
        graph,
        skin,
        params,
        environment: twin.environment,
        timing: twin.timing,
        control_velocity: twin.control_velocity,
        provenance: Provenance {
            build: bendtwin_core::BUILD.to_owned(),
            source_to_world: twin.provenance.source_to_world,
            ..Provenance::default()
        },
        quality: bendtwin_core::Quality::default(),
        mass_kg: twin.mass_kg,
        control_hands: twin.control_hands.clone(),
        members: Vec::new(),
        appearance: None,
        surface: None,
        planner: None,
    };
    PlannersTwin { nodes: nodes.iter().map(|&i| i as u32).collect(), twin: Box::new(small) }
}

/// The nodes that are kept, ascending: those that pins hold, and others spread over surface and interior
/// in the shares of these.
fn chosen(graph: &Graph, count: usize) -> Vec<usize> {
    let n = graph.node_count();
    if n <= count || !graph.rods.is_empty() {
        return (0..n).collect();
    }
    let mut chosen: Vec<usize> = graph.pins.iter().map(|pin| pin.node as usize).collect();
    chosen.sort_unstable();
    chosen.dedup();
    let surface = graph.surface_count();
    let of_surface = (count * surface).div_ceil(n.max(1));
    for (candidates, upto) in [(0..surface, of_surface), (surface..n, count)] {
        let candidates: Vec<usize> = candidates.collect();
        let more = upto.saturating_sub(chosen.len());
        farthest_points(&graph.rest_positions, &candidates, &mut chosen, more, 0);
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Graph and parameters of some nodes of a twin.
fn joined(twin: &Twin, nodes: &[usize]) -> (Graph, Params) {
    let large = &twin.graph;
    let of = |values: &[u32]| -> Vec<u32> { nodes.iter().map(|&i| values[i]).collect() };
    let positions: Vec<Point> = nodes.iter().map(|&i| large.rest_positions[i]).collect();
    let kinds: Vec<NodeKind> = nodes.iter().map(|&i| large.kinds[i]).collect();
    let place = |node: u32| nodes.binary_search(&(node as usize)).ok().map(|at| at as u32);
    let pins = large
        .pins
        .iter()
        .filter_map(|pin| Some(bendtwin_core::Pin { node: place(pin.node)?, ..*pin }));
    let spacing_m = mean_spacing(&positions);
    let sample = NodeSample {
        observed_points: of(&large.observed_points),
        object_ids: of(&large.object_ids),
        control_rest: large.control_rest.clone(),
        pins: pins.collect(),
        edges: None,
        rest_shape: None,
        point_spacing_m: spacing_m,
        spacing_scale: 1.0,
        surface: SurfacePoints::default(),
        left_out: LeftOut::default(),
        positions,
        kinds,
    };
    let triplets = Triplets { max_per_node: TRIPLETS, reference: TripletReference::OppositePairs };
    let mut graph = connect(
        &sample,
        &Connectivity {
            radius_m: REACH * spacing_m,
            max_neighbours: NEIGHBOURS,
            control_radius_m: HOLD * spacing_m,
            control_neighbours: HOLDS,
            triplets: (!large.triplets.is_empty()).then_some(triplets),
            rods: false,
        },
    );
    let cells = Cells::new(large, &graph.rest_positions);
    graph.masses = cells.masses(large, graph.node_count());
    drop_idle_holds(large, &mut graph);
    let (rest_lengths_m, rest_angles_rad) = rest_geometry(&graph, &sample);
    let mut params = Params {
        spring_stiffness: vec![0.0; graph.springs.len()],
        spring_dashpot: vec![0.0; graph.springs.len()],
        bend_stiffness: vec![0.0; graph.triplets.len()],
        bend_damping: vec![0.0; graph.triplets.len()],
        rest_lengths_m,
        rest_angles_rad,
        ..twin.params.clone()
    };
    cells.scale_springs(twin, &graph, &mut params);
    cells.scale_triplets(twin, &graph, &mut params);
    scale_holds(twin, &graph, &mut params);
    (graph, params)
}

/// Leaves out springs of control points that hold nothing in the twin.
fn drop_idle_holds(large: &Graph, graph: &mut Graph) {
    let (n, many) = (graph.node_count() as u32, large.node_count() as u32);
    let mut holds = vec![false; large.control_count()];
    for &[_, end] in large.springs.iter().filter(|spring| spring[1] >= many) {
        holds[(end - many) as usize] = true;
    }
    graph.springs.retain(|spring| spring[1] < n || holds[(spring[1] - n) as usize]);
}

/// The nodes of a twin by the node that stands for them.
struct Cells {
    /// Shape [N].
    of: Vec<usize>,
    count: usize,
}

impl Cells {
    fn new(large: &Graph, nodes: &[Point]) -> Self {
        let nearest = |p: &Point| {
            let by_distance = |a: &usize, b: &usize| {
                point_distance(nodes[*a], *p).total_cmp(&point_distance(nodes[*b], *p))
            };
            (0..nodes.len()).min_by(by_distance).unwrap_or_default()
        };
        Self { of: large.rest_positions.iter().map(nearest).collect(), count: nodes.len() }
    }

    fn masses(&self, large: &Graph, n: usize) -> Vec<f32> {
        let mut masses = vec![0.0_f32; n];
        self.of.iter().zip(&large.masses).for_each(|(&cell, mass)| masses[cell] += mass);
        let whole: f32 = masses.iter().sum();
        let least = LEAST_MASS * whole / n.max(1) as f32;
        masses.iter_mut().for_each(|mass| *mass = mass.max(least));
        let more: f32 = masses.iter().sum();
        masses.iter().map(|mass| mass * whole / more).collect()
    }

    /// Means by cell of values with weights, each of which belongs to some nodes; the mean of all where a
    /// cell has none.
    fn means<const K: usize>(
        &self,
        values: impl Iterator<Item = (f64, f64, [u32; K])>,
    ) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.count];
        let (mut all, mut weights) = (0.0, 0.0);
        for (value, weight, nodes) in values {
            (all, weights) = (all + weight * value, weights + weight);
            for cell in nodes.iter().filter_map(|&node| self.of.get(node as usize)) {
                let (sum, total) = &mut sums[*cell];
                (*sum, *total) = (*sum + weight * value, *total + weight);
            }
        }
        let mean = if weights > 0.0 { all / weights } else { 0.0 };
        sums.iter().map(|(sum, total)| if *total > 0.0 { sum / total } else { mean }).collect()
    }

    fn scale_springs(&self, twin: &Twin, graph: &Graph, params: &mut Params) {
        let (large, from) = (&twin.graph, &twin.params);
        let many = large.node_count() as u32;
        let inner = || (0..large.springs.len()).filter(|&s| large.springs[s][1] < many);
        let rest = |s: usize| f64::from(from.rest_lengths_m[s]);
        let weighed = |of: &[f32], power: i32| {
            let each = inner().map(|s| (f64::from(of[s]), rest(s).powi(power), large.springs[s]));
            self.means(each)
        };
        let (stiffness, dashpot) =
            (weighed(&from.spring_stiffness, 1), weighed(&from.spring_dashpot, 2));
        // Springs that are longer or shorter at rest than the rest shape has them.
        let stretch = self.means(inner().map(|s| {
            let [a, b] = large.springs[s].map(|e| large.rest_positions[e as usize]);
            (rest(s) / point_distance(a, b).max(1e-9), 1.0, large.springs[s])
        }));
        let n = graph.node_count() as u32;
        let own = || (0..graph.springs.len()).filter(|&s| graph.springs[s][1] < n);
        for s in own() {
            let mean = |of: &[f64]| {
                let [a, b] = graph.springs[s].map(|e| of[e as usize]);
                0.5 * (a + b)
            };
            params.rest_lengths_m[s] *= mean(&stretch) as f32;
            params.rest_lengths_m[s] = params.rest_lengths_m[s].max(MIN_REST_LENGTH_M);
            params.spring_stiffness[s] = mean(&stiffness) as f32;
            params.spring_dashpot[s] = mean(&dashpot) as f32;
        }
        for power in [1, 2] {
            let sum = |of: &[f32], rest: &[f32], which: &mut dyn Iterator<Item = usize>| -> f64 {
                which.map(|s| f64::from(of[s]) * f64::from(rest[s]).powi(power)).sum()
            };
            let lengths = params.rest_lengths_m.clone();
            let (there, here) = match power {
                1 => (&from.spring_stiffness, &mut params.spring_stiffness),
                _ => (&from.spring_dashpot, &mut params.spring_dashpot),
            };
            let ratio = sum(there, &from.rest_lengths_m, &mut inner())
                / sum(here, &lengths, &mut own()).max(f64::MIN_POSITIVE);
            own().for_each(|s| here[s] = (f64::from(here[s]) * ratio) as f32);
        }
    }

    fn scale_triplets(&self, twin: &Twin, graph: &Graph, params: &mut Params) {
        let (large, from) = (&twin.graph, &twin.params);
        let arm = |graph: &Graph, [i, j, k]: [u32; 3]| {
            let [a, b, c] = [i, j, k].map(|e| graph.rest_endpoint(e));
            0.5 * (point_distance(a, b) + point_distance(b, c))
        };
        let scaled = |there: &[f32], here: &mut [f32]| {
            let each = large.triplets.iter().zip(there);
            let each = each.map(|(&t, &k)| (f64::from(k), arm(large, t).powi(2), t));
            let sum: f64 = each.clone().map(|(k, weight, _)| k * weight).sum();
            let means = self.means(each);
            for (k, &[_, centre, _]) in here.iter_mut().zip(&graph.triplets) {
                *k = means.get(centre as usize).copied().unwrap_or_default() as f32;
            }
            let own = here.iter().zip(&graph.triplets);
            let own: f64 = own.map(|(k, &t)| f64::from(*k) * arm(graph, t).powi(2)).sum();
            let ratio = sum / own.max(f64::MIN_POSITIVE);
            here.iter_mut().for_each(|k| *k = (f64::from(*k) * ratio) as f32);
        };
        scaled(&from.bend_stiffness, &mut params.bend_stiffness);
        scaled(&from.bend_damping, &mut params.bend_damping);
    }
}

/// Stiffness and dashpots of control springs: those of each control point together as in the twin.
fn scale_holds(twin: &Twin, graph: &Graph, params: &mut Params) {
    let (large, from) = (&twin.graph, &twin.params);
    let (many, n) = (large.node_count() as u32, graph.node_count() as u32);
    let mut there = vec![(0.0_f64, 0.0_f64); large.control_count()];
    for (s, &[_, end]) in large.springs.iter().enumerate().filter(|(_, spring)| spring[1] >= many) {
        let (stiffness, dashpot) = &mut there[(end - many) as usize];
        *stiffness += f64::from(from.spring_stiffness[s])
            / f64::from(from.rest_lengths_m[s].max(MIN_REST_LENGTH_M));
        *dashpot += f64::from(from.spring_dashpot[s]);
    }
    let mut counts = vec![0.0_f64; large.control_count()];
    let own: Vec<(usize, usize)> = graph
        .springs
        .iter()
        .enumerate()
        .filter(|(_, spring)| spring[1] >= n)
        .map(|(s, spring)| (s, (spring[1] - n) as usize))
        .collect();
    own.iter().for_each(|&(_, control)| counts[control] += 1.0);
    for (s, control) in own {
        let (stiffness, dashpot) = there[control];
        let rest = f64::from(params.rest_lengths_m[s]);
        params.spring_stiffness[s] = (stiffness / counts[control] * rest) as f32;
        params.spring_dashpot[s] = (dashpot / counts[control]) as f32;
    }
}

/// The points of a twin's skin and its nodes, carried by a thin graph.
fn bound(twin: &Twin, graph: &Graph) -> Skin {
    let rest = &twin.graph.rest_positions;
    let mut positions = twin.skin.positions(rest);
    let mut observed_points = twin.skin.observed_points.clone();
    positions.extend(rest);
    observed_points.extend(std::iter::repeat_n(Graph::NOT_OBSERVED, rest.len()));
    bind_skin(graph, &SurfacePoints { positions, observed_points })
}

/// A planner's twin that is stable with these substeps, with a margin: with this share of its
/// damping, and softened as far as necessary. More substeps where it would have to be softened too
/// much.
pub(super) fn softened(planner: &PlannersTwin, damping: f32, substeps: u32) -> PlannersTwin {
    let mut model = Model::from(&*planner.twin);
    let params = &mut model.params;
    for values in [&mut params.spring_dashpot, &mut params.bend_damping] {
        values.iter_mut().for_each(|value| *value *= damping);
    }
    let mut most = substeps.max(1);
    loop {
        let with_margin = ((f64::from(most) / SOFTENED) as u32).max(1);
        if let Some(reduction) = Reduction::to(&model, with_margin) {
            model.params = reduction.apply(&model).params;
            break;
        }
        if most >= planner.twin.timing.substeps {
            break;
        }
        most = most.saturating_mul(2);
    }
    let mut softened = planner.clone();
    softened.twin.params = model.params;
    softened.twin.timing.substeps = most;
    softened
}

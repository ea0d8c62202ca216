use bendtwin_core::{
    Capture, Environment, Graph, NodeKind, Point, Sequence,
    capture::{HeldPoint, Object},
    settings::{GraphSettings, Sampling, TripletReference},
};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{spread::distance_squared, *};

mod crowds;

fn capture(observed: Vec<Point>, completed: Vec<Point>, interior: Vec<Point>) -> Capture {
    let n = observed.len();
    Capture {
        name: "test".into(),
        fps: 30.0,
        environment: Environment::Z_UP,
        source_to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        object: Object {
            point_count: n,
            completed_surface: completed,
            interior,
            ..Object::default()
        },
        others: Vec::new(),
        sequences: vec![Sequence {
            name: "only".into(),
            frame_count: 1,
            train_frame_count: 1,
            points: observed,
            visible: vec![true; n],
            motion_valid: vec![true; n],
            start_frames: 1,
            ..Sequence::default()
        }],
    }
}

fn cloud(seed: u64, n: usize, size: [f32; 3]) -> Vec<Point> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| size.map(|s| s * rng.random::<f32>())).collect()
}

fn settings(max_nodes: usize) -> GraphSettings {
    // All kinds of nodes, independent of the default.
    GraphSettings { max_nodes: Some(max_nodes), interior: Some(true), ..GraphSettings::default() }
}

fn build(capture: &Capture, settings: &GraphSettings) -> (NodeSample, Graph) {
    let sample = sample_nodes(capture, settings, 7).unwrap();
    let graph = connect(&sample, &Connectivity::from_settings(settings, true));
    (sample, graph)
}

fn pieces(graph: &Graph) -> usize {
    let mut label: Vec<usize> = (0..graph.node_count()).collect();
    for _ in 0..graph.node_count() {
        let before = label.clone();
        for &[a, b] in graph.springs.iter().filter(|s| (s[1] as usize) < graph.node_count()) {
            let low = label[a as usize].min(label[b as usize]);
            label[a as usize] = low;
            label[b as usize] = low;
        }
        if label == before {
            break;
        }
    }
    label.sort_unstable();
    label.dedup();
    label.len()
}

fn assert_sound(sample: &NodeSample, graph: &Graph, max_triplets: usize) {
    graph.check().unwrap();
    let n = graph.node_count();
    let mut pairs: Vec<_> =
        graph.springs.iter().map(|s| [s[0].min(s[1]), s[0].max(s[1])]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    assert_eq!(pairs.len(), graph.springs.len(), "a spring comes twice");
    let mut triplets: Vec<_> =
        graph.triplets.iter().map(|&[i, j, k]| [i.min(k), j, i.max(k)]).collect();
    triplets.sort_unstable();
    triplets.dedup();
    assert_eq!(triplets.len(), graph.triplets.len(), "a triplet comes twice");
    let mut per_centre = vec![0; n];
    for &[i, j, k] in &graph.triplets {
        per_centre[j as usize] += 1;
        assert!([i, j, k].iter().all(|&e| graph.kinds[e as usize].is_surface()));
    }
    assert!(per_centre.iter().all(|&t| t <= max_triplets));
    let (lengths, angles) = rest_geometry(graph, sample);
    assert_eq!((lengths.len(), angles.len()), (graph.springs.len(), graph.triplets.len()));
    assert!(lengths.iter().all(|l| l.is_finite() && *l >= MIN_REST_LENGTH_M));
    assert!(angles.iter().all(|a| (0.0..=std::f32::consts::PI).contains(a)));
}

const REFERENCES: [TripletReference; 4] = [
    TripletReference::Nearest,
    TripletReference::Farthest,
    TripletReference::MostOpposite,
    TripletReference::OppositePairs,
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// Volumes, sheets, lines, coincident clusters and single points, with and without controls.
    #[test]
    fn graphs_of_random_clouds_are_sound(
        seed in 0_u64..1000,
        counts in (1_usize..120, 0_usize..60, 0_usize..60),
        size in prop::array::uniform3(prop_oneof![Just(0.0_f32), 0.0_f32..0.3]),
        copies in 1_usize..4,
        controls in 0_usize..12,
        max_nodes in 1_usize..250,
        reference in 0_usize..4,
    ) {
        let mut observed = cloud(seed, counts.0, size);
        let once = observed.clone();
        (1..copies).for_each(|_| observed.extend(&once));
        let mut capture = capture(observed, cloud(seed + 1, counts.1, size), cloud(seed + 2, counts.2, size));
        capture.sequences[0].controls = cloud(seed + 3, controls, [0.5; 3]);
        let settings = GraphSettings {
            triplet_reference: REFERENCES[reference],
            ..settings(max_nodes)
        };
        let (sample, graph) = build(&capture, &settings);
        prop_assert!(graph.node_count() <= max_nodes);
        assert_sound(&sample, &graph, settings.max_triplets);
        prop_assert!(graph.springs.iter().filter(|s| (s[1] as usize) < graph.node_count()).count()
            <= graph.node_count() * (Connectivity::from_settings(&settings, false).max_neighbours + 6));
        let distinct: std::collections::HashSet<_> =
            sample.positions.iter().map(|p| p.map(f32::to_bits)).collect();
        if size.iter().any(|s| *s > 0.05) && distinct.len() == sample.node_count() {
            prop_assert_eq!(pieces(&graph), 1);
        }
        if controls > 0 {
            prop_assert!(graph.springs.iter().any(|s| s[1] as usize >= graph.node_count()));
        }
        let again = build(&capture, &settings);
        prop_assert_eq!((sample, graph), again);
    }
}

#[test]
fn full_sampling_keeps_every_point_in_kind_order() {
    let capture = capture(cloud(1, 50, [0.1; 3]), cloud(2, 30, [0.1; 3]), cloud(3, 20, [0.1; 3]));
    let sample = sample_nodes(&capture, &settings(1000), 0).unwrap();
    assert_eq!(sample.node_count(), 100);
    assert_eq!(sample.spacing_scale, 1.0);
    assert!(sample.kinds.is_sorted());
    for (i, &p) in sample.observed_points.iter().enumerate() {
        match sample.kinds[i] {
            NodeKind::Observed => {
                assert_eq!(sample.positions[i], capture.sequences[0].points[p as usize]);
            }
            _ => assert_eq!(p, Graph::NOT_OBSERVED),
        }
    }
    let surface = GraphSettings { interior: Some(false), ..settings(1000) };
    assert_eq!(sample_nodes(&capture, &surface, 0).unwrap().node_count(), 80);
}

#[test]
fn downsampling_takes_each_kind_in_proportion() {
    let capture =
        capture(cloud(1, 500, [0.1; 3]), cloud(2, 300, [0.1; 3]), cloud(3, 200, [0.1; 3]));
    let sample = sample_nodes(&capture, &settings(100), 0).unwrap();
    let count = |kind| sample.kinds.iter().filter(|&&k| k == kind).count();
    assert_eq!(count(NodeKind::Observed), 50);
    assert_eq!(count(NodeKind::Completed), 30);
    assert_eq!(count(NodeKind::Interior), 20);
}

/// Farthest-point samples of n of N points in the unit square lie at least
/// half as far apart as a square grid of n points, and leave no hole of twice its pitch.
#[test]
fn samples_are_spread() {
    let points = cloud(5, 4000, [1.0, 1.0, 0.0]);
    let all: Vec<usize> = (0..points.len()).collect();
    let mut chosen = Vec::new();
    farthest_points(&points, &all, &mut chosen, 100, 3);
    assert_eq!(chosen.len(), 100);
    let pitch = 0.1_f32;
    for (i, &a) in chosen.iter().enumerate() {
        for &b in &chosen[..i] {
            assert!(spread::distance_squared(points[a], points[b]).sqrt() > 0.5 * pitch);
        }
    }
    for p in &points {
        let nearest = chosen.iter().map(|&c| spread::distance_squared(*p, points[c]));
        assert!(nearest.fold(f32::INFINITY, f32::min).sqrt() < 2.0 * pitch);
    }
}

/// The spacing grows as r^(-1/d) for clouds of dimension d, within 25 %
/// (the pattern is more regular after sampling, and boundaries count more).
#[test]
fn spacing_scale_follows_the_dimension() {
    for (dimension, size) in [(1, [1.0, 0.0, 0.0]), (2, [1.0, 1.0, 0.0]), (3, [1.0; 3])] {
        let capture = capture(cloud(9, 4000, size), vec![], vec![]);
        for ratio in [0.5, 0.1] {
            let settings = GraphSettings { sampling_ratio: ratio, ..settings(100_000) };
            let sample = sample_nodes(&capture, &settings, 0).unwrap();
            let expected = ratio.powf(-1.0 / f64::from(dimension));
            let off = sample.spacing_scale / expected;
            assert!((0.75..1.35).contains(&off), "{dimension}D at {ratio}: {off}");
        }
    }
}

/// A fixed radius does not grow with the spacing: of nodes drawn at random each point has a
/// neighbour with the same probability, so that a graph of a tenth of them has a tenth of the degree.
#[test]
fn a_fixed_radius_thins_the_graph() {
    let capture = capture(cloud(6, 4000, [0.2; 3]), vec![], vec![]);
    let degree = |ratio: f64, radius_scales: bool| {
        let settings = GraphSettings {
            sampling_ratio: ratio,
            sampling: Sampling::Random,
            radius_m: Some(0.05),
            radius_scales,
            max_neighbours: Some(256),
            ..settings(100_000)
        };
        let (sample, graph) = build(&capture, &settings);
        assert_eq!(radius_scales, sample.spacing_scale > 1.5);
        assert_eq!(sample.node_count(), (4000.0 * ratio) as usize);
        2.0 * graph.springs.len() as f64 / sample.node_count() as f64
    };
    let [half, twentieth] = [0.5, 0.05].map(|ratio| degree(ratio, false));
    assert!((8.0..12.0).contains(&(half / twentieth)), "{half} {twentieth}");
    assert!(degree(0.05, true) > 5.0 * twentieth);
}

/// Random nodes lie closer together than spread ones; the same seed draws the same nodes.
#[test]
fn random_nodes_have_clusters() {
    let mut capture = capture(cloud(7, 2000, [0.2; 3]), cloud(8, 1000, [0.2; 3]), vec![]);
    capture.object.pins = vec![HeldPoint { point: 1999, control: 0 }];
    capture.sequences[0].controls = vec![[0.0; 3]];
    let draw = |sampling, seed| {
        let settings = GraphSettings { sampling, ..settings(300) };
        sample_nodes(&capture, &settings, seed).unwrap()
    };
    let nearest = |sample: &NodeSample| {
        let points = &sample.positions;
        let gap = |i: usize| {
            let others = (0..points.len()).filter(|k| *k != i);
            others.map(|k| distance_squared(points[i], points[k])).fold(f32::INFINITY, f32::min)
        };
        (0..points.len()).map(|i| gap(i).sqrt()).fold(f32::INFINITY, f32::min)
    };
    let (random, even) = (draw(Sampling::Random, 3), draw(Sampling::Spread, 3));
    assert_eq!((random.node_count(), even.node_count()), (300, 300));
    assert!(nearest(&random) < 0.5 * nearest(&even));
    assert_eq!(random, draw(Sampling::Random, 3));
    assert_ne!(random.positions, draw(Sampling::Random, 4).positions);
    for sample in [&random, &even] {
        assert!(sample.observed_points.contains(&1999), "a held point is always a node");
        assert_eq!(sample.kinds.iter().filter(|k| **k == NodeKind::Completed).count(), 100);
    }
}

/// Springs and triplets grow linearly with N at constant density.
#[test]
fn counts_are_linear_in_nodes() {
    let counts = |n: usize| {
        let side = 0.01 * (n as f32).cbrt();
        let (_, graph) = build(&capture(cloud(4, n, [side; 3]), vec![], vec![]), &settings(n));
        [graph.springs.len() as f64 / n as f64, graph.triplets.len() as f64 / n as f64]
    };
    let (small, large) = (counts(1000), counts(8000));
    for i in 0..2 {
        assert!((0.7..1.4).contains(&(large[i] / small[i])), "{small:?} {large:?}");
    }
}

#[test]
fn loose_pieces_are_joined_and_reported() {
    let mut points = cloud(1, 40, [0.03; 3]);
    points.extend(cloud(2, 30, [0.03; 3]).iter().map(|p| [p[0] + 0.2, p[1], p[2]]));
    points.push([0.1, 0.3, 0.0]);
    let sample = sample_nodes(&capture(points, vec![], vec![]), &settings(100), 0).unwrap();
    let (graph, notes) =
        connect_with_notes(&sample, &Connectivity::from_settings(&settings(100), true));
    assert!(notes.pieces_joined >= 2, "{notes}");
    assert_eq!(pieces(&graph), 1);
}

#[test]
fn a_hand_out_of_reach_still_holds() {
    let mut capture = capture(cloud(1, 60, [0.05; 3]), vec![], vec![]);
    // One hand at the object, another one 20 cm away.
    capture.sequences[0].controls =
        vec![[0.0; 3], [0.01, 0.0, 0.0], [0.25, 0.0, 0.0], [0.26, 0.0, 0.0]];
    let settings = settings(100);
    let sample = sample_nodes(&capture, &settings, 0).unwrap();
    let (graph, notes) = connect_with_notes(&sample, &Connectivity::from_settings(&settings, true));
    assert_eq!(notes.hands_out_of_reach, 1);
    assert!(!notes.to_string().is_empty());
    let of = |c: u32| graph.springs.iter().filter(|s| s[1] == 60 + c).count();
    assert!(of(0) > 0 && of(2) == 4);

    let none = GraphSettings { control_neighbours: 0, ..settings };
    let graph = connect(&sample, &Connectivity::from_settings(&none, true));
    assert!(graph.springs.iter().all(|s| s[1] < 60));
}

/// Distant nodes move by themselves; where nodes are sparse, each stands for its surroundings.
#[test]
fn a_hand_holds_what_it_touches() {
    let mut capture = capture(cloud(1, 2000, [0.2; 3]), vec![], vec![]);
    capture.sequences[0].controls = vec![[0.1; 3], [0.1, 0.1, 0.11]];
    let held = |settings: &GraphSettings| {
        let (sample, graph) = build(&capture, settings);
        let n = sample.node_count();
        let controls = graph.springs.iter().filter(|s| s[1] as usize >= n);
        let reach = |s: &[u32; 2]| {
            let control = sample.control_rest[s[1] as usize - n];
            distance_squared(sample.positions[s[0] as usize], control).sqrt()
        };
        let reaches: Vec<f32> = controls.map(reach).collect();
        reaches.into_iter().fold((0, 0.0_f32), |(n, most), r| (n + 1, most.max(r)))
    };
    let radius_m = GraphSettings::default().control_radius_m as f32;
    let (springs, farthest) = held(&settings(2000));
    assert!(springs >= 4 && farthest <= radius_m, "{springs} up to {farthest} m");
    // Where nodes are farther apart it reaches one of them from everywhere.
    let (sample, _) = build(&capture, &settings(200));
    let spacing_m = mean_spacing(&sample.positions) as f32;
    let (springs, farthest) = held(&settings(200));
    assert!(spacing_m > 1.5 * radius_m, "{spacing_m} m apart");
    assert!(springs >= 8 && farthest > radius_m, "{springs} up to {farthest} m");
    assert!(farthest < 1.1 * spacing_m, "{farthest} m where nodes are {spacing_m} m apart");
    // Too few are within its reach to hold the object: then it holds the nearest.
    let (springs, farthest) = held(&settings(40));
    assert!(springs >= 4 && farthest > radius_m, "{springs} up to {farthest} m");
}

fn cable() -> Capture {
    let mut capture = capture((0..6).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect(), vec![], vec![]);
    capture.object.edges = vec![[0, 1], [2, 1], [2, 3], [3, 4], [2, 5], [1, 0]];
    capture.object.pins = vec![HeldPoint { point: 0, control: 0 }];
    capture.object.rest_points = (0..6).map(|i| [0.0, 0.2 * i as f32, 0.0]).collect();
    capture.sequences[0].controls = vec![[0.0, 0.01, 0.0]];
    capture
}

#[test]
fn a_cable_keeps_its_topology_and_rest_shape() {
    // Fewer nodes and a smaller ratio than points: a cable keeps them all the same.
    let settings = GraphSettings { sampling_ratio: 0.5, ..settings(2) };
    let (sample, graph) = build(&cable(), &settings);
    assert_eq!(graph.node_count(), 6);
    assert_eq!(graph.observed_points, [0, 1, 2, 3, 4, 5]);
    assert_eq!(graph.springs, [[0, 1], [1, 2], [2, 3], [2, 5], [3, 4]]);
    let mut triplets = graph.triplets.clone();
    triplets.sort_unstable();
    assert_eq!(triplets, [[0, 1, 2], [1, 2, 3], [1, 2, 5], [2, 3, 4], [3, 2, 5]]);
    assert_eq!(graph.pins.len(), 1);
    assert_eq!(graph.pins[0].offset_m, [0.0, -0.01, 0.0]);
    let (lengths, angles) = rest_geometry(&graph, &sample);
    let expected = [0.2, 0.2, 0.2, 0.6, 0.2];
    assert!(lengths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{lengths:?}");
    let straight = graph.triplets.iter().position(|t| *t == [0, 1, 2]).unwrap();
    assert_eq!(angles[straight], std::f32::consts::PI);
    graph.check().unwrap();
    let axial = connect(&sample, &Connectivity::from_settings(&settings, false));
    assert!(axial.triplets.is_empty());
}

#[test]
fn unusable_points_are_counted_and_left_out() {
    let mut capture = capture(cloud(1, 10, [0.05; 3]), vec![[f32::NAN; 3]], vec![]);
    let sequence = &mut capture.sequences[0];
    sequence.points[2] = [f32::INFINITY, 0.0, 0.0];
    sequence.visible[5] = false;
    let mut later = sequence.clone();
    sequence.visible[6] = false;
    later.visible[2] = false;
    capture.sequences.push(later);
    let sample = sample_nodes(&capture, &settings(100), 0).unwrap();
    assert_eq!(
        sample.left_out,
        LeftOut { not_finite: 2, never_visible: 1, hidden_at_start: 1, coincident: 0 }
    );
    assert_eq!(sample.node_count(), 7);
}

#[test]
fn wrong_captures_are_refused() {
    use bendtwin_core::Problem;
    type Break = (&'static str, fn(&mut Capture));
    let breaks: [Break; 13] = [
        ("CAPTURE_INCONSISTENT", |c| c.sequences.clear()),
        ("CAPTURE_INCONSISTENT", |c| c.sequences[0].start_frames = 9),
        ("CAPTURE_INCONSISTENT", |c| {
            c.sequences[0].points.pop();
        }),
        ("CAPTURE_INCONSISTENT", |c| {
            c.sequences[0].visible.pop();
        }),
        ("CAPTURE_INCONSISTENT", |c| c.sequences[0].frame_count = usize::MAX),
        ("CAPTURE_INCONSISTENT", |c| c.object.edges.push([0, 6])),
        ("CAPTURE_INCONSISTENT", |c| c.object.edges.push([3, 3])),
        ("CAPTURE_INCONSISTENT", |c| c.object.pins.push(HeldPoint { point: 0, control: 0 })),
        ("CAPTURE_INCONSISTENT", |c| c.object.pins.push(HeldPoint { point: 1, control: 1 })),
        ("CAPTURE_INCONSISTENT", |c| {
            c.object.rest_points.pop();
        }),
        ("CAPTURE_POINT_MISSING", |c| c.sequences[0].points[3][1] = f32::NAN),
        ("CAPTURE_CONTROL_MISSING", |c| c.sequences[0].controls[0][1] = f32::NAN),
        ("CAPTURE_HAS_NO_POINTS", |c| {
            c.object = Object { point_count: 6, ..Object::default() };
            c.sequences[0].visible.fill(false);
        }),
    ];
    for (i, (reason, break_it)) in breaks.into_iter().enumerate() {
        let mut capture = cable();
        break_it(&mut capture);
        let error = sample_nodes(&capture, &settings(100), 0).unwrap_err();
        assert_eq!(error.reason(), reason, "case {i}: {error}");
    }
}

/// A cable of nodes 10 cm apart along x, with branches: (first point of the trunk, points above
/// it).
fn branched(trunk: usize, branches: &[(usize, usize)], pins: &[u32]) -> NodeSample {
    let mut positions: Vec<Point> = (0..trunk).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect();
    let mut edges: Vec<[u32; 2]> = (1..trunk as u32).map(|i| [i - 1, i]).collect();
    for &(from, count) in branches {
        for k in 0..count {
            let last = if k == 0 { from } else { positions.len() - 1 };
            edges.push([last as u32, positions.len() as u32]);
            positions.push([0.1 * from as f32, 0.0, 0.1 * (k + 1) as f32]);
        }
    }
    let n = positions.len();
    NodeSample {
        kinds: vec![NodeKind::Observed; n],
        observed_points: (0..n as u32).collect(),
        object_ids: vec![0; n],
        control_rest: vec![[0.0; 3]],
        pins: pins.iter().map(|&node| Pin { node, control: 0, offset_m: [0.0; 3] }).collect(),
        edges: Some(edges),
        rest_shape: None,
        point_spacing_m: 0.0,
        spacing_scale: 1.0,
        surface: Default::default(),
        left_out: LeftOut::default(),
        positions,
    }
}

#[test]
fn rods_end_where_the_first_branch_holds_the_frame() {
    // As DEFT's first cable: clamps at both ends, branches at 4 and 8.
    let cable = branched(13, &[(4, 4), (8, 3)], &[0, 1, 11, 12]);
    assert_eq!(rods::find(&cable), vec![vec![0, 1, 2, 3, 4, 13], vec![12, 11, 10, 9, 8, 17]]);
    // A branch with a clamp at its end holds nothing by itself: three rods between three clamps.
    let clamped = branched(7, &[(3, 3)], &[0, 1, 5, 6, 8, 9]);
    assert_eq!(rods::find(&clamped).len(), 3);
    // One clamp, and a fork: the arm is the branch that stands off the more.
    let fork = branched(6, &[(3, 2)], &[0, 1]);
    assert_eq!(rods::find(&fork), vec![vec![0, 1, 2, 3, 6]]);
    let chain = branched(6, &[], &[0, 1, 4, 5]);
    assert_eq!(rods::find(&chain), vec![vec![0, 1, 2, 3, 4, 5]]);
}

#[test]
fn nodes_of_a_cable_weigh_what_they_stand_for() {
    let mut cable = branched(4, &[(1, 1)], &[]);
    cable.positions[3][0] += 0.1;
    let graph = connect(&cable, &Connectivity::from_settings(&GraphSettings::default(), true));
    let total: f32 = graph.masses.iter().sum();
    assert!((total - 5.0).abs() < 1e-5, "one a node on average");
    for (mass, halves) in graph.masses.iter().zip([1.0, 3.0, 3.0, 2.0, 1.0]) {
        assert!((mass - halves / 2.0).abs() < 1e-5, "{:?}", graph.masses);
    }
}

/// A cloth of points 27 mm apart.
fn sparse_cloth() -> Capture {
    let points = (0..144).map(|i| [0.027 * (i % 12) as f32, 0.027 * (i / 12) as f32, 0.1]);
    capture(points.collect(), vec![], vec![])
}

#[test]
fn the_radius_that_is_left_open_suits_points_however_sparse() {
    for max_nodes in [144, 60] {
        let mut settings = settings(max_nodes);
        let sample = sample_nodes(&sparse_cloth(), &settings, 7).unwrap();
        let joined = |settings: &GraphSettings| {
            connect_with_notes(&sample, &Connectivity::from_settings(settings, true))
                .1
                .pieces_joined
        };
        settings.radius_m = Some(0.02);
        assert!(max_nodes < 144 || joined(&settings) == 143, "{}", joined(&settings));
        settings.radius_m = None;
        settings.radius_m = Some(sample.radius_m(&settings));
        assert_eq!(joined(&settings), 0, "{:?}", settings.radius_m);
    }
}

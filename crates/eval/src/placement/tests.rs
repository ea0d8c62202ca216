use bendtwin_core::{Contact, capture::Object};
use bendtwin_core_kit::twin_of;
use bendtwin_engine::cpu_with_threads;
use bendtwin_graph::bind_skin;

use super::*;
use crate::{EvaluateOptions, evaluate};

const STEP_M: f32 = 0.02;

/// Points of an L, `step` apart.
fn shape(step: f32) -> Vec<Point> {
    let count = |length: f32| (length / step).round() as usize;
    let mut points = Vec::new();
    for x in 0..=count(0.24) {
        for y in 0..=count(0.12) {
            for z in 0..=count(0.02) {
                let p = [x, y, z].map(|i| i as f32 * step);
                if p[1] < 0.05 || p[0] < 0.05 {
                    points.push(p);
                }
            }
        }
    }
    points
}

/// Turned about the vertical and moved.
fn turned([x, y, z]: Point) -> Point {
    let (s, c) = 2.4_f32.sin_cos();
    [c * x - s * y - 0.3, s * x + c * y + 0.5, z + 0.2]
}

/// A twin of the L that two control points hold.
fn twin() -> Twin {
    let nodes = shape(STEP_M);
    let n = nodes.len();
    let controls = vec![[0.24, 0.02, 0.03], [0.22, 0.02, 0.03]];
    let all: Vec<Point> = nodes.iter().chain(&controls).copied().collect();
    let mut springs = Vec::new();
    for a in 0..n {
        for b in a + 1..all.len() {
            if point_distance(all[a], all[b]) < 1.8 * f64::from(STEP_M) {
                springs.push([a as u32, b as u32]);
            }
        }
    }
    let rest = |s: &[u32; 2]| point_distance(all[s[0] as usize], all[s[1] as usize]) as f32;
    let is_held = |s: &[u32; 2]| s[1] as usize >= n;
    let params = Params {
        rest_lengths_m: springs.iter().map(rest).collect(),
        spring_stiffness: springs.iter().map(|s| if is_held(s) { 700.0 } else { 900.0 }).collect(),
        spring_dashpot: springs.iter().map(|s| if is_held(s) { 7.0 } else { 9.0 }).collect(),
        bend_stiffness: vec![0.1, 0.2],
        bend_damping: vec![0.01, 0.02],
        rest_angles_rad: vec![3.0, 2.0],
        contact: Contact::default(),
        ..Params::default()
    };
    let graph = Graph {
        kinds: vec![bendtwin_core::NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        rest_positions: nodes.clone(),
        control_rest: controls,
        springs,
        // The second has an arm to a control point.
        triplets: vec![[0, 1, 2], [3, 4, n as u32]],
        ..Graph::default()
    };
    let surface = SurfacePoints { observed_points: (0..n as u32).collect(), positions: nodes };
    Twin {
        skin: bind_skin(&graph, &surface),
        environment: Environment { gravity: [0.0; 3], ground: None },
        timing: Timing { fps: 30.0, substeps: 100 },
        control_hands: vec![0, 0],
        ..twin_of(graph, params)
    }
}

/// The L elsewhere, with its own points and control points, all of which move along.
fn other(fps: f64) -> Capture {
    let points: Vec<Point> = shape(0.015).into_iter().map(turned).collect();
    let hand = [[0.01, 0.12, 0.03], [0.03, 0.12, 0.03], [0.02, 0.1, 0.03]].map(turned);
    let frames = 12;
    let along = |p: &Point, f: usize| [p[0], p[1], p[2] + 0.002 * f as f32];
    let rows = |of: &[Point]| -> Vec<Point> {
        (0..frames).flat_map(|f| of.iter().map(move |p| along(p, f))).collect()
    };
    let all = points.len() * frames;
    Capture {
        name: "elsewhere".into(),
        fps,
        environment: Environment { gravity: [0.0; 3], ground: None },
        source_to_world: bendtwin_core::geometry::IDENTITY,
        object: Object { point_count: points.len(), ..Object::default() },
        sequences: vec![Sequence {
            name: "main".into(),
            frame_count: frames,
            train_frame_count: 6,
            points: rows(&points),
            visible: vec![true; all],
            motion_valid: vec![true; all],
            controls: rows(&hand),
            truth_tracks: rows(&points[..9]),
            start_frames: 1,
        }],
        others: Vec::new(),
    }
}

#[test]
fn a_twin_is_scored_on_another_recording_of_its_object() {
    let (twin, capture) = (twin(), other(30.0));
    assert!(!is_own_capture(&twin, &capture));
    let options = EvaluateOptions::default();
    let cancel = CancelToken::default();
    let quality = evaluate(&*cpu_with_threads(1), &twin, &capture, &options, &cancel).unwrap();
    let [recording] = quality.recordings.as_slice() else { panic!("{:?}", quality.recordings) };
    let registered = recording.registered.unwrap();
    assert!(registered.median_mm < 3.0 && registered.explained > 0.95, "{registered:?}");
    let own = &quality.scores[0];
    assert_eq!(own.future, recording.future);
    // It was fitted to no frame of it.
    assert_eq!(own.train, Default::default());
    let still = quality.score(bendtwin_core::quality::Predictor::StandingStill).unwrap();
    let (own_m, still_m) = (own.future.track_m.unwrap(), still.future.track_m.unwrap());
    // The hand moves it; what remains is that it is pulled and not held.
    assert!(own_m < 0.6 * still_m, "{own_m} {still_m}");
    assert_eq!(quality.warnings, Vec::<String>::new());
}

#[test]
fn a_twin_elsewhere_keeps_what_is_between_its_nodes() {
    let (twin, capture) = (twin(), other(60.0));
    let sequence = &capture.sequences[0];
    let cancel = CancelToken::default();
    let placed = Placement::new(&twin.graph, &twin.skin, &capture, sequence, &cancel).unwrap();
    let there = placed.twin(&twin, &capture, sequence).unwrap();
    assert_eq!(there.graph.check(), Ok(()));
    assert_eq!(there.params.check(&there.graph), Ok(()));
    let n = twin.graph.node_count();
    let inner = |g: &Graph| g.springs.iter().filter(|s| (s[1] as usize) < n).count();
    assert_eq!(inner(&there.graph), inner(&twin.graph));
    // Only triplets of nodes are left, with their own numbers.
    assert_eq!(there.graph.triplets, [[0, 1, 2]]);
    assert_eq!(there.params.bend_stiffness, [0.1]);
    let held = there.graph.springs.len() - inner(&there.graph);
    assert!(held >= 4, "{held} springs hold it");
    // The hand holds equally firmly in all, with any number of springs.
    assert_ne!(held, twin.graph.springs.len() - inner(&twin.graph));
    let sum = |twin: &Twin, of: fn(&Params) -> &[f32]| {
        let pairs = twin.graph.springs.iter().zip(of(&twin.params));
        pairs.filter(|(s, _)| s[1] as usize >= n).map(|(_, x)| x).sum::<f32>()
    };
    let fields: [fn(&Params) -> &[f32]; 2] = [|p| &p.spring_stiffness, |p| &p.spring_dashpot];
    for of in fields {
        let (here, elsewhere) = (sum(&twin, of), sum(&there, of));
        assert!((here - elsewhere).abs() < 1e-3 * here, "{here} {elsewhere}");
    }
    // Twice the frames a second, half the substeps, or as many as are stable.
    assert_eq!(there.timing.fps, 60.0);
    assert!((50..100).contains(&there.timing.substeps), "{:?}", there.timing);
    assert!(is_own_capture(&there, &capture));
    assert_eq!(there.skin.len(), twin.skin.len() + capture.object.point_count);
}

#[test]
fn each_of_two_hands_holds_as_firmly_as_those_of_the_twin() {
    let twin = twin();
    let grip = Grip::of(&twin.graph, &twin.params);
    // Two hands far from each other, with three springs and one.
    let controls = [[0.0; 3], [0.01, 0.0, 0.0], [0.5, 0.0, 0.0], [0.9, 0.0, 0.0]];
    let springs = [[0, 10], [1, 10], [1, 11], [4, 12]];
    let shares = grip.by_springs(10, &controls, &springs);
    let stiffness: Vec<f32> = shares.iter().map(|g| g.stiffness / grip.stiffness).collect();
    assert!(stiffness.iter().zip([1.0, 1.0, 1.0, 3.0]).all(|(a, b)| (3.0 * a - b).abs() < 1e-5));
    // A twin that nothing holds is held by a spring like its own.
    let n = twin.graph.node_count();
    let is_inner: Vec<bool> = twin.graph.springs.iter().map(|s| (s[1] as usize) < n).collect();
    let kept = |values: &[f32]| -> Vec<f32> {
        values.iter().zip(&is_inner).filter(|(_, inner)| **inner).map(|(x, _)| *x).collect()
    };
    let Twin { graph: mut free, mut params, .. } = twin;
    free.springs.retain(|s| (s[1] as usize) < n);
    params.spring_stiffness = kept(&params.spring_stiffness);
    params.spring_dashpot = kept(&params.spring_dashpot);
    let expected = Grip { stiffness: 900.0, dashpot: 9.0 };
    assert_eq!(Grip::of(&free, &params), expected);
}

#[test]
fn velocities_come_from_the_frame_before() {
    let mut capture = other(30.0);
    capture.sequences[0].start_frames = 2;
    let twin = twin();
    let sequence = &capture.sequences[0];
    let cancel = CancelToken::default();
    let placed = Placement::new(&twin.graph, &twin.skin, &capture, sequence, &cancel).unwrap();
    assert!(placed.velocities.iter().all(|v| (v[2] - 0.06).abs() < 1e-3 && v[0].abs() < 1e-3));
}

#[test]
fn another_object_is_not_scored() {
    let (twin, mut capture) = (twin(), other(30.0));
    // A wire, ten times as long.
    for (i, p) in capture.sequences[0].points.iter_mut().enumerate() {
        *p = [0.01 * (i % capture.object.point_count) as f32, 0.0, 0.0];
    }
    let refused = |capture: &Capture| {
        let options = EvaluateOptions::default();
        let cancel = CancelToken::default();
        evaluate(&*cpu_with_threads(1), &twin, capture, &options, &cancel)
    };
    assert!(matches!(refused(&capture), Err(Error::Register(_))));
    // Beside one that can be scored it is a warning.
    let mut both = other(30.0);
    both.others = vec![capture];
    let quality = refused(&both).unwrap();
    assert_eq!(quality.recordings.len(), 1);
    assert!(quality.warnings[0].contains("is not scored"), "{:?}", quality.warnings);
}

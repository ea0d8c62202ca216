use bendtwin_capture::phystwin::results::ContactResult;
use bendtwin_core::{Problem as _, Sequence, capture::Object};

use super::*;

const RADIUS_M: f64 = 0.021;

fn search() -> SearchResult {
    SearchResult {
        stiffness: 3000.0,
        object_radius_m: RADIUS_M,
        object_max_neighbours: 6,
        control_radius_m: 0.03,
        control_max_neighbours: 4,
        contact: ContactResult { ground: [0.4, 0.3], object: [0.7, 0.2] },
        collision_distance_m: 0.03,
        drag: 2.75,
        dashpot: 87.5,
    }
}

/// Points of a golden-ratio sequence in a box, none equally far from others.
fn points(count: usize, from: usize) -> Vec<Point> {
    let along = |i: usize, step: f64| (0.06 * (i as f64 * step).fract()) as f32;
    let of = |i: usize| [along(i, 0.819_172_5), along(i, 0.671_043_6), along(i, 0.549_700_5) + 0.1];
    (from..from + count).map(of).collect()
}

fn capture() -> Capture {
    Capture {
        name: "case".to_owned(),
        fps: 30.0,
        environment: Environment::Z_UP,
        source_to_world: bendtwin_core::geometry::IDENTITY,
        object: Object {
            point_count: 30,
            completed_surface: points(12, 40),
            interior: points(9, 60),
            ..Object::default()
        },
        sequences: vec![Sequence {
            frame_count: 1,
            points: points(30, 1),
            controls: vec![[0.03, 0.03, 0.17], [0.0, 0.0, 5.0]],
            start_frames: 1,
            ..Sequence::default()
        }],
        others: Vec::new(),
    }
}

/// All pairs compared, in plain loops.
fn expected(points: &[Point], controls: &[Point]) -> Vec<[u32; 2]> {
    let near = |at: Point, radius: f64, most: usize| {
        let distance = |q: &Point| {
            (0..3).map(|a| (f64::from(at[a]) - f64::from(q[a])).powi(2)).sum::<f64>().sqrt()
        };
        let mut all: Vec<(f64, u32)> =
            points.iter().enumerate().map(|(j, q)| (distance(q), j as u32)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.truncate(most);
        all.retain(|(d, _)| *d < radius);
        all
    };
    let mut springs: Vec<[u32; 2]> = Vec::new();
    for (i, p) in points.iter().enumerate() {
        for (d, j) in near(*p, RADIUS_M, 6).into_iter().skip(1) {
            let i = i as u32;
            if d > 1e-4 && !springs.contains(&[i, j]) && !springs.contains(&[j, i]) {
                springs.push([i, j]);
            }
        }
    }
    for (c, p) in controls.iter().enumerate() {
        springs.extend(near(*p, 0.03, 4).iter().map(|(_, j)| [*j, (points.len() + c) as u32]));
    }
    springs
}

#[test]
fn springs_are_those_of_plain_loops_in_their_order() {
    let twin = of_phystwin(&capture(), &search(), None).unwrap();
    let graph = &twin.graph;
    assert_eq!((graph.node_count(), graph.surface_count()), (51, 42));
    let springs = expected(&graph.rest_positions, &graph.control_rest);
    assert!(springs.len() > 100 && springs[springs.len() - 1][1] == 51);
    assert_eq!(graph.springs, springs);
    for (ends, rest) in springs.iter().zip(&twin.params.rest_lengths_m) {
        let [a, b] = ends.map(|e| wide_of(graph.rest_endpoint(e)));
        let length = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        assert_eq!(*rest, length as f32);
    }
}

fn wide_of(p: Point) -> [f64; 3] {
    p.map(f64::from)
}

#[test]
fn the_model_is_phystwins() {
    let twin = of_phystwin(&capture(), &search(), None).unwrap();
    assert_eq!(twin.timing.substeps, 667);
    assert!((twin.timing.dt_s() - 5e-5).abs() < 1e-15);
    assert_eq!(twin.environment.gravity, [0.0, 0.0, -9.8]);
    assert_eq!(twin.control_velocity, ControlVelocity::Ignored);
    assert!(twin.params.spring_stiffness.iter().all(|k| *k == 3000.0));
    // Results of the search are taken over unchanged.
    assert_eq!((twin.params.drag, twin.params.spring_dashpot[0]), (2.75, 87.5));
    assert_eq!(Twin::decode(&twin.encode().unwrap()).unwrap(), twin);
}

#[test]
fn training_replaces_springs_and_contact() {
    let plain = of_phystwin(&capture(), &search(), None).unwrap();
    let count = plain.graph.springs.len();
    let stiffness: Vec<f32> = (0..count).map(|s| 1000.0 * s as f32).collect();
    let contact = ContactResult { ground: [1.5, -0.2], object: [0.5, 2.5] };
    let of = |stiffness: Vec<f32>, object_spring_count| {
        let train = TrainResult { stiffness, object_spring_count, contact };
        of_phystwin(&capture(), &search(), Some(&train))
    };
    let twin = of(stiffness.clone(), Some(count - 4)).unwrap();
    assert_eq!(twin.params.spring_stiffness[..3], [0.0, 1000.0, 2000.0]);
    assert_eq!(
        twin.params.spring_stiffness[count - 1],
        MAX_SPRING_STIFFNESS.min(stiffness[count - 1])
    );
    let c = twin.params.contact;
    let found = [c.ground_restitution, c.ground_friction, c.object_restitution, c.object_friction];
    assert_eq!(found, [1.0, 0.0, 0.5, 2.0]);
    // Cut to integers, as its configuration does.
    assert_eq!((twin.params.drag, twin.params.spring_dashpot[0]), (2.0, 87.0));
    for (stiffness, objects) in [(stiffness[1..].to_vec(), None), (stiffness, Some(count - 3))] {
        let error = of(stiffness, objects).unwrap_err();
        assert_eq!(error.reason(), "IMPORT_OTHER_SPRINGS", "{error}");
    }
}

#[test]
fn points_that_coincide_or_lack_a_position_do_no_harm() {
    let mut capture = capture();
    capture.object.interior = vec![[0.01, 0.01, 0.11]; 40];
    let twin = of_phystwin(&capture, &search(), None).unwrap();
    let n = twin.graph.node_count() as u32;
    assert!(
        twin.graph
            .springs
            .iter()
            .zip(&twin.params.rest_lengths_m)
            .all(|(s, l)| s[1] >= n || *l > 1e-4)
    );
    capture.object.interior[3][1] = f32::NAN;
    let error = of_phystwin(&capture, &search(), None).unwrap_err();
    assert!(matches!(error, Error::PointMissing { point: 45 }), "{error}");
    capture.object.interior.clear();
    let two = Capture { others: vec![capture.clone()], ..capture.clone() };
    assert_eq!(of_phystwin(&two, &search(), None).unwrap_err().reason(), "IMPORT_SEVERAL_CASES");
    let nothing = Capture { sequences: Vec::new(), object: Object::default(), ..capture };
    assert_eq!(of_phystwin(&nothing, &search(), None).unwrap().graph.node_count(), 0);
}

//! Corrections beside obstacles.

use bendtwin_core::Plane;

use super::*;
use crate::{Obstacle, scene::cuboid, scene::peg};

/// A bar of 7 by 3 by 2 nodes, 24 by 8 by 4 cm, that flies at 0.3 m/s.
fn flying(z: f32) -> (Model, State) {
    let model = scene::coarse();
    let mut state = State::rest(&model.graph);
    state.positions.iter_mut().for_each(|p| p[2] += z);
    state.velocities = vec![[0.1, 0.0, -0.3]; state.positions.len()];
    (model, state)
}

/// The correction by the nodes where these points are, with noise.
fn to(
    model: &Model,
    state: &State,
    obstacles: Vec<Obstacle>,
    points: &[Point],
    cloud: bool,
) -> Corrected {
    let nodes: Vec<u32> = (0..points.len() as u32).collect();
    let tracks = (!cloud).then(|| Skin::at_nodes(&nodes));
    let points = match cloud {
        true => scene::noisy(&model.skin.positions(points), 0.003, 3),
        false => scene::noisy(points, 0.003, 3),
    };
    let observation = Observation { points, tracks, ..Observation::default() };
    let around = Around { obstacles, ..Around::default() };
    let options = CorrectOptions { max_residual_m: Some(1.0), ..CorrectOptions::default() };
    let cancel = CancelToken::default();
    correct(model, state, &[], &around, &observation, &options, &cancel).unwrap()
}

fn moved(state: &State, by: Point) -> Vec<Point> {
    state.positions.iter().map(|p| std::array::from_fn(|i| p[i] + by[i])).collect()
}

/// Largest strain of the springs.
fn strain(model: &Model, x: &[Point]) -> f64 {
    let springs = model.graph.springs.iter().map(|s| s.map(|e| e as usize));
    let strains = springs.map(|[a, b]| {
        let rest = point_distance(model.graph.rest_positions[a], model.graph.rest_positions[b]);
        (point_distance(x[a], x[b]) / rest - 1.0).abs()
    });
    strains.fold(0.0, f64::max)
}

#[test]
fn nodes_stay_above_the_ground_and_do_not_move_into_it() {
    let (mut model, state) = flying(0.002);
    model.environment.ground = Some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 });
    for cloud in [false, true] {
        let low = moved(&state, [0.0, 0.0, -0.008]);
        let corrected = to(&model, &state, Vec::new(), &low, cloud).state;
        let least = corrected.positions.iter().map(|p| p[2]).fold(f32::MAX, f32::min);
        assert!((0.0..1e-4).contains(&least), "{least}");
        for (x, v) in corrected.positions.iter().zip(&corrected.velocities) {
            // What touches the ground does not fall; all other nodes continue.
            let falls = if x[2] < 1.9e-5 { 0.0 } else { -0.3 };
            assert!((v[2] - falls).abs() < 1e-6 && v[0] == 0.1, "{x:?} {v:?}");
        }
        assert!(strain(&model, &corrected.positions) < 0.1);
    }
}

#[test]
fn what_is_in_a_box_leaves_it_on_its_own_side() {
    let (model, mut state) = flying(0.1);
    // The end of the bar is 4 mm inside of the box.
    let wall = cuboid([0.236, -0.2, 0.0], [0.4, 0.2, 0.3]);
    state.velocities = vec![[0.5, 0.0, 0.0]; state.positions.len()];
    let there = moved(&state, [0.003, 0.0, 0.0]);
    for cloud in [false, true] {
        let corrected = to(&model, &state, vec![wall.clone()], &there, cloud).state;
        let rest = &model.graph.rest_positions;
        for ((x, v), rest) in corrected.positions.iter().zip(&corrected.velocities).zip(rest) {
            assert!(x[0] <= 0.236, "{x:?}");
            if rest[0] > 0.23 {
                assert!(x[0] > 0.2359 && v[0].abs() < 1e-6, "{x:?} {v:?}");
            } else if rest[0] < 0.1 {
                assert_eq!(*v, [0.5, 0.0, 0.0]);
            }
        }
        assert!(strain(&model, &corrected.positions) < 0.15);
    }
}

/// The bar hangs beside a thin card, or lies beside a wire; what is seen is on its other side.
#[test]
fn no_cloud_pulls_a_node_through_something_thin() {
    let (model, state) = flying(0.0);
    let card = cuboid([0.1, -0.003, -0.1], [0.14, -0.001, 0.1]);
    let wire = peg([0.12, -0.003, -0.1], [0.12, -0.003, 0.1], 0.002);
    for obstacle in [card, wire] {
        for cloud in [false, true] {
            // Nodes at y = 0 in front of it would be 4 mm behind it.
            let there = moved(&state, [0.0, -0.007, 0.0]);
            let corrected = to(&model, &state, vec![obstacle.clone()], &there, cloud).state;
            let mut beside = 0;
            for (x, rest) in corrected.positions.iter().zip(&model.graph.rest_positions) {
                if rest[1] == 0.0 && (rest[0] - 0.12).abs() < 0.01 {
                    assert!(x[1] > -0.0011, "{x:?}");
                    beside += 1;
                } else if rest[0] < 0.05 && rest[1] == 0.0 && !cloud {
                    // What nothing is in the way of follows.
                    assert!(x[1] < -0.001, "{x:?}");
                }
            }
            assert_eq!(beside, 2);
            assert!(strain(&model, &corrected.positions) < 0.2);
        }
    }
}

#[test]
fn what_is_held_stays_in_an_obstacle_and_an_open_hand_holds_nothing() {
    let backend = bendtwin_engine::cpu();
    let (truth, state, controls) = astray(&*backend);
    let model = scene::model();
    let nodes: Vec<u32> = (0..truth.positions.len() as u32).collect();
    let observation = observe(&truth, &nodes, 0.0);
    let all = cuboid([-2.0; 3], [2.0, 2.0, 2.0]);
    let mut held = state.clone();
    let hold = bendtwin_engine::world::Hold { node: 7, grasp: 0, place: [0.0; 3] };
    held.grasping.holds.push(hold);
    let run = |around: &Around, observation: &Observation| {
        let options = CorrectOptions { max_residual_m: Some(1e3), ..OPTIONS };
        let cancel = CancelToken::default();
        correct(&model, &held, &controls, around, observation, &options, &cancel).unwrap()
    };
    let around = Around { obstacles: vec![all], ..Around::default() };
    let corrected = run(&around, &observation).state;
    assert_eq!(corrected.positions[7], state.positions[7]);
    assert!(corrected.positions[8].iter().any(|x| x.abs() >= 2.0));

    // Carried off as a whole, with nothing that holds it back.
    let mut observation = observation;
    observation.points.iter_mut().for_each(|p| p[1] += 0.05);
    held.grasping.holds.clear();
    let off = |loose: Vec<u32>| {
        let around = Around { loose, ..Around::default() };
        let options = CorrectOptions { max_residual_m: Some(1e3), ..OPTIONS };
        let cancel = CancelToken::default();
        correct(&model, &held, &controls, &around, &observation, &options, &cancel).unwrap()
    };
    let (open, closed) = (off(vec![0, 1]), off(Vec::new()));
    assert!(open.after.p95_mm < 0.5 * closed.after.p95_mm, "{open:?} {closed:?}");
}

#[test]
fn a_correction_says_how_well_it_explains() {
    let (model, state) = flying(0.0);
    let corrected = to(&model, &state, Vec::new(), &moved(&state, [0.0, 0.002, 0.0]), true);
    assert!(corrected.misfit > 0.02 && corrected.misfit < 0.6, "{corrected:?}");
    // Behind a wall.
    let wall = cuboid([-1.0, 0.0805, -1.0], [1.0, 0.09, 1.0]);
    let behind = to(&model, &state, vec![wall], &moved(&state, [0.0, 0.2, 0.0]), true);
    assert!(behind.misfit > 1.0, "{behind:?}");
}

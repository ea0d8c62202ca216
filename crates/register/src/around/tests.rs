use std::sync::Arc;

use bendtwin_engine::world::{Attachment, Grasp, Grasping};

use super::*;

/// A quarter turn about z, at (1, 0, 0).
const TURNED: Pose = [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn world() -> World {
    let collider =
        |body, shape| Collider { body: Some(body), shape, friction: 0.5, restitution: 0.0 };
    let ball = Shape::Capsule { from: [1.0, 0.0, 0.0], to: [1.0, 0.0, 0.5], radius_m: 0.1 };
    let face = Face { normal: [1.0, 0.0, 0.0], offset_m: 0.25 };
    let wall = Shape::Convex(Arc::new(vec![face]));
    World { bodies: 2, colliders: vec![collider(1, ball), collider(0, wall)], ..World::default() }
}

#[test]
fn colliders_are_where_their_bodies_are_and_unknown_bodies_carry_nothing() {
    let at = PlacedBody { pose: TURNED, rate: Pose::default() };
    let around = Around::new(&world(), &[Some(at), None], &State::default());
    assert_eq!(around.obstacles.len(), 1);
    let Shape::Convex(faces) = &around.obstacles[0].collider.shape else { panic!("a wall") };
    assert_eq!((faces[0].normal, faces[0].offset_m), ([0.0, 1.0, 0.0], 0.25));
    let around = Around::new(&world(), &[None, Some(at)], &State::default());
    let Shape::Capsule { from, to, .. } = around.obstacles[0].collider.shape else {
        panic!("a capsule")
    };
    assert_eq!((from, to), ([1.0, 1.0, 0.0], [1.0, 1.0, 0.5]));
}

#[test]
fn points_of_a_moving_body_have_its_velocity() {
    // It turns by 2 rad/s about its own z, and drifts by (0, 0, 3) m/s.
    let mut rate: Pose = [[0.0; 4]; 3];
    for row in 0..3 {
        for column in 0..3 {
            let spin = [[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0; 3]];
            rate[row][column] = (0..3).map(|k| spin[row][k] * TURNED[k][column]).sum();
        }
    }
    rate[2][3] = 3.0;
    let at = PlacedBody { pose: TURNED, rate };
    let around = Around::new(&world(), &[Some(at), Some(at)], &State::default());
    let velocity = around.obstacles[0].velocity([1.5, 0.0, 0.0]);
    for (is, should) in velocity.iter().zip([0.0, 1.0, 3.0]) {
        assert!((is - should).abs() < 1e-6, "{velocity:?}");
    }
}

#[test]
fn control_points_of_an_open_hand_are_loose() {
    let grasp = |region| Grasp { body: 0, region, attachment: Attachment::Pin, max_force: 1.0 };
    let grasps = vec![
        grasp(Region::Controls(Arc::new(vec![0, 2]))),
        grasp(Region::Nodes(Arc::new(vec![5]))),
        grasp(Region::Controls(Arc::new(vec![1]))),
    ];
    let world = World { grasps, ..World::default() };
    let loose = |phases: Vec<Phase>| {
        let grasping = Grasping { phases, holds: Vec::new() };
        Around::new(&world, &[], &State { grasping, ..State::default() }).loose
    };
    assert_eq!(loose(vec![Phase::Open, Phase::Open, Phase::Closed]), [0, 2]);
    // A hold that has never been opened.
    assert!(loose(Vec::new()).is_empty());
}

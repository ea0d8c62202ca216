use nalgebra::Vector3;

use super::*;
use crate::scene::{cuboid, peg};

fn barrier(ground: bool, obstacles: Vec<crate::Obstacle>) -> Barrier {
    let ground = ground.then_some(Plane { normal: [0.0, 0.0, 1.0], offset_m: 0.0 });
    Barrier::new(ground, &Around { obstacles, ..Around::default() }, vec![false])
}

fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

#[test]
fn what_is_inside_leaves_along_the_normal_and_never_into_something_else() {
    let left = |barrier: &Barrier, x| {
        let mut at = [x];
        barrier.leave(&mut at);
        assert!(barrier.is_free(at[0]), "{at:?}");
        at[0]
    };
    let card = barrier(true, vec![cuboid([-0.1, -0.1, 0.0], [0.1, 0.1, 0.02])]);
    // The bottom is nearer, and in the ground.
    assert!((left(&card, v(0.0, 0.0, 0.001)) - v(0.0, 0.0, 0.02)).norm() < 1e-4);
    assert!((left(&card, v(0.0, 0.0, -0.3)) - v(0.0, 0.0, 0.02)).norm() < 1e-4);
    assert!((left(&card, v(0.099, 0.0, 0.01)) - v(0.1, 0.0, 0.01)).norm() < 1e-4);
    let post = barrier(true, vec![peg([0.0; 3], [0.0, 0.0, 0.1], 0.02)]);
    assert!((left(&post, v(0.01, 0.0, 0.05)) - v(0.02, 0.0, 0.05)).norm() < 1e-4);
    left(&post, v(0.0, 0.0, 0.05));
    // Two boxes beside each other: the side of one is in the other.
    let both = vec![
        cuboid([-0.1, -0.1, 0.0], [0.0, 0.1, 0.1]),
        cuboid([-0.005, -0.1, 0.0], [0.1, 0.1, 0.1]),
    ];
    assert!((left(&barrier(true, both), v(-0.001, 0.0, 0.05)).z - 0.1).abs() < 1e-4);
    // What is outside stays to the bit.
    let out = v(0.1, 0.2, 0.3);
    assert_eq!(left(&card, out), out);
}

#[test]
fn no_step_goes_through_an_obstacle_however_thin() {
    let card = cuboid([-0.1, -0.0005, 0.0], [0.1, 0.0005, 0.2]);
    let wire = peg([0.0, 0.0, 0.0], [0.0, 0.0, 0.2], 0.0005);
    for obstacle in [card, wire] {
        let barrier = barrier(true, vec![obstacle]);
        let kept = |from: Vector3<f64>, to| {
            let mut to = [to];
            barrier.leave(&mut [from]).unwrap().keep(&mut to);
            to
        };
        let to = kept(v(0.0, -0.01, 0.1), v(0.0005, 0.02, 0.1));
        assert!(to[0].y < -0.0005 && to[0].y > -0.00052, "{to:?}");
        assert!((to[0].x - 0.0005).abs() < 1e-3, "{to:?}");
        // Around the end of it is no way through.
        let around = v(0.2, 0.02, 0.1);
        assert_eq!(kept(v(0.2, -0.01, 0.1), around), [around]);
    }
}

#[test]
fn in_a_corner_a_step_ends_on_both_sides() {
    let barrier = barrier(true, vec![cuboid([0.0, -1.0, -1.0], [1.0, 1.0, 1.0])]);
    let mut outside = barrier.leave(&mut [v(-0.01, 0.0, 0.01)]).unwrap();
    let mut to = [v(0.02, 0.3, -0.02)];
    outside.keep(&mut to);
    assert!((to[0] - v(-CLEARANCE_M, 0.3, CLEARANCE_M)).norm() < 1e-9, "{to:?}");
    assert!(outside.meet(&[v(0.02, 0.3, -0.02)]));
    assert!(!outside.meet(&[v(0.02, 0.3, -0.02)]));
    let contacts = &mut outside.contacts;
    let mut x = [v(0.02, 0.3, -0.02)];
    contacts.place(&mut x);
    assert!((x[0] - to[0]).norm() < 1e-9, "{x:?}");
    let mut pull = [v(1.0, 2.0, 3.0)];
    contacts.project(&mut pull);
    assert!((pull[0] - v(0.0, 2.0, 0.0)).norm() < 1e-12);
    // Pulled upwards it leaves the ground, and stays at the wall.
    assert!(contacts.release(&[v(1.0, 0.0, 1.0)]));
    let mut pull = [v(1.0, 2.0, 3.0)];
    contacts.project(&mut pull);
    assert!((pull[0] - v(0.0, 2.0, 3.0)).norm() < 1e-12);
}

#[test]
fn velocities_end_at_surfaces_and_only_there() {
    let mut wall = cuboid([0.0, -1.0, -1.0], [1.0, 1.0, 1.0]);
    let barrier = |wall| barrier(true, vec![wall]);
    let x = [v(-CLEARANCE_M, 0.0, CLEARANCE_M)];
    let mut velocity = [[1.0, 2.0, -3.0]];
    barrier(wall.clone()).stop(&x, &mut velocity);
    assert_eq!(velocity, [[0.0, 2.0, 0.0]]);
    let mut velocity = [[1.0, 2.0, -3.0]];
    barrier(wall.clone()).stop(&[v(-0.001, 0.0, 0.001)], &mut velocity);
    assert_eq!(velocity, [[1.0, 2.0, -3.0]]);
    let mut velocity = [[-1.0, 0.0, 0.5]];
    barrier(wall.clone()).stop(&x, &mut velocity);
    assert_eq!(velocity, [[-1.0, 0.0, 0.5]]);
    // A wall that comes takes it along; one that goes lets it follow.
    wall.motion[0][3] = -0.25;
    let mut velocity = [[1.0, 2.0, 0.0]];
    barrier(wall.clone()).stop(&x, &mut velocity);
    assert_eq!(velocity, [[-0.25, 2.0, 0.0]]);
    wall.motion[0][3] = 0.25;
    let mut velocity = [[1.0, 2.0, 0.0]];
    barrier(wall).stop(&x, &mut velocity);
    assert_eq!(velocity, [[0.25, 2.0, 0.0]]);
}

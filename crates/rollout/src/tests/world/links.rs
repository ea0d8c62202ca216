//! Costs of colliders that grippers carry, as the links of an arm are: another motion in each instance.

use bendtwin_proto::v1::cost::{Clearance, Force, force::By};

use super::*;

const FRAMES: u32 = 6;
const KNOTS: usize = 3;

/// A capsule that two instances push up against the chain, one farther to the side and tilted.
const VALUES: [f32; 2 * KNOTS * 7] = [
    0.21, 0.0, 0.22, 0.0, 0.0, 0.0, 1.0, //
    0.21, 0.0, 0.245, 0.0, 0.05, 0.0, 1.0, //
    0.22, 0.0, 0.26, 0.0, 0.1, 0.0, 1.0, //
    0.09, 0.0, 0.23, 0.1, 0.0, 0.0, 1.0, //
    0.1, 0.0, 0.25, 0.1, 0.0, 0.1, 1.0, //
    0.11, 0.01, 0.27, 0.1, 0.0, 0.2, 1.0,
];

fn link() -> Collider {
    let capsule = Capsule { from: vec![0.0, -0.3, 0.0], to: vec![0.0, 0.3, 0.0], radius_m: 0.05 };
    Collider {
        shape: Some(collider::Shape::Capsule(capsule)),
        carrier: Some(collider::Carrier::Gripper(0)),
        ..Collider::default()
    }
}

/// A chain that floats above the link.
fn pushed(values: &[f32], kind: Kind) -> RollOutRequest {
    let poses = Some(Tensor::pack(&[2, KNOTS, 1, 7], values));
    RollOutRequest {
        actions: Some(Actions::Poses(GripperPoses { poses, ..GripperPoses::default() })),
        frames: FRAMES,
        world: Some(World {
            gravity: vec![0.0; 3],
            ground_choice: Some(GroundChoice::NoGround(true)),
            colliders: vec![link()],
            ..World::default()
        }),
        costs: vec![Cost { when: When::EveryFrame.into(), kind: Some(kind), ..Cost::default() }],
        ..RollOutRequest::default()
    }
}

fn clearance() -> Kind {
    Kind::Clearance(Clearance { collider: 0, margin_m: 0.06 })
}

fn force() -> Kind {
    Kind::Force(Force { by: Some(By::Collider(0)), limit_n: 1.0 })
}

#[test]
fn forces_of_a_link_are_those_that_it_exerts() {
    let mut request = pushed(&VALUES, force());
    request.returns = Some(Returns { forces: true, ..Returns::default() });
    let part = bench(chain(0.3)).run(request, 0).unwrap().remove(0);
    let wrenches = floats(&part.forces.as_ref().unwrap().colliders);
    for (instance, cost) in f64s(&part.costs).into_iter().enumerate() {
        let own = wrenches.chunks(6).skip(instance * FRAMES as usize).take(FRAMES as usize);
        let excess = own.map(|w| {
            let size = w[..3].iter().map(|f| f64::from(*f).powi(2)).sum::<f64>().sqrt();
            (size - 1.0).max(0.0).powi(2)
        });
        let expected: f64 = excess.sum();
        assert!(expected > 1.0, "instance {instance} is not pushed: {expected}");
        assert!((cost - expected).abs() < 1e-4 * expected, "{instance}: {cost} {expected}");
    }
}

#[test]
fn gradients_by_the_motion_of_a_link_agree_with_differences() {
    let bench = bench(chain(0.3));
    for kind in [clearance(), force()] {
        let ask = |values: &[f32]| {
            let mut request = pushed(values, kind.clone());
            request.gradient = Some(GradientOptions { reach_frames: 0, smoothing_m: 0.01 });
            request.returns = Some(Returns { action_gradients: true, ..Returns::default() });
            bench.run(request, 0).unwrap().remove(0)
        };
        let part = ask(&VALUES);
        let gradient = floats(&part.action_gradients);
        for instance in 0..2 {
            let own = instance * KNOTS * 7..(instance + 1) * KNOTS * 7;
            let scale = gradient[own.clone()].iter().fold(0.0f32, |m, g| m.max(g.abs()));
            assert!(scale > 1e-3, "{kind:?}, instance {instance}: {scale}");
            for i in own {
                let moved = |by: f32| {
                    let mut values = VALUES;
                    values[i] += by;
                    f64s(&ask(&values).costs)[instance]
                };
                let expected = (moved(2e-4) - moved(-2e-4)) / 4e-4;
                let error = (f64::from(gradient[i]) - expected).abs();
                assert!(
                    error < 0.02 * f64::from(scale),
                    "{kind:?}, {i}: {} {expected} of {scale}",
                    gradient[i]
                );
            }
        }
    }
}

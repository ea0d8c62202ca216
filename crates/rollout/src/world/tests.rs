use bendtwin_contract_kit::hanging::twin;
use bendtwin_core::Problem as _;
use bendtwin_engine::world::{IDENTITY, Shape, spring_share};
use bendtwin_proto::v1::{
    Collider as WireCollider, Cuboid, GradientOptions, Grasp as WireGrasp, GripperPoses,
    Plane as WirePlane, Returns, Sphere, World as WireWorld, collider, grasp,
};

use super::*;
use crate::request::actions::Horizon;

const FRAMES: usize = 4;

/// Poses of two grippers at heights in two knots, for two instances.
fn poses(heights: [[f32; 2]; 2]) -> Option<Wire> {
    let row = |z: f32| [0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0];
    let knots = heights.as_flattened().iter().map(|z| row(*z)).collect::<Vec<_>>();
    let poses = Some(Tensor::pack(&[2, 2, 2, 7], knots.repeat(2).as_flattened()));
    let gripper_of_control = Some(Tensor::pack(&[1], &[1u32]));
    Some(Wire::Poses(GripperPoses { poses, gripper_of_control, ..GripperPoses::default() }))
}

fn request() -> RollOutRequest {
    RollOutRequest { actions: poses([[0.0, 1.0], [0.4, 1.4]]), ..RollOutRequest::default() }
}

fn read(mut request: RollOutRequest) -> Result<(Surroundings, Actions), Error> {
    let twin = twin();
    let map = gripper_of_control(request.actions.as_ref(), 1)?;
    let horizon = Horizon { frames: FRAMES, fps: 30.0, times: None };
    let actions = Actions::read(request.actions.take(), 1, horizon)?;
    let model = Model::from(&twin);
    let surroundings = Surroundings::read(&mut request, &actions, map, &twin, &model)?;
    Ok((surroundings, actions))
}

fn ball() -> Sphere {
    Sphere { center: vec![0.0, 0.0, 0.1], radius_m: 0.05 }
}

fn collider(carrier: Option<Carrier>) -> WireCollider {
    WireCollider {
        shape: Some(collider::Shape::Sphere(ball())),
        carrier,
        ..WireCollider::default()
    }
}

fn holding(region: grasp::Region) -> WireGrasp {
    WireGrasp { gripper: 1, region: Some(region), ..WireGrasp::default() }
}

#[test]
fn nothing_around_is_the_empty_world() {
    let (surroundings, actions) = read(request()).unwrap();
    assert_eq!(surroundings.world(Factors::ONE), World::default());
    assert_eq!(surroundings.motion(1, &actions), Motion::default());
    assert_eq!(surroundings.environment(Environment::Z_UP), None);
}

#[test]
fn bodies_are_the_grippers_and_then_the_paths() {
    let row = |x: f32| [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let path = Tensor::pack(&[2, 7], [row(2.0), row(3.0)].as_flattened());
    let colliders = vec![
        collider(Some(Carrier::Path(path))),
        collider(None),
        collider(Some(Carrier::Gripper(1))),
    ];
    let world = Some(WireWorld { colliders, ..WireWorld::default() });
    let (surroundings, actions) = read(RollOutRequest { world, ..request() }).unwrap();
    let world = surroundings.world(Factors::ONE);
    assert_eq!(world.bodies, 3);
    let carriers: Vec<_> = world.colliders.iter().map(|c| c.body).collect();
    assert_eq!(carriers, [Some(2), None, Some(1)]);
    let motion = surroundings.motion(1, &actions);
    assert_eq!(motion.poses.len(), 3 * (FRAMES + 1));
    let at = |frame: usize, body: usize, axis: usize| motion.poses[3 * frame + body][axis][3];
    assert_eq!((at(0, 0, 2), at(0, 1, 2), at(0, 2, 0)), (0.0, 1.0, 2.0));
    assert!((at(1, 0, 2) - 0.1).abs() < 1e-6 && (at(1, 2, 0) - 2.25).abs() < 1e-6);
    assert!((at(4, 1, 2) - 1.4).abs() < 1e-6 && (at(4, 2, 0) - 3.0).abs() < 1e-6);
    assert!(motion.closed.is_empty());
}

#[test]
fn a_grasp_is_closed_from_its_knots_on() {
    let values = [1u32, 0, 0, 1];
    let each = WireGrasp {
        closed: Some(Tensor::pack(&[2, 2], &values)),
        ..holding(grasp::Region::Sphere(ball()))
    };
    let always = holding(grasp::Region::Nodes(Tensor::pack(&[2], &[3u32, 1])));
    let grasps = vec![each, always];
    let (surroundings, actions) = read(RollOutRequest { grasps, ..request() }).unwrap();
    // The second of two knots is at the end: until then the first one holds.
    let closed = |instance| surroundings.motion(instance, &actions).closed;
    assert_eq!(closed(0), [true; 2 * FRAMES]);
    assert_eq!(closed(1), [false, true].repeat(FRAMES));
    let world = surroundings.world(Factors::ONE);
    assert_eq!(world.grasps[1].region, Region::Nodes(std::sync::Arc::new(vec![1, 3])));
    assert_eq!((world.bodies, world.grasps[0].body), (2, 1));
    // The middle of the sphere moves with its gripper.
    let middles = surroundings.middles(&surroundings.motion(0, &actions));
    assert_eq!(middles.len(), FRAMES + 1);
    assert!((middles[FRAMES][2] - 1.5).abs() < 1e-6);
}

#[test]
fn a_hand_is_held_by_the_gripper_that_carries_it() {
    let hand = |gripper, hand| {
        let region = Some(grasp::Region::Hand(grasp::CaptureHand { hand }));
        let grasps = vec![WireGrasp { gripper, region, ..WireGrasp::default() }];
        read(RollOutRequest { grasps, ..request() })
    };
    let (surroundings, _) = hand(1, 0).unwrap();
    let region = &surroundings.world.grasps[0].region;
    assert_eq!(*region, Region::Controls(std::sync::Arc::new(vec![0])));
    let error = hand(0, 0).err().unwrap().to_string();
    assert!(error.contains("carried by gripper 1"), "{error}");
    let error = hand(1, 7).err().unwrap().to_string();
    assert!(error.contains("grasps[0].hand.hand"), "{error}");
}

#[test]
fn springs_of_a_hold_are_stable_or_refused() {
    let springs = |stiffness, damping| {
        let attachment = grasp::Attachment::Springs.into();
        let own = holding(grasp::Region::Sphere(ball()));
        let grasps = vec![WireGrasp { attachment, stiffness, damping, ..own }];
        read(RollOutRequest { grasps, ..request() }).map(|(s, _)| s)
    };
    let chosen = springs(0.0, 0.0).unwrap();
    let Attachment::Spring { stiffness, damping } = chosen.world.grasps[0].attachment else {
        panic!("springs were asked for")
    };
    let model = Model::from(&twin());
    let share = spring_share(&model, stiffness, damping);
    assert!((0.99..=1.0).contains(&share) && stiffness > 1000.0, "{share} {stiffness}");
    assert!((damping - 2.0 * stiffness.sqrt()).abs() < 1e-3 * damping);
    // Springs that are given are as much stiffer at unit mass as an object is lighter.
    let of = |surroundings: &Surroundings, mass: f32| {
        let world = surroundings.world(Factors { mass, ..Factors::ONE });
        let Attachment::Spring { stiffness, .. } = world.grasps[0].attachment else {
            panic!("springs were asked for")
        };
        stiffness
    };
    assert_eq!(of(&chosen, 0.5), stiffness);
    assert_eq!(of(&springs(100.0, 0.0).unwrap(), 0.5), 200.0);
    let error = springs(1e9, 0.0).unwrap_err();
    assert_eq!(error.category(), bendtwin_core::Category::InvalidArgument);
    assert!(error.to_string().contains("grasps[0].stiffness"), "{error}");
}

#[test]
fn gravity_and_ground_take_the_place_of_the_twins() {
    let environment = |world| {
        let request = RollOutRequest { world: Some(world), ..request() };
        read(request).unwrap().0.environment(Environment::Z_UP)
    };
    let ground = WirePlane { normal: Vec::new(), offset_m: 0.2 };
    let raised =
        WireWorld { ground_choice: Some(GroundChoice::Ground(ground)), ..WireWorld::default() };
    let expected = Plane { normal: UP, offset_m: 0.2 };
    assert_eq!(environment(raised).unwrap().ground, Some(expected));
    let none = WireWorld {
        gravity: vec![0.0; 3],
        ground_choice: Some(GroundChoice::NoGround(true)),
        ..WireWorld::default()
    };
    assert_eq!(environment(none), Some(Environment { gravity: [0.0; 3], ground: None }));
    assert_eq!(environment(WireWorld::default()), None);
    let rough = WireWorld {
        ground_friction: Some(1.5),
        ground_restitution: Some(0.0),
        ..WireWorld::default()
    };
    let (surroundings, _) = read(RollOutRequest { world: Some(rough), ..request() }).unwrap();
    let mut contact = Contact::default();
    surroundings.touch(&mut contact);
    assert_eq!((contact.ground_friction, contact.ground_restitution), (1.5, 0.0));
}

#[test]
fn friction_varies_and_smoothing_waits_for_gradients() {
    let cuboid = Cuboid { low: vec![0.0; 3], high: vec![1.0; 3] };
    let table = WireCollider {
        shape: Some(collider::Shape::Cuboid(cuboid)),
        margin_m: 0.01,
        friction: Some(0.8),
        ..WireCollider::default()
    };
    let world = Some(WireWorld { colliders: vec![table], ..WireWorld::default() });
    let gradient = Some(GradientOptions { smoothing_m: 0.001, reach_frames: 0 });
    let mut asking = RollOutRequest { world, gradient, ..request() };
    let smoothing =
        |request: &RollOutRequest| read(request.clone()).unwrap().0.world(Factors::ONE).smoothing_m;
    assert_eq!(smoothing(&asking), 0.0);
    asking.returns = Some(Returns { control_gradients: true, ..Returns::default() });
    assert_eq!(smoothing(&asking), 0.001);
    let (surroundings, _) = read(asking).unwrap();
    let rough = surroundings.world(Factors { friction: 2.0, ..Factors::ONE });
    assert_eq!(rough.colliders[0].friction, 1.6);
    // The obstacle is known without its margin, and needs no body.
    let obstacles = surroundings.obstacles(&Environment::Z_UP);
    assert!(matches!(obstacles.shapes[..], [(Shape::Convex(_), margin)] if margin == 0.01));
    assert_eq!((obstacles.ground, rough.bodies), (Environment::Z_UP.ground, 0));
    assert_eq!(moved(&IDENTITY, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
}

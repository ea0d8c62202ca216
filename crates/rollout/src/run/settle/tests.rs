use bendtwin_core::{Environment, Problem as _, Twin, ids::TwinId};
use bendtwin_proto::v1::{Collider, Cuboid, Plane, Tensor, World, collider, world::GroundChoice};

use super::*;
use bendtwin_contract_kit::hanging::twin;

const WORK: u64 = 1_000_000_000;

fn settled(twin: Twin, work: u64) -> Result<Start, Error> {
    settled_in(None, twin, work)
}

fn settled_in(world: Option<World>, twin: Twin, work: u64) -> Result<Start, Error> {
    let backend = bendtwin_engine::cpu_with_threads(1);
    let warm = Warm::load(TwinId::generate(), twin, backend.as_ref(), None).unwrap();
    let world = Still::read(world.as_ref())?;
    settle(&warm, &world, work, backend.as_ref(), &CancelToken::default())
}

/// Four nodes of 1 kg hang below one another from springs of 500 N per unit strain and 0.1 m.
#[test]
fn a_chain_hangs_as_its_springs_say() {
    let start = settled(twin(), WORK).unwrap();
    let mut height = 0.6;
    for (node, position) in start.state.positions.iter().enumerate() {
        let carried = (4 - node) as f32;
        height -= 0.1 * (1.0 + carried * 9.81 / 500.0);
        assert!((position[2] - height).abs() < 1e-3, "{node}: {position:?}, not at {height}");
    }
    assert!(start.state.velocities.iter().all(|v| *v == [0.0; 3]));
    assert_eq!(*start.controls, [[0.0, 0.0, 0.6]]);
    assert_eq!(start.state, settled(twin(), WORK).unwrap().state, "the same bits");
}

#[test]
fn what_falls_for_ever_is_refused() {
    let mut falling = twin();
    falling.environment = Environment { ground: None, ..falling.environment };
    falling.graph.springs[0] = [0, 1];
    falling.graph.springs[1] = [1, 2];
    falling.graph.springs[2] = [2, 3];
    falling.graph.springs[3] = [0, 2];
    falling.params.rest_lengths_m[3] = 0.2;
    let error = settled(falling, WORK).err().unwrap();
    assert_eq!(error.reason(), "NEVER_AT_REST");
    assert!(error.to_string().contains("m/s"), "{error}");
}

fn lowest(start: &Start) -> f32 {
    start.state.positions.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min)
}

#[test]
fn a_chain_hangs_in_the_gravity_of_the_world() {
    let moon = World { gravity: vec![0.0, 0.0, -1.62], ..World::default() };
    let start = settled_in(Some(moon), twin(), WORK).unwrap();
    let expected = 0.2 - 0.1 * 10.0 * 1.62 / 500.0;
    assert!((lowest(&start) - expected).abs() < 1e-3, "{start:?}, not at {expected}");
}

#[test]
fn it_rests_on_the_ground_and_the_colliders_of_the_world() {
    let plane = Plane { offset_m: 0.25, ..Plane::default() };
    let ground = World { ground_choice: Some(GroundChoice::Ground(plane)), ..World::default() };
    let on_ground = settled_in(Some(ground), twin(), WORK).unwrap();
    assert!((lowest(&on_ground) - 0.25).abs() < 2e-3, "{on_ground:?}");

    let cuboid = Cuboid { low: vec![-1.0, -1.0, -0.5], high: vec![1.0, 1.0, 0.0] };
    // Begins below the chain, and leaves it later.
    let poses = [[0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 1.0f32], [9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]];
    let path = Tensor::pack(&[2, 7], poses.as_flattened());
    let table = |carrier| Collider {
        shape: Some(collider::Shape::Cuboid(cuboid.clone())),
        carrier,
        ..Collider::default()
    };
    let on_table = |carrier| {
        let world = World { colliders: vec![table(carrier)], ..World::default() };
        settled_in(Some(world), twin(), WORK).unwrap()
    };
    let on_path = on_table(Some(collider::Carrier::Path(path)));
    assert!((lowest(&on_path) - 0.25).abs() < 2e-3, "{on_path:?}");
    // A table that begins above the chain's end takes the nodes in it out on their side.
    let poses = [[0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0f32]];
    let path = Tensor::pack(&[1, 7], poses.as_flattened());
    let lifted = on_table(Some(collider::Carrier::Path(path)));
    assert!(lowest(&lifted) > 0.3 - 2e-3, "{lifted:?}");
    // The place of the gripper is unknown.
    let carried = on_table(Some(collider::Carrier::Gripper(0)));
    assert_eq!(carried.state, settled(twin(), WORK).unwrap().state);
}

#[test]
fn worlds_in_which_a_twin_settles_equally_have_one_key() {
    let key = |world: &World| Still::read(Some(world)).unwrap().key();
    let collider = |name: &str, carrier| Collider {
        name: name.to_owned(),
        shape: Some(collider::Shape::Cuboid(Cuboid::default())),
        carrier,
        ..Collider::default()
    };
    let world = |colliders| World { colliders, ..World::default() };
    let fixed = world(vec![collider("table", None)]);
    assert_eq!(key(&fixed), key(&world(vec![collider("desk", None)])));
    let carried = collider("finger", Some(collider::Carrier::Gripper(1)));
    assert_eq!(key(&fixed), key(&world(vec![collider("", None), carried])));
    assert_ne!(key(&fixed), key(&World::default()));
    assert_ne!(key(&fixed), key(&World { gravity: vec![0.0, 0.0, -1.0], ..fixed.clone() }));
}

#[test]
fn too_much_work_is_refused() {
    let error = settled(twin(), 1000).err().unwrap();
    assert_eq!(error.reason(), "ROLLOUT_TOO_LARGE");
}

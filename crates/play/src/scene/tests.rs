use bendtwin_proto::v1::{Collider, Sphere, collider::Shape, roll_out_request::Actions};

use super::*;

/// Five nodes in a line, held by a hand at its end.
fn scene() -> Scene {
    Scene::new(Setting {
        frame_s: 1.0 / 30.0,
        hands: vec![0, 0],
        controls: vec![[0.0, -0.1, 0.0], [0.0, 0.1, 0.0]],
        positions: (0..5u8).map(|i| [f32::from(i), 0.0, 0.0]).collect(),
        fidelity: Fidelity::Exact,
    })
    .unwrap()
}

fn target(index: u32, x: f32) -> Target {
    Target { index, position: [x, 0.0, 0.0], orientation: None }
}

fn advance(scene: &mut Scene) -> Rows {
    let frame = scene.next();
    scene.passed(&frame);
    frame
}

#[test]
fn hands_hold_until_they_are_dropped_and_pointers_close_where_a_node_is() {
    let mut scene = scene();
    assert_eq!(scene.next().grippers(0)[0][..3], [0.0, 0.0, 0.0], "the middle of its points");
    assert_eq!(scene.next().closed(0)[0], 1);
    scene.release(0).unwrap();
    assert_eq!(scene.next().closed(0), vec![0; scene.grips.closed().count()]);
    scene.grasp(2, 3, 0.0, false).unwrap();
    let reaching = advance(&mut scene);
    assert_eq!((reaching.closed(0).iter().sum::<u32>(), reaching.grippers(1)[2][0]), (0, 3.0));
    scene.aim(&[target(2, 3.05)], &[]).unwrap();
    let holding = advance(&mut scene);
    assert_eq!((holding.closed(0).iter().sum::<u32>(), holding.grippers(1)[2][0]), (1, 3.05));
    assert_eq!(scene.holding(), [false, false, true, false, false]);
    // Also the nodes around it.
    scene.grasp(2, 3, 1.0, false).unwrap();
    let nodes: Vec<usize> = scene
        .grips
        .wire()
        .iter()
        .filter_map(|grasp| match &grasp.region {
            Some(bendtwin_proto::v1::grasp::Region::Nodes(nodes)) => Some(nodes.shape[0] as usize),
            _ => None,
        })
        .collect();
    assert!(nodes.contains(&3), "{nodes:?}");
    assert!(scene.next().closed(0).iter().all(|c| *c == 0), "it opens for a frame");
}

#[test]
fn what_is_not_there_is_refused() {
    let mut scene = scene();
    assert!(scene.grasp(9, 0, 0.0, false).is_err());
    assert!(scene.grasp(0, 5, 0.0, false).is_err());
    assert!(scene.release(5).is_err());
    assert!(scene.aim(&[target(5, 0.0)], &[]).is_err());
    assert!(scene.aim(&[], &[target(0, 0.0)]).is_err());
    let crowd = World { colliders: vec![Collider::default(); 9], ..World::default() };
    assert!(scene.surround(crowd, Factors::default()).is_err());
    let many = Setting {
        hands: vec![40],
        ..Setting {
            frame_s: 0.1,
            hands: vec![],
            controls: vec![[0.0; 3]],
            positions: vec![],
            fidelity: Fidelity::Exact,
        }
    };
    assert!(Scene::new(many).is_err());
}

#[test]
fn a_refused_world_is_replaced_by_the_previous_one() {
    let mut scene = scene();
    let shape = Some(Shape::Sphere(Sphere { center: Vec::new(), radius_m: 0.1 }));
    let ball =
        Collider { shape, pose: vec![0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], ..Collider::default() };
    let world = World { colliders: vec![ball], ground_friction: Some(0.5), ..World::default() };
    scene.surround(world, Factors::default()).unwrap();
    let first = scene.generation();
    assert_eq!(advance(&mut scene).colliders(0)[0][2], 1.0);
    scene.aim(&[], &[target(0, 0.05)]).unwrap();
    assert_eq!(scene.generation(), first, "motion does not change it");
    let moved = advance(&mut scene);
    assert!(moved.colliders(1)[0][2] < 1.0);
    let wrong = World { ground_friction: Some(9.0), ..World::default() };
    scene.surround(wrong, Factors { stiffness: Some(2.0), ..Factors::default() }).unwrap();
    assert!(scene.template().vary.is_some());
    assert!(scene.revert() && !scene.revert());
    let template = scene.template();
    assert_eq!(template.world.unwrap().ground_friction, Some(0.5));
    assert_eq!((template.vary, scene.collider_poses().len()), (None, 1));
}

#[test]
fn more_grasps_than_a_request_has_begin_another_segment() {
    let mut scene = scene();
    let begun = scene.generation();
    for node in 0..5 {
        scene.grasp(1, node, 0.0, false).unwrap();
        scene.grasp(2, node, 0.0, true).unwrap();
        advance(&mut scene);
        advance(&mut scene);
    }
    assert_ne!(scene.generation(), begun);
    let begun = scene.generation();
    scene.begin_segment();
    scene.grasp(1, 4, 0.0, false).unwrap();
    assert_eq!(scene.generation(), begun, "the same nodes again");
    let template = scene.template();
    assert!(matches!(template.actions, Some(Actions::Poses(_))) && template.grasps.len() <= 32);
}

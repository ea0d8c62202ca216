use super::*;

/// Nodes and springs that the reference's graphs have.
const REFERENCE: [(SceneName, usize, usize); 4] = [
    (SceneName::N500, 507, 9_851),
    (SceneName::N2000, 2_003, 33_515),
    (SceneName::N5000, 5_019, 80_373),
    (SceneName::N10000, 10_001, 156_965),
];

#[test]
fn counts_agree_with_the_reference() {
    for (name, nodes, springs) in REFERENCE {
        let scene = Scene::new(name, false).unwrap();
        let graph = &scene.model.graph;
        assert_eq!(graph.node_count(), nodes);
        assert_eq!((graph.control_count(), scene.control_spring_count()), (30, 1_500));
        assert_eq!(scene.stiffness, 3e4, "{name} is stable with PhysTwin's stiffness");
        let ratio = graph.springs.len() as f64 / springs as f64;
        assert!((0.99..=1.01).contains(&ratio), "{name}: {} springs", graph.springs.len());
    }
}

#[test]
fn a_rope_has_432_nodes_and_8_controls() {
    let scene = Scene::new(SceneName::Rope, true).unwrap();
    let graph = &scene.model.graph;
    assert_eq!((graph.node_count(), graph.control_count()), (432, 8));
    let valence = 2.0 * graph.springs.len() as f64 / 432.0;
    assert!((30.0..=35.0).contains(&valence), "{valence}");
    let per_surface_node = graph.triplets.len() as f64 / graph.surface_count() as f64;
    assert!((3.0..=4.0).contains(&per_surface_node), "{per_surface_node}");
}

#[test]
fn bending_adds_triplets_and_nothing_else() {
    let (axial, bent) =
        (Scene::new(SceneName::N500, false).unwrap(), Scene::new(SceneName::N500, true).unwrap());
    assert!(axial.model.graph.triplets.is_empty());
    assert_eq!(axial.model.graph.springs, bent.model.graph.springs);
    assert_eq!(axial.model.params.spring_stiffness, bent.model.params.spring_stiffness);
    assert!(bent.model.graph.triplets.len() > 3 * bent.model.graph.surface_count());
    assert!(bent.model.graph.surface_count() < bent.model.graph.node_count());
}

#[test]
fn a_name_is_always_the_same_scene() {
    let make = || Scene::new(SceneName::Rope, true).unwrap();
    assert_eq!(*make().model, *make().model);
}

#[test]
fn instances_move_differently_from_the_same_start() {
    let scene = Scene::new(SceneName::Rope, false).unwrap();
    let (a, b) = (scene.motion.path(0, 3), scene.motion.path(1, 3));
    let controls = &scene.model.graph.control_rest;
    assert_eq!(a.len(), 4 * 8);
    assert_eq!(&a[..8], &controls[..]);
    assert_eq!(&b[..8], &controls[..]);
    assert_ne!(a[8..], b[8..]);
}

#[test]
fn names_can_be_typed() {
    for name in SceneName::ALL {
        assert_eq!(name.as_str().parse(), Ok(name));
    }
    assert!("n1".parse::<SceneName>().unwrap_err().contains("n10000"));
}

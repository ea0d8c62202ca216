use super::*;

/// Six nodes in a row, the outer two on each side pinned.
fn cable() -> Graph {
    let pin = |node| Pin { node, control: 0, offset_m: [0.0; 3] };
    Graph {
        rest_positions: (0..6).map(|i| [i as f32, 0.0, 0.0]).collect(),
        kinds: vec![NodeKind::Observed; 6],
        masses: vec![1.0; 6],
        object_ids: vec![0; 6],
        observed_points: (0..6).collect(),
        control_rest: vec![[0.0; 3]],
        pins: [0, 1, 4, 5].map(pin).to_vec(),
        rods: vec![(0..6).collect()],
        ..Graph::default()
    }
}

#[test]
fn a_rod_is_a_path_from_a_clamp_to_a_clamp_or_an_arm() {
    assert_eq!(cable().check(), Ok(()));
    assert!(!cable().has_arm(&cable().rods[0]));
    let with_arm = Graph { rods: vec![vec![0, 1, 2, 3]], ..cable() };
    assert_eq!(with_arm.check(), Ok(()));
    assert!(with_arm.has_arm(&with_arm.rods[0]));
    for (rod, why) in [
        (vec![0, 1, 5], "at least 4"),
        (vec![0, 1, 2, 4], "ends in nodes 2 and 4"),
        (vec![0, 2, 4, 5], "not clamped at node 2"),
        (vec![0, 1, 2, 2, 4, 5], "passes node 2 twice"),
        (vec![0, 1, 9, 4, 5], "names node 9 of 6"),
    ] {
        let fault = Graph { rods: vec![rod], ..cable() }.check().unwrap_err();
        assert!(fault.contains(why), "{fault}");
    }
}

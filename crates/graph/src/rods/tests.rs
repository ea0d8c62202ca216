use bendtwin_core::{NodeKind, Pin};

use super::*;
use crate::LeftOut;

/// A cable of nodes 0..n with these edges and held nodes.
fn cable(n: u32, edges: &[[u32; 2]], held: &[u32]) -> NodeSample {
    let pin =
        |(control, &node): (usize, &u32)| Pin { node, control: control as u32, offset_m: [0.0; 3] };
    NodeSample {
        positions: (0..n).map(|i| [0.1 * i as f32, 0.0, 0.0]).collect(),
        kinds: vec![NodeKind::Observed; n as usize],
        observed_points: (0..n).collect(),
        object_ids: vec![0; n as usize],
        control_rest: vec![[0.0; 3]; held.len()],
        pins: held.iter().enumerate().map(pin).collect(),
        edges: Some(edges.to_vec()),
        rest_shape: None,
        point_spacing_m: 0.0,
        spacing_scale: 1.0,
        surface: Default::default(),
        left_out: LeftOut::default(),
    }
}

fn line(n: u32) -> Vec<[u32; 2]> {
    (1..n).map(|i| [i - 1, i]).collect()
}

#[test]
fn what_lies_between_two_clamps_is_a_rod() {
    let rod: Vec<u32> = (0..8).collect();
    assert_eq!(find(&cable(8, &line(8), &[0, 1, 6, 7])), std::slice::from_ref(&rod));
    // A longer grip reaches as far as the nodes next to what is free.
    assert_eq!(find(&cable(8, &line(8), &[0, 1, 2, 6, 7])), [rod[1..].to_vec()]);
    // However edges are named.
    let turned: Vec<[u32; 2]> = line(8).iter().rev().map(|&[a, b]| [b, a]).collect();
    assert_eq!(find(&cable(8, &turned, &[7, 6, 1, 0])), [rod]);
}

#[test]
fn ends_without_direction_carry_no_torque() {
    let none: Vec<Vec<u32>> = Vec::new();
    for held in [&[][..], &[0, 1], &[0, 7], &[0, 1, 7], &[0, 2, 5, 7]] {
        assert_eq!(find(&cable(8, &line(8), held)), none, "{held:?}");
    }
    let unknown = NodeSample { edges: None, ..cable(8, &line(8), &[0, 1, 6, 7]) };
    assert_eq!(find(&unknown), none);
}

#[test]
fn a_third_clamp_ends_a_rod_and_a_single_pin_does_not() {
    let rods = find(&cable(12, &line(12), &[0, 1, 5, 6, 10, 11]));
    assert_eq!(rods, [(0..7).collect::<Vec<u32>>(), (5..12).collect()]);
    let rods = find(&cable(12, &line(12), &[0, 1, 5, 10, 11]));
    assert_eq!(rods, [(0..12).collect::<Vec<u32>>()]);
}

/// A trunk 0..8 with a branch 8, 9, 10 from node 4.
#[test]
fn a_branch_holds_the_frame_or_takes_part_if_it_is_clamped() {
    let mut edges = line(8);
    edges.extend([[4, 8], [8, 9], [9, 10]]);
    let free = find(&cable(11, &edges, &[0, 1, 6, 7]));
    assert_eq!(free, [vec![0, 1, 2, 3, 4, 8], vec![7, 6, 5, 4, 8]]);
    let all = find(&cable(11, &edges, &[0, 1, 6, 7, 9, 10]));
    assert_eq!(
        all,
        [vec![0, 1, 2, 3, 4, 5, 6, 7], vec![0, 1, 2, 3, 4, 8, 9, 10], vec![7, 6, 5, 4, 8, 9, 10]]
    );
}

#[test]
fn loops_have_no_rods() {
    let mut edges = line(8);
    edges.push([2, 5]);
    assert!(find(&cable(8, &edges, &[0, 1, 6, 7])).is_empty());
}

use bendtwin_core::{Graph, geometry::Vector};

use super::*;

/// Points with one to four carriers, in frames and out of them, with offsets and without.
fn skin(nodes: u32, points: u32) -> Skin {
    let mut skin = Skin::default();
    for m in 0..points {
        let carriers = 1 + m % 4;
        let of =
            |k: u32| ((7 * m + 3 * k * k + k) % nodes, 1.0 / carriers as f32 + 0.01 * k as f32);
        let weights: Vec<(u32, f32)> = (0..carriers).map(of).collect();
        let frame = match m % 3 {
            0 => [Skin::NO_FRAME; 3],
            _ => [m, m + 1, m + 3].map(|i| i % nodes),
        };
        let offset = if m % 5 == 0 { [0.0; 3] } else { [0.01 * m as f32, -0.02, 0.03] };
        skin.push(Graph::NOT_OBSERVED, &weights, frame, offset);
    }
    skin
}

/// Every weight and corner is where the skin has it, once, and those of a node are in order.
#[test]
fn nodes_see_every_weight_and_corner() {
    for (nodes, points) in [(9, 40), (30, 7), (5, 0)] {
        let skin = skin(nodes, points);
        let by_node = SkinByNode::new(&skin, nodes as usize);
        let (mut weights, mut corners) = (Vec::new(), Vec::new());
        for node in 0..nodes as usize {
            let own = by_node.starts[node] as usize..by_node.starts[node + 1] as usize;
            assert!(by_node.points[own.clone()].is_sorted(), "node {node}");
            weights.extend(own.map(|k| (by_node.points[k], node as u32, by_node.weights[k])));
            let own =
                by_node.corner_starts[node] as usize..by_node.corner_starts[node + 1] as usize;
            assert!(by_node.corners[own.clone()].is_sorted(), "node {node}");
            corners.extend(own.map(|k| (by_node.corners[k], node as u32)));
        }
        let expected =
            (0..points).flat_map(|m| skin.weights_of(m as usize).map(move |(i, w)| (m, i, w)));
        let mut expected: Vec<(u32, u32, f32)> = expected.collect();
        for all in [&mut weights, &mut expected] {
            all.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        }
        assert_eq!(weights, expected);
        // Corners are what a gradient is passed on to beside the weights.
        let at = |i: u32| -> Vector { [f64::from(i * i), f64::from(i), 1.0 / f64::from(i + 1)] };
        let mut calls = 0;
        for m in 0..points as usize {
            skin.add_gradient(m, at, [1.0; 3], |_, _| calls += 1);
        }
        assert_eq!(calls, weights.len() + corners.len());
        corners.sort_unstable();
        for (&([point, corner], node), next) in corners.iter().zip(corners.iter().skip(1)) {
            assert_eq!(skin.frames[point as usize][corner as usize], node);
            assert!([point, corner] < next.0, "{point} has corner {corner} twice");
        }
    }
}

/// Nodes that carry nothing have their places too.
#[test]
fn a_skin_of_few_nodes_suits_a_graph_of_many() {
    let skin = skin(3, 8);
    let [few, many] = [3, 10].map(|nodes| SkinByNode::new(&skin, nodes));
    assert_eq!(many.starts.len(), 11);
    assert_eq!(many.starts[3..], [*few.starts.last().expect("an end"); 8]);
    assert_eq!(many.corner_starts[3..], [*few.corner_starts.last().expect("an end"); 8]);
    assert_eq!((many.points, many.weights, many.corners), (few.points, few.weights, few.corners));
}

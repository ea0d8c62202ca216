//! Points that crowd in one place, or in places far apart, by chance or on purpose.

use std::time::Instant;

use super::*;

/// Far more than any of them takes on a busy machine, and far less than comparing all points takes.
const LONGEST_S: u64 = 15;

#[test]
fn a_place_becomes_one_node() {
    let mut observed = cloud(1, 40, [0.1; 3]);
    observed.extend(observed.clone());
    // Held points stay.
    let mut capture = capture(observed, cloud(1, 40, [0.1; 3]), vec![[0.05; 3]; 500]);
    capture.sequences[0].controls = vec![[0.0; 3]];
    capture.object.pins = vec![HeldPoint { point: 40, control: 0 }];
    let sample = sample_nodes(&capture, &settings(1000), 0).unwrap();
    assert_eq!((sample.node_count(), sample.left_out.coincident), (42, 39 + 40 + 499));
    assert_eq!(sample.pins.len(), 1);
    // The skin has every point that is followed.
    assert_eq!(sample.surface.positions.len(), 120);
    // What lies apart in the undeformed shape does not coincide.
    capture.object.rest_points = cloud(2, 80, [0.1; 3]);
    let sample = sample_nodes(&capture, &settings(1000), 0).unwrap();
    assert_eq!(sample.left_out.coincident, 499);
}

#[test]
fn a_million_points_in_one_place_are_sampled_quickly() {
    let start = Instant::now();
    let crowd = capture(vec![[0.1, 0.2, 0.3]; 500_000], vec![], vec![[0.1; 3]; 500_000]);
    let sample = sample_nodes(&crowd, &settings(1000), 0).unwrap();
    assert_eq!((sample.node_count(), sample.left_out.coincident), (2, 999_998));
    assert!(start.elapsed().as_secs() < LONGEST_S, "{:?}", start.elapsed());
}

/// 80,000 nodes with all their neighbours in the same heap, and nodes too near to each other for springs.
#[test]
fn heaps_far_apart_are_joined_quickly() {
    let start = Instant::now();
    let side = |i: usize, n: usize| 0.01 * i as f32 / n as f32;
    let heap = |x: f32, scale: f32| {
        let place = move |i: usize| [side(i % 40, 1), side(i / 40 % 40, 1), side(i / 1600, 1)];
        (0..40_000).map(move |i| place(i).map(|c| c * scale)).map(move |[a, b, c]| [a + x, b, c])
    };
    for scale in [1.0, 1e-4] {
        let mut sample = sample_nodes(
            &capture(heap(0.0, scale).chain(heap(1e3, 1.0)).collect(), vec![], vec![]),
            &settings(usize::MAX),
            0,
        )
        .unwrap();
        sample.spacing_scale = 1.0;
        let graph = connect(&sample, &Connectivity::from_settings(&settings(1000), false));
        assert_eq!(pieces(&graph), 1);
    }
    assert!(start.elapsed().as_secs() < LONGEST_S, "{:?}", start.elapsed());
}

use super::*;

fn clock(count: usize, start: f64) -> Vec<f64> {
    (0..count).map(|i| start + i as f64 / 30.0).collect()
}

#[test]
fn gaps_of_the_reference_become_frames() {
    let mut times = clock(10, 100.0);
    times.drain(4..6);
    let other = clock(7, 100.01);
    let aligned = align(&[times, other], 100).unwrap();
    assert_eq!(aligned.times_s.len(), 10);
    assert!((aligned.fps - 30.0).abs() < 1e-6);
    let expected =
        [Some(0), Some(1), Some(2), Some(3), None, None, Some(4), Some(5), Some(6), Some(7)];
    assert_eq!(aligned.images[0], expected);
    // What the other camera saw in the gap has its frames.
    let other: Vec<_> = (0..7).map(Some).chain([None]).collect();
    assert_eq!(aligned.images[1][..8], other);
}

#[test]
fn images_before_and_after_belong_to_no_frame() {
    let aligned = align(&[clock(10, 0.0), clock(9, -0.2)], 100).unwrap();
    assert_eq!(aligned.images[1][..4], [Some(6), Some(7), Some(8), None]);
}

#[test]
fn an_image_that_is_repeated_counts_once() {
    let mut times = clock(5, 0.0);
    times.insert(2, times[2]);
    let aligned = align(&[times, clock(5, 0.002)], 100).unwrap();
    assert_eq!(aligned.times_s.len(), 5);
    assert_eq!(aligned.images[0], [0, 1, 2, 4, 5].map(Some));
}

#[test]
fn absurd_clocks_are_refused() {
    assert!(align(&[vec![0.0, 1.0, 2.0, 1e15]], 100).is_err());
    assert!(align(&[vec![5.0]], 100).is_err());
    assert!(align(&[vec![5.0, 5.0]], 100).is_err());
    assert!(align(&[], 100).is_err());
}

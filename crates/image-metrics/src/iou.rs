//! Overlap of masks.

/// Intersection over union of two masks of one size, 0 to 1, over the pixels that `valid` has; over
/// all without. 1 if both are empty there. Entries beyond the shortest array do not count.
pub fn iou(a: &[bool], b: &[bool], valid: Option<&[bool]>) -> f64 {
    let (mut both, mut any) = (0u64, 0u64);
    for (pixel, (a, b)) in a.iter().zip(b).enumerate() {
        if valid.is_none_or(|valid| valid.get(pixel) == Some(&true)) {
            both += u64::from(*a && *b);
            any += u64::from(*a || *b);
        }
    }
    if any == 0 { 1.0 } else { both as f64 / any as f64 }
}

#[test]
fn overlap_counts_valid_pixels() {
    let (a, b) = ([true, true, false, false], [false, true, true, false]);
    assert!((iou(&a, &b, None) - 1.0 / 3.0).abs() < 1e-12);
    assert_eq!(iou(&a, &b, Some(&[false, true, false, true])), 1.0);
    assert_eq!(iou(&a, &b, Some(&[true, false, false, true])), 0.0);
    assert_eq!(iou(&[false; 4], &[false; 4], None), 1.0);
}

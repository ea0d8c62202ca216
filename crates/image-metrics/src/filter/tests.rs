use super::*;

fn at(plane: &Plane, x: isize, y: isize, border: Border) -> f32 {
    let (w, h) = (plane.width as isize, plane.height as isize);
    if border == Border::Zero && !((0..w).contains(&x) && (0..h).contains(&y)) {
        return 0.0;
    }
    plane.values[(y.clamp(0, h - 1) * w + x.clamp(0, w - 1)) as usize]
}

#[test]
fn separable_filters_are_the_sum_over_the_window() {
    let (a, b) = ([0.5, -1.0, 2.0, 0.25, 3.0], [1.0, 0.0, -0.5]);
    // Also planes that are smaller than the kernels.
    for (width, height) in [(7, 6), (2, 9), (1, 1), (9, 1)] {
        let plane = Plane::from_fn(width, height, |p| ((p * 37 + 11) % 17) as f32 / 16.0);
        for border in [Border::Zero, Border::Nearest] {
            let fast = separable(&plane, &a, &b, border);
            for p in 0..width * height {
                let (x, y) = ((p % width) as isize, (p / width) as isize);
                let mut sum = 0.0;
                for (j, weight_y) in (-1..=1).zip(b) {
                    for (i, weight_x) in (-2..=2).zip(a) {
                        sum += weight_x * weight_y * at(&plane, x + i, y + j, border);
                    }
                }
                let found = fast.values[p];
                assert!(
                    (sum - found).abs() < 1e-5,
                    "{width}x{height} {border:?} {p}: {sum} {found}"
                );
            }
        }
    }
}

#[test]
fn gaussians_sum_up_to_one() {
    let kernel = gaussian(1.5, 5);
    assert_eq!(kernel.len(), 11);
    assert!((kernel.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    assert!((kernel[4] / kernel[5] - (-0.5f32 / 2.25).exp()).abs() < 1e-6);
}

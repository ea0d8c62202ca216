//! Values of scikit-image 0.26 for the same pixels: `structural_similarity(a, b, channel_axis=-1,
//! gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, full=True)`, mean of
//! the full map. It mirrors at the border; where that is black, so is what lies beyond.

use proptest::prelude::*;

use super::*;
use crate::{
    Image, Whole,
    test_images::{Scene, smooth, tiles},
};

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 2e-6, "{found} instead of {expected}");
}

#[test]
fn values_are_those_of_scikit_image() {
    close(ssim(&tiles().pair(None)), 0.811_216_061);
    close(crate::psnr(&tiles().pair(None)), 15.216_831_492);
    assert!((crate::psnr(&smooth().pair(None)) - 15.881_307_386).abs() < 1e-5);
}

#[test]
fn values_are_those_of_the_definition() {
    // Every window written out, in f64.
    let Scene { width, height, a, b } = smooth();
    let (w, h) = (i64::from(width), i64::from(height));
    let weight = |d: i64| (-(d * d) as f64 / 4.5).exp();
    let total: f64 = (-5..=5).map(weight).sum::<f64>().powi(2);
    let mut sum = 0.0;
    for p in 0..w * h {
        for c in 0..3 {
            let (mut mx, mut my, mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (dy, dx) in (-5..=5).flat_map(|dy| (-5..=5).map(move |dx| (dy, dx))) {
                let (x, y) = (p % w + dx, p / w + dy);
                if (0..w).contains(&x) && (0..h).contains(&y) {
                    let q = (y * w + x) as usize;
                    let share = weight(dx) * weight(dy) / total;
                    let (u, v) = (f64::from(a[q][c]), f64::from(b[q][c]));
                    (mx, my) = (mx + share * u, my + share * v);
                    (xx, yy, xy) = (xx + share * u * u, yy + share * v * v, xy + share * u * v);
                }
            }
            let (vx, vy, vxy) = (xx - mx * mx, yy - my * my, xy - mx * my);
            sum += (2.0 * mx * my + 1e-4) * (2.0 * vxy + 9e-4)
                / ((mx * mx + my * my + 1e-4) * (vx + vy + 9e-4));
        }
    }
    close(ssim(&smooth().pair(None)), sum / (3 * w * h) as f64);
}

#[test]
fn gradient_is_the_slope() {
    let Scene { width, height, a, b } = smooth();
    let valid: Vec<bool> = (0..a.len()).map(|p| p % 60 > 3).collect();
    let value = |pixels: &[[f32; 3]]| {
        let image = |pixels| Image::new(width, height, pixels).unwrap();
        ssim(&Pair::new(image(pixels), image(&b), Some(&valid)).unwrap())
    };
    let scene = Scene { width, height, a: a.clone(), b: b.clone() };
    let (found, gradient) = ssim_with_gradient(&scene.pair(Some(&valid)));
    assert_eq!(found, ssim(&scene.pair(Some(&valid))));
    // Along the gradient, and along a direction that has nothing to do with it.
    let unit = |direction: Vec<[f64; 3]>| {
        let length = direction.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        direction.into_iter().map(|d| d.map(|v| v / length)).collect::<Vec<_>>()
    };
    let slopes: Vec<[f64; 3]> = gradient.iter().map(|g| g.map(f64::from)).collect();
    let waves = (0..a.len()).map(|p| [0.3, 0.7, 1.1].map(|f| (p as f64 * f).sin())).collect();
    for direction in [unit(slopes.clone()), unit(waves)] {
        let moved = |step: f64| -> Vec<[f32; 3]> {
            let shifted = |(x, d): (&[f32; 3], &[f64; 3])| {
                std::array::from_fn(|c| (f64::from(x[c]) + step * d[c]) as f32)
            };
            a.iter().zip(&direction).map(shifted).collect()
        };
        let step = 0.1;
        let measured = (value(&moved(step)) - value(&moved(-step))) / (2.0 * step);
        let given: f64 =
            slopes.iter().flatten().zip(direction.iter().flatten()).map(|(g, d)| g * d).sum();
        assert!((measured - given).abs() < 5e-3 * given.abs() + 2e-6, "{measured} {given}");
    }
    let ignored = gradient.iter().zip(&valid).filter(|(_, valid)| !**valid);
    assert!(ignored.clone().count() > 0 && ignored.clone().all(|(g, _)| *g == [0.0; 3]));
}

#[test]
fn gradient_of_each_pixel_is_the_slope() {
    let Scene { width, height, a, b } = tiles();
    let scene = Scene { width, height, a: a.clone(), b: b.clone() };
    let (_, gradient) = ssim_with_gradient(&scene.pair(None));
    for (pixel, channel) in [(0, 0), (20 * 48 + 20, 1), (7 * 48 + 7, 2), (33 * 48 + 41, 0)] {
        let value = |step: f32| {
            let mut moved = a.clone();
            moved[pixel][channel] += step;
            ssim(&Scene { width, height, a: moved, b: b.clone() }.pair(None))
        };
        let step = 1e-2;
        let measured = (value(step) - value(-step)) / f64::from(2.0 * step);
        let given = f64::from(gradient[pixel][channel]);
        assert!((measured - given).abs() < 0.02 * given.abs() + 1e-7, "{measured} {given}");
    }
}

#[test]
fn a_crop_predicts_the_score_of_its_image() {
    // The tiles have 6 black pixels on each side; here are 20 more.
    let small = tiles();
    let (width, height) = (small.width + 40, small.height + 40);
    let grown = |pixels: &[[f32; 3]]| {
        let mut large = vec![[0.0; 3]; (width * height) as usize];
        for (y, row) in pixels.chunks(small.width as usize).enumerate() {
            let start = (y + 20) * width as usize + 20;
            large[start..start + row.len()].copy_from_slice(row);
        }
        large
    };
    let large = Scene { width, height, a: grown(&small.a), b: grown(&small.b) };
    let (small, large) = (small.pair(None), large.pair(None));
    let whole = Whole::new(small.pixel_count(), large.pixel_count()).unwrap();
    close(whole.ssim(ssim(&small)), ssim(&large));
    close(whole.psnr(crate::psnr(&small)), crate::psnr(&large));
    assert!((whole.flip(crate::flip(&small)) - crate::flip(&large)).abs() < 1e-3);
    assert!(Whole::new(0, 9).is_err() && Whole::new(10, 9).is_err());
}

proptest! {
    #[test]
    fn similarity_is_symmetric_and_bounded(
        width in 1u32..20,
        height in 1u32..20,
        seed in prop::collection::vec(0.0f32..1.0, 16),
    ) {
        let color = |p: u32, k: u32| seed[((p * 7 + k * 5 + p * p % 13) % 16) as usize];
        let pixels = |k| (0..width * height).map(|p| [color(p, k), color(p, k + 1), color(p, k + 2)]).collect();
        let scene = Scene { width, height, a: pixels(0), b: pixels(3) };
        let there = ssim(&scene.pair(None));
        let back = ssim(&Scene { width, height, a: scene.b.clone(), b: scene.a.clone() }.pair(None));
        prop_assert!((there - back).abs() < 1e-6);
        prop_assert!((-1.0..=1.0 + 1e-6).contains(&there));
        let same = Scene { width, height, a: scene.a.clone(), b: scene.a };
        let (one, gradient) = ssim_with_gradient(&same.pair(None));
        prop_assert!((one - 1.0).abs() < 1e-6);
        prop_assert!(gradient.iter().flatten().all(|g| g.abs() < 1e-4));
    }
}

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::target::Rectangle;

/// The gradient is the directional derivative of the loss.
#[test]
fn the_derivative_is_that_of_finite_differences() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (width, height) = (24, 20);
    let count = width as usize * height as usize;
    let mut image = Image::black(width, height);
    let area = Rectangle { corner: [0, 0], size: [width, height] };
    let mut target = Target {
        area,
        colors: vec![[0.0; 3]; count],
        object: vec![false; count],
        valid: vec![true; count],
        depth_m: vec![0.0; count],
    };
    for pixel in 0..count {
        image.color[pixel] = std::array::from_fn(|_| rng.random());
        image.alpha[pixel] = rng.random_range(0.1..0.9);
        image.depth_m[pixel] = image.alpha[pixel] * rng.random_range(0.8..1.2);
        target.valid[pixel] = rng.random_bool(0.9);
        target.object[pixel] = rng.random_bool(0.6);
        if target.object[pixel] && target.valid[pixel] {
            target.colors[pixel] = std::array::from_fn(|_| rng.random());
            target.depth_m[pixel] = 1.0;
        }
    }
    let (_, bar) = loss(&image, &target).unwrap();
    let along: Vec<[f32; 5]> =
        (0..count).map(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0))).collect();
    let moved = |step: f32| {
        let mut image = image.clone();
        for (pixel, along) in along.iter().enumerate() {
            (0..3).for_each(|c| image.color[pixel][c] += step * along[c]);
            image.alpha[pixel] += step * along[3];
            image.depth_m[pixel] += step * along[4];
        }
        loss(&image, &target).unwrap().0
    };
    let step = 1e-4;
    let measured = (moved(step) - moved(-step)) / f64::from(2.0 * step);
    let product = |pixel: usize| {
        let [r, g, b, alpha, depth] = along[pixel];
        let color: f32 = [r, g, b].iter().zip(bar.color[pixel]).map(|(a, b)| a * b).sum();
        f64::from(color + alpha * bar.alpha[pixel] + depth * bar.depth_m[pixel])
    };
    let expected: f64 = (0..count).map(product).sum();
    assert!((measured - expected).abs() < 0.02 * expected.abs() + 1e-4, "{measured} {expected}");
}

#[test]
fn hands_do_not_count_and_a_perfect_rendering_has_no_loss() {
    let area = Rectangle { corner: [0, 0], size: [8, 8] };
    let target = Target {
        area,
        colors: vec![[0.2, 0.4, 0.6]; 64],
        object: vec![true; 64],
        valid: vec![true; 64],
        depth_m: vec![0.8; 64],
    };
    let mut image = Image::black(8, 8);
    image.color.fill([0.2, 0.4, 0.6]);
    image.alpha.fill(1.0);
    image.depth_m.fill(0.8);
    assert!(loss(&image, &target).unwrap().0.abs() < 1e-6);
    image.color[9] = [1.0; 3];
    assert!(loss(&image, &target).unwrap().0 > 1e-3);
    let mut hidden = target;
    hidden.valid[9] = false;
    hidden.colors[9] = [0.0; 3];
    let (none, bar) = loss(&image, &hidden).unwrap();
    assert!(none.abs() < 1e-6, "{none}");
    assert_eq!((bar.color[9], bar.alpha[9], bar.depth_m[9]), ([0.0; 3], 0.0, 0.0));
}

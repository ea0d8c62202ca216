//! Values of `flip_evaluator` 1.7 (its authors' program, from PyPI) for the same pixels:
//! `flip_evaluator.evaluate(b, a, "LDR", inputsRGB=True, applyMagma=False)`.

use super::*;
use crate::test_images::{Scene, smooth, tiles};

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-4, "{found} instead of {expected}");
}

#[test]
fn values_are_those_of_the_authors_program() {
    let tiles = tiles();
    close(flip(&tiles.pair(None)), 0.184_613_9);
    let map = flip_map(&tiles.pair(None));
    close(map[20 * tiles.width as usize + 20].into(), 0.239_351_6);
    close(map.iter().copied().fold(0.0, f32::max).into(), 0.757_121_4);

    let smooth = smooth();
    close(flip(&smooth.pair(None)), 0.243_110_6);
    let map = flip_map(&smooth.pair(None));
    close(map[20 * smooth.width as usize + 20].into(), 0.386_745_6);
    close(map.iter().copied().fold(0.0, f32::max).into(), 0.966_285_5);
}

#[test]
fn equal_images_do_not_differ_and_opposite_ones_do_entirely() {
    let Scene { width, height, a, .. } = smooth();
    let same = Scene { width, height, b: a.clone(), a };
    assert_eq!(flip(&same.pair(None)), 0.0);
    let count = (width * height) as usize;
    let (a, b) = (vec![[0.0, 1.0, 0.0]; count], vec![[0.0, 0.0, 1.0]; count]);
    close(flip(&Scene { width, height, a, b }.pair(None)), 1.0);
}

#[test]
fn the_order_of_images_does_not_matter() {
    let Scene { width, height, a, b } = tiles();
    let forward = flip(&Scene { width, height, a: a.clone(), b: b.clone() }.pair(None));
    let backward = flip(&Scene { width, height, a: b, b: a }.pair(None));
    assert!((forward - backward).abs() < 1e-9);
}

#[test]
fn pixels_that_do_not_count_are_black() {
    let mut scene = tiles();
    let valid: Vec<bool> = (0..scene.a.len()).map(|p| p % 48 < 30).collect();
    let masked = flip(&scene.pair(Some(&valid)));
    scene.black_out(&valid);
    assert_eq!(flip(&scene.pair(None)), masked);
}

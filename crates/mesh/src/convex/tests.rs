use super::*;
use crate::shapes::{cuboid, merged, sphere};

#[test]
fn the_visible_upper_half_of_a_ball_is_filled() {
    let mut shell = sphere(5).vertices;
    shell.retain(|p| p[2] > -0.1);
    let filled = convex_interior(&shell, 0.1).unwrap();
    let expected = 2.0 / 3.0 * std::f64::consts::PI * 1.15 / 1e-3;
    let share = filled.len() as f64 / expected;
    assert!((0.6..1.1).contains(&share), "{share}");
    let inside = |p: &Point| p.iter().map(|x| x * x).sum::<f32>() < 1.0 && p[2] > -0.12;
    assert!(filled.iter().all(inside));
}

#[test]
fn the_space_between_limbs_stays_empty() {
    // The letter U.
    let mesh = merged(&[
        cuboid([0.0, 0.0, 0.0], [0.1, 0.02, 0.02]),
        cuboid([0.0, 0.0, 0.0], [0.02, 0.1, 0.02]),
        cuboid([0.08, 0.0, 0.0], [0.1, 0.1, 0.02]),
    ]);
    let cloud = mesh.sample_surface(0.003, 0).unwrap();
    let filled = convex_interior(&cloud, 0.005).unwrap();
    let between = |p: &&Point| p[0] > 0.025 && p[0] < 0.075 && p[1] > 0.025;
    let wrong = filled.iter().filter(between).count() as f64 / filled.len() as f64;
    assert!(filled.len() > 200, "{}", filled.len());
    assert!(wrong < 0.03, "{wrong}");
}

#[test]
fn clouds_that_enclose_nothing_give_nothing() {
    assert!(convex_interior(&[], 0.01).unwrap().is_empty());
    assert!(convex_interior(&[[f32::NAN; 3]], 0.01).unwrap().is_empty());
    assert!(convex_interior(&[[1.0; 3]; 100], 0.01).unwrap().is_empty());
    let sheet: Vec<Point> =
        (0..900).map(|i| [(i % 30) as f32 * 0.01, (i / 30) as f32 * 0.01, 0.0]).collect();
    assert!(convex_interior(&sheet, 0.01).unwrap().is_empty());
}

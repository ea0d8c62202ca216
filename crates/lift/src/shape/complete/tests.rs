use super::*;

fn grid(step_m: f32, z: f32) -> Vec<Point> {
    (0..400).map(|i| [(i % 20) as f32 * step_m, (i / 20) as f32 * step_m, z]).collect()
}

#[test]
fn observed_goes_before_surface_before_interior() {
    let observed: Vec<Point> = grid(0.005, 0.0).into_iter().filter(|p| p[0] < 0.05).collect();
    let shape = Shape { surface: grid(0.006, 0.0), interior: grid(0.006, 0.004) };
    let settings = CompletionSettings { spacing_m: 0.0055, ..CompletionSettings::default() };
    let full = complete(&observed, &shape, &settings);
    assert!(!full.surface.is_empty() && full.surface.iter().all(|p| p[0] > 0.046 || p[1] > 0.096));
    let near = |p: &Point, others: &[Point]| {
        others.iter().filter(|q| crate::rigid::distance(*p, **q) <= 0.0055).count()
    };
    assert!(full.interior.iter().all(|p| near(p, &full.surface) == 0 && near(p, &observed) == 0));
    assert!(full.surface.iter().all(|p| near(p, &full.surface) == 1));
    let few = CompletionSettings { max_points: 7, ..settings };
    assert_eq!(complete(&observed, &shape, &few).surface.len(), 7);
}

#[test]
fn points_that_are_not_finite_are_left_out() {
    let shape = Shape { surface: vec![[f32::NAN; 3], [0.1; 3]], interior: Vec::new() };
    let full = complete(&[], &shape, &CompletionSettings::default());
    assert_eq!(full.surface, [[0.1; 3]]);
}

use super::*;
use crate::shapes::{creature, sphere};

#[test]
fn a_ball_is_filled_to_its_volume() {
    let spacing = 0.08;
    let points = sphere(4).sample_interior(spacing).unwrap();
    // Half a spacing below the surface.
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.96_f64.powi(3);
    let filled = points.len() as f64 * 0.08_f64.powi(3);
    assert!((filled / volume - 1.0).abs() < 0.03, "{filled} of {volume}");
    let radius = |p: &Point| p.iter().map(|x| x * x).sum::<f32>().sqrt();
    assert!(points.iter().all(|p| radius(p) < 0.961));
}

#[test]
fn parts_thinner_than_the_spacing_stay_empty() {
    assert!(creature().sample_interior(0.2).unwrap().is_empty());
}

#[test]
fn absurd_spacings_are_refused() {
    for spacing in [0.0, -1.0, f32::NAN, 1e-9] {
        assert!(matches!(sphere(1).sample_interior(spacing), Err(Error::Spacing { .. })));
    }
}

/// Seen from between them, no layer counts as far away.
#[test]
fn layers_of_triangles_in_one_place_are_given_up() {
    let mut mesh = sphere(1);
    let most = 10_000_000;
    assert!(!mesh.interior_within(0.1, most).unwrap().is_empty());
    mesh.triangles = mesh.triangles.repeat(2000);
    let error = mesh.interior_within(0.1, most).unwrap_err();
    let all = mesh.triangles.len();
    assert!(matches!(error, Error::Layers { triangles } if triangles == all), "{error}");
}

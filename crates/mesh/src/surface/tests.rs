use super::*;
use crate::{Bvh, shapes::sphere, vec3};

#[test]
fn samples_lie_on_the_surface_apart_and_without_gaps() {
    let mesh = sphere(4);
    let samples = mesh.sample_surface(0.1, 3).unwrap();
    let bvh = Bvh::new(&mesh);
    assert!(samples.iter().all(|p| bvh.closest(*p).unwrap().distance < 1e-5));
    for (i, p) in samples.iter().enumerate() {
        let others = samples[..i].iter().map(|q| (vec3(*p) - vec3(*q)).norm());
        assert!(others.fold(f64::INFINITY, f64::min) > 0.0999);
    }
    // Every vertex has a sample near it.
    for v in &mesh.vertices {
        let nearest = samples.iter().map(|q| (vec3(*v) - vec3(*q)).norm()).fold(9.0, f64::min);
        assert!(nearest < 0.2, "a gap of {nearest}");
    }
    let discs = mesh.area() / 0.01;
    let density = samples.len() as f64 / discs;
    assert!((0.55..0.9).contains(&density), "density {density}");
}

#[test]
fn a_seed_repeats() {
    let mesh = sphere(2);
    assert_eq!(mesh.sample_surface(0.2, 1).unwrap(), mesh.sample_surface(0.2, 1).unwrap());
    assert_ne!(mesh.sample_surface(0.2, 1).unwrap(), mesh.sample_surface(0.2, 2).unwrap());
}

#[test]
fn absurd_spacings_are_refused() {
    for spacing in [0.0, -1.0, f32::NAN, 1e-9] {
        assert!(matches!(sphere(1).sample_surface(spacing, 0), Err(Error::Spacing { .. })));
    }
}

use nalgebra::Rotation3;

use super::*;
use crate::{point, shapes::creature};

/// The points of a moved mesh that a camera in a direction sees, roughly: those of faces turned
/// towards it.
fn seen(mesh: &Mesh, truth: &Similarity, directions: &[Vec3]) -> Vec<Point> {
    let bvh = Bvh::new(mesh);
    let samples = mesh.sample_surface(0.004, 5).unwrap();
    let faces = |p: &&Point| {
        let normal = Vec3::from(bvh.closest(**p).unwrap().normal);
        directions.iter().any(|d| normal.dot(d) > 0.3)
    };
    samples.iter().filter(faces).map(|p| truth.apply(*p)).collect()
}

fn similarity(axis: [f64; 3], scale: f64) -> Similarity {
    let rotation = Rotation3::new(Vec3::from(axis)).into_inner();
    Similarity::new(rotation, scale, Vec3::new(0.4, -0.2, 1.3))
}

fn worst_error(mesh: &Mesh, found: &Similarity, truth: &Similarity) -> f64 {
    let distance = |v: &Point| (found.map(vec3(*v)) - truth.map(vec3(*v))).norm();
    mesh.vertices.iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn a_partly_seen_body_is_found_in_any_pose_and_size() {
    let mesh = creature();
    let from = [Vec3::new(0.5, 0.2, 1.0), Vec3::new(-0.8, 0.6, 0.4)].map(|d| d.normalize());
    for (axis, scale) in [([0.0, 0.0, 0.0], 1.0), ([2.0, 0.5, -1.0], 0.01), ([0.3, -1.8, 1.2], 7.0)]
    {
        let truth = similarity(axis, scale);
        let aligned = align(&mesh, &seen(&mesh, &truth, &from)).unwrap();
        let error = worst_error(&mesh, &aligned.similarity, &truth) / scale;
        assert!(error < 0.004, "{error} of 0.2 at {axis:?}, {scale}");
        assert!(aligned.inlier_share > 0.97);
    }
}

#[test]
fn outliers_do_not_pull() {
    let mesh = creature();
    let truth = similarity([1.0, 1.0, 0.0], 1.0);
    let from = [Vec3::z(), Vec3::new(0.8, 0.5, 0.3).normalize()];
    let mut observed = seen(&mesh, &truth, &from);
    let count = observed.len();
    for i in (0..count).step_by(12) {
        let p = vec3(observed[i]) + Vec3::new(0.02, 0.05, -0.03) * (i as f64 / count as f64);
        observed.push(point(p));
    }
    observed.push([f32::NAN; 3]);
    let aligned = align(&mesh, &observed).unwrap();
    assert!(worst_error(&mesh, &aligned.similarity, &truth) < 0.006);
}

#[test]
fn another_body_is_no_alignment() {
    let mesh = crate::shapes::sphere(3);
    let truth = similarity([0.0; 3], 1.0);
    let observed = seen(&creature(), &truth, &[Vec3::z(), Vec3::x(), Vec3::y()]);
    assert!(matches!(align(&mesh, &observed), Err(Error::NotAligned { .. })));
}

#[test]
fn a_few_points_are_too_few() {
    assert!(matches!(align(&creature(), &[[0.0; 3]; 5]), Err(Error::TooFewPoints { .. })));
    // All at one place.
    assert!(align(&creature(), &[[0.0; 3]; 500]).is_err());
}

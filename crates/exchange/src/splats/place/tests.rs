use bendtwin_core::{Graph, NodeKind, Problem};
use bendtwin_graph::bind_skin;
use nalgebra::Vector3;

use super::*;
use crate::testing;

/// The point of a body in a direction: of three lengths, with two limbs, so that no turn brings it
/// onto itself.
fn surface(direction: Vector3<f64>) -> Vector3<f64> {
    let limb = |x: f64, y: f64, z: f64| {
        let square = (direction - Vector3::new(x, y, z).normalize()).norm_squared();
        (-square / 0.12).exp()
    };
    let radius = 1.0 + 0.9 * limb(0.6, 0.7, 0.4) + 0.6 * limb(-0.8, 0.3, -0.5);
    0.06 * radius * direction.component_mul(&Vector3::new(1.0, 0.7, 0.5))
}

/// The direction outwards of the surface in a direction.
fn normal(direction: Vector3<f64>) -> Vector3<f64> {
    let across = direction.cross(&Vector3::new(0.3, -0.5, 0.8)).normalize();
    let other = direction.cross(&across);
    let slope = |way: Vector3<f64>| {
        surface((direction + 1e-4 * way).normalize())
            - surface((direction - 1e-4 * way).normalize())
    };
    let out = slope(across).cross(&slope(other)).normalize();
    out * out.dot(&direction).signum()
}

/// Directions spread evenly over a sphere, along a spiral.
fn directions(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (angle, r) = (2.399_963 * i as f64, (1.0 - z * z).sqrt());
        Vector3::new(r * angle.cos(), r * angle.sin(), z)
    })
}

fn point(v: Vector3<f64>) -> Point {
    v.map(|x| x as f32).into()
}

/// A twin of the lumpy body.
fn lumpy() -> Twin {
    let shells = [1.0, 0.5].into_iter().flat_map(|s| directions(60).map(move |d| s * surface(d)));
    let rest_positions: Vec<Point> = shells.map(point).collect();
    let n = rest_positions.len();
    let graph = Graph {
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        springs: (1..n as u32).map(|i| [i - 1, i]).collect(),
        rest_positions,
        ..Graph::default()
    };
    let skin = SurfacePoints {
        positions: directions(700).map(|d| point(surface(d))).collect(),
        observed_points: vec![Graph::NOT_OBSERVED; 700],
    };
    Twin { skin: bind_skin(&graph, &skin), graph, ..testing::twin() }
}

/// A scan of the body by another program: flat Gaussians on its surface, in its own unit, axes and
/// place, and strays around it.
fn scan(from_twin: impl Fn(Vector3<f64>) -> Vector3<f64>, scale: f64) -> Gaussians {
    let mut gaussians = Gaussians::default();
    let strays = directions(150).map(|d| 2.5 * surface(d));
    for (at, out) in directions(1500).map(|d| (surface(d), normal(d))).chain(strays.map(|s| (s, s)))
    {
        // Thin along the way outwards.
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &out)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 3.1));
        let [x, y, z, w] = *turn.coords.as_ref();
        gaussians.means_m.push(point(from_twin(at)));
        gaussians.scales_m.push([0.003, 0.003, 0.0005].map(|s| (s * scale) as f32));
        gaussians.rotations.push([x as f32, y as f32, z as f32, w as f32]);
        gaussians.opacities.push(0.8);
        gaussians.colors.push([0.5; 3]);
    }
    gaussians
}

#[test]
fn a_scan_of_unknown_size_pose_and_place_is_found() {
    let twin = lumpy();
    for (axis, angle, scale) in [
        (Vector3::new(1.0, 2.0, -0.5), 2.2, 12.5),
        (Vector3::new(-1.0, 0.3, 0.4), 0.9, 0.2),
        (Vector3::new(0.0, 1.0, 0.0), 3.1, 1.0),
    ] {
        let turn = UnitQuaternion::new(angle * axis.normalize());
        let shift = Vector3::new(-0.4, 3.0, 1.5);
        let scanned = scan(|p| turn * (scale * p) + shift, scale);
        let placed = place(&scanned, &twin, None).unwrap();
        assert!((placed.similarity.scale * scale - 1.0).abs() < 0.02, "{:?}", placed.similarity);
        // Each point of the scan is back where it was on the body of 15 cm.
        let off = scanned.means_m.iter().zip(directions(1500)).map(|(mean, direction)| {
            let found = Vector3::from(placed.similarity.apply(*mean)).cast::<f64>();
            (found - surface(direction)).norm()
        });
        let worst = off.fold(0.0, f64::max);
        assert!(worst < 6e-3, "{worst} m");
        assert_eq!((placed.splats.len(), placed.dropped), (1500, 150));
    }
}

#[test]
fn another_body_is_not_aligned() {
    let rod = |k: usize| Vector3::new(0.0, 0.0, 0.001 * k as f64);
    let mut gaussians = scan(|p| p, 1.0);
    for (k, mean) in gaussians.means_m.iter_mut().enumerate() {
        *mean = point(rod(k));
    }
    let error = place(&gaussians, &lumpy(), None).unwrap_err();
    assert_eq!(error.reason(), "SPLATS_NOT_ALIGNED", "{error}");
}

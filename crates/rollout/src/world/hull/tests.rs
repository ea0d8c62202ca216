use bendtwin_core::geometry::{length, sub};
use proptest::prelude::*;

use super::{Face, Fault, Point, cross, dot, hull, unit};

/// Distance of a point to the plane that is farthest from it [m].
fn distance(faces: &[Face], p: Point) -> f32 {
    let to = |f: &Face| f.normal.iter().zip(p).map(|(n, x)| n * x).sum::<f32>() - f.offset_m;
    faces.iter().map(to).fold(f32::MIN, f32::max)
}

fn cube(center: Point, half: f32) -> Vec<Point> {
    let sign = |i: usize, axis: usize| if i >> axis & 1 == 0 { -half } else { half };
    (0..8).map(|i| std::array::from_fn(|axis| center[axis] + sign(i, axis))).collect()
}

#[test]
fn a_cube_has_six_faces_however_many_points_are_on_it() {
    let mut points = cube([0.3, -0.2, 1.0], 0.05);
    // The middles of its faces, of its edges, and inside.
    for i in -2i32..=2 {
        for j in -2i32..=2 {
            let (u, v) = (0.025 * i as f32, 0.025 * j as f32);
            points.push([0.3 + u, -0.2 + v, 1.05]);
            points.push([0.25, -0.2 + u, 1.0 + v]);
            points.push([0.3 + 0.9 * u, -0.2 + 0.9 * v, 1.0]);
        }
    }
    let faces = hull(&points).unwrap();
    assert_eq!(faces.len(), 6, "{faces:?}");
    for face in &faces {
        let along = face.normal.iter().map(|x| x.abs()).fold(0.0f32, f32::max);
        assert!((along - 1.0).abs() < 1e-5, "{face:?}");
    }
    assert!((distance(&faces, [0.3, -0.2, 1.0]) + 0.05).abs() < 1e-5);
    assert!((distance(&faces, [0.3, -0.2, 1.15]) - 0.1).abs() < 1e-5);
}

#[test]
fn a_tetrahedron_has_four_faces() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = hull(&points).unwrap();
    assert_eq!(faces.len(), 4);
    let slant = 1.0 / 3.0f32.sqrt();
    assert!((distance(&faces, [1.0, 1.0, 1.0]) - 2.0 * slant).abs() < 1e-5);
    assert!(distance(&faces, [0.2, 0.2, 0.2]) < 0.0);
}

#[test]
fn a_prism_of_many_sides_is_one_up_to_the_limit_of_faces() {
    let prism = |sides: usize| -> Vec<Point> {
        let corner = |i: usize, z: f32| {
            let angle = std::f32::consts::TAU * i as f32 / sides as f32;
            [0.1 * angle.cos(), 0.1 * angle.sin(), z]
        };
        (0..sides).flat_map(|i| [corner(i, 0.0), corner(i, 0.2)]).collect()
    };
    assert_eq!(hull(&prism(126)).unwrap().len(), 128);
    assert_eq!(hull(&prism(127)), Err(Fault::TooManyFaces));
}

#[test]
fn what_has_no_volume_is_refused() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let tilted = square.map(|[x, y, _]| [x, y, 0.3 * x + 0.7 * y]);
    let line: Vec<Point> = (0..9).map(|i| [0.1 * i as f32, 0.2 * i as f32, 0.0]).collect();
    for points in [&square[..], &tilted, &line, &[[0.5; 3]; 4]] {
        assert_eq!(hull(points), Err(Fault::Flat), "{points:?}");
    }
}

/// Corners of the polytope that planes at a distance of 1 from the origin bound.
fn polytope(normals: &[[f64; 3]]) -> Vec<Point> {
    let mut corners = Vec::new();
    for i in 0..normals.len() {
        for j in 0..i {
            for k in 0..j {
                let [a, b, c] = [i, j, k].map(|i| normals[i]);
                // Cramer's rule for a x = b x = c x = 1.
                let sides = [cross(b, c), cross(c, a), cross(a, b)];
                let volume = dot(a, sides[0]);
                let corner: [f64; 3] =
                    std::array::from_fn(|axis| sides.iter().map(|s| s[axis]).sum::<f64>() / volume);
                if normals.iter().all(|n| dot(*n, corner) < 1.0 + 1e-9) {
                    corners.push(corner.map(|x| 0.1 * x as f32));
                }
            }
        }
    }
    corners
}

proptest! {
    /// Polytopes of many random faces have short edges, and corners near other faces: a few of their faces may be
    /// found again, with a tilt.
    #[test]
    fn polytopes_with_short_edges_have_not_many_more_faces(
        normals in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 12..32),
    ) {
        let mut normals: Vec<[f64; 3]> = normals
            .iter()
            .filter(|n| dot(**n, **n) > 0.01)
            .map(|n| unit(*n))
            .collect();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                normals.push(std::array::from_fn(|i| if i == axis { sign } else { 0.0 }));
            }
        }
        let corners = polytope(&normals);
        let faces = hull(&corners).unwrap();
        prop_assert!(faces.len() <= 2 * normals.len(), "{} of {}", faces.len(), normals.len());
        for corner in &corners {
            prop_assert!(distance(&faces, *corner) < 1e-5);
        }
        // A point that is well outside of one of the planes is outside of the hull.
        for normal in &normals {
            let outside = normal.map(|x| 0.11 * x as f32);
            prop_assert!(distance(&faces, outside) > 0.0);
        }
    }

    /// All points are within every face, and every face is held by at least three of them.
    #[test]
    fn points_are_within_and_faces_are_held(
        points in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 4..40),
        shift in prop::array::uniform3(-5.0f32..5.0),
    ) {
        let points: Vec<Point> =
            points.iter().map(|p| std::array::from_fn(|i| p[i] + shift[i])).collect();
        if let Ok(faces) = hull(&points) {
            prop_assert!(faces.len() >= 4);
            for p in &points {
                prop_assert!(distance(&faces, *p) < 1e-4);
            }
            for face in &faces {
                let held = points.iter().filter(|p| distance(&[*face], **p) > -2e-4).count();
                prop_assert!(held >= 3, "{face:?} is held by {held}");
            }
        }
    }

    /// The faces close around the points: along the way from their mean c to a point outside, which
    /// leaves the hull within R = max |p - c|, the distance to the plane of the face that it leaves by
    /// grows from -depth, the distance at c, by at least depth in every R.
    #[test]
    fn the_distance_grows_outside(
        points in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 4..40),
        squash in 0.01f32..1.0,
        ways in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 20),
        times in 1.01f32..20.0,
    ) {
        let points: Vec<Point> = points.iter().map(|p| [p[0], p[1], squash * p[2]]).collect();
        let Ok(faces) = hull(&points) else { return Ok(()) };
        let middle: Point =
            std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f32>() / points.len() as f32);
        let depth = -distance(&faces, middle);
        let radius = points.iter().map(|p| length(sub(*p, middle))).fold(0.0, f32::max);
        prop_assert!(depth > 0.0, "the mean is {depth} deep");
        for way in ways.iter().filter(|way| length(**way) > 0.1) {
            let scale = times * radius / length(*way);
            let far: Point = std::array::from_fn(|i| middle[i] + scale * way[i]);
            let least = (times - 1.0) * depth - 1e-4;
            prop_assert!(distance(&faces, far) >= least, "{far:?}: {}", distance(&faces, far));
        }
    }

    /// Grids have many points in a plane and many on a line.
    #[test]
    fn grids_are_boxes(
        counts in prop::array::uniform3(2usize..6),
        size in prop::array::uniform3(0.01f32..0.5),
        turn in 0.0f32..std::f32::consts::TAU,
    ) {
        let (sine, cosine) = turn.sin_cos();
        let mut points = Vec::new();
        for x in 0..counts[0] { for y in 0..counts[1] { for z in 0..counts[2] {
            let at = |i: usize, k: usize| size[i] * k as f32 / (counts[i] - 1) as f32;
            let p = [at(0, x), at(1, y), at(2, z)];
            points.push([cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1], p[2] - 3.0]);
        }}}
        prop_assert_eq!(hull(&points).unwrap().len(), 6);
    }
}

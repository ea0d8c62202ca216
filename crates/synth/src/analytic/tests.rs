use bendtwin_capture::raw::{Distortion, Intrinsics, Pose};

use super::*;

const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A camera at the origin that looks along z.
fn camera() -> Camera {
    Camera {
        name: "ahead".to_owned(),
        width: 21,
        height: 11,
        intrinsics: Intrinsics { fx: 20.0, fy: 20.0, cx: 10.0, cy: 5.0 },
        distortion: Distortion::None,
        poses: vec![Pose { rotation: UPRIGHT, translation: [0.0; 3] }],
        times_s: Vec::new(),
        fps: None,
    }
}

fn ahead(pixel: [f64; 2]) -> Ray {
    Ray::through(&camera(), pixel, 0, Precision::Double)
}

#[test]
fn a_sphere_is_met_on_its_near_side_and_not_behind_the_camera() {
    let at = |z| Primitive::Sphere { center: [0.0, 0.0, z], radius_m: 0.25 };
    assert_eq!(at(1.0).depth_m(&ahead([10.0, 5.0])), Some(0.75));
    assert_eq!(at(1.0).depth_m(&ahead([20.0, 5.0])), None);
    assert_eq!(at(-1.0).depth_m(&ahead([10.0, 5.0])), None);
}

#[test]
fn a_point_on_an_ellipsoid_is_one_from_its_centre() {
    let turned = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let bodies = Bodies(vec![(
        (),
        Primitive::Ellipsoid {
            center: [0.1, 0.0, 1.0],
            rotation: turned,
            half_axes_m: [0.2, 0.4, 0.5],
        },
    )]);
    let hit = bodies.hit(&ahead([13.0, 6.0])).unwrap();
    assert!((bendtwin_core::geometry::length(hit.local) - 1.0).abs() < 1e-12);
    // Its long axis y lies along the world's x.
    assert!(bodies.hit(&ahead([18.0, 5.0])).is_some());
    assert!(bodies.hit(&ahead([10.0, 10.0])).is_none());
}

#[test]
fn the_ground_is_seen_from_above_only() {
    let down = Ray { origin: [0.0, 0.0, 2.0], direction: [0.5, 0.0, -1.0] };
    assert_eq!(Primitive::Ground.depth_m(&down), Some(2.0));
    assert_eq!(down.at(2.0), [1.0, 0.0, 0.0]);
    let up = Ray { direction: [0.5, 0.0, 1.0], ..down };
    assert_eq!(Primitive::Ground.depth_m(&up), None);
}

#[test]
fn the_nearest_body_is_drawn() {
    let square = Primitive::Rectangle {
        center: [0.0, 0.0, 1.0],
        rotation: UPRIGHT,
        half_sides_m: [0.26; 2],
    };
    let ball = Primitive::Sphere { center: [0.0, 0.0, 0.5], radius_m: 0.06 };
    for precision in [Precision::Single, Precision::Double] {
        let view = Bodies(vec![('s', square), ('b', ball)]).view(&camera(), 0, precision);
        let drawn = view.image(|_, hit| hit.map_or('.', |h| h.body));
        let row: String = drawn.pixels[5 * 21..6 * 21].iter().collect();
        assert_eq!(row, ".....sssbbbbbsss.....");
        let mask = view.mask(|body| body == 'b');
        assert_eq!(mask.pixels.iter().filter(|shown| **shown).count(), 21);
        let columns = view.image(|[column, _], hit| hit.map(|h| (column, h.local[0], h.depth_m)));
        let (column, x, depth) = columns.pixels[5 * 21 + 6].unwrap();
        assert_eq!((column, depth), (6, 1.0));
        assert!((x + 0.2).abs() < 1e-6);
    }
}

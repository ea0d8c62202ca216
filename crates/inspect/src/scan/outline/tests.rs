use bendtwin_capture::raw::{Distortion, Image, Intrinsics, Pose};

use super::*;

const SIZE: [usize; 2] = [200, 150];

fn camera() -> Camera {
    let pose = Pose {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };
    Camera {
        name: "front".to_owned(),
        width: SIZE[0],
        height: SIZE[1],
        intrinsics: Intrinsics { fx: 190.0, fy: 190.0, cx: 99.5, cy: 74.5 },
        distortion: Distortion::None,
        poses: vec![pose],
        times_s: Vec::new(),
        fps: None,
    }
}

/// An image with something that is neither round nor in the middle.
fn drawn<P: Copy>(inside: P, outside: P, place: impl Fn([f64; 2]) -> [f64; 2]) -> Image<P> {
    let mut image = Image::filled(SIZE[0], SIZE[1], outside);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let [x, y] = place([(i % SIZE[0]) as f64, (i / SIZE[0]) as f64]);
        let body = ((x - 120.0) / 32.0).powi(2) + ((y - 80.0) / 20.0).powi(2) < 1.0;
        let head = (x - 95.0).hypot(y - 58.0) < 14.0;
        if body || head {
            *pixel = inside;
        }
    }
    image
}

fn measured(
    depth: impl Fn([f64; 2]) -> [f64; 2],
    color: impl Fn([f64; 2]) -> [f64; 2],
) -> OutlineFit {
    let mask = drawn(true, false, |at| at);
    let depth = drawn(0.6, 0.9, depth);
    let color = drawn([200, 90, 30], [90, 90, 90], color);
    let limits = OutlineThresholds::default();
    measure(&camera(), [Some(&mask), None], &depth, Some(&color), &limits).unwrap()
}

#[test]
fn images_on_one_grid_agree() {
    let fit = measured(|at| at, |at| at);
    assert!(fit.depth.declared_share > 0.95 && fit.depth.moved_px < 0.6, "{fit:?}");
    assert!(fit.color.unwrap().declared_share > 0.95 && fit.forward_share < 0.05, "{fit:?}");
}

#[test]
fn a_shift_is_measured_to_a_pixel() {
    let fit = measured(|[x, y]| [x - 5.0, y + 3.0], |at| at).depth;
    assert!(fit.share > fit.declared_share + 0.2, "{fit:?}");
    let [x, y] = fit.warp.shift_px;
    assert!((x - 5.0).abs() < 1.0 && (y + 3.0).abs() < 1.0, "{fit:?}");
}

#[test]
fn another_field_of_view_is_measured() {
    let wider = |[x, y]: [f64; 2]| [99.5 + 1.43 * (x - 99.5), 74.5 + 1.43 * (y - 74.5)];
    let fit = measured(wider, |at| at).depth;
    assert!(fit.share > 0.9 && (1.0 / fit.warp.scale - 1.43).abs() < 0.1, "{fit:?}");
}

#[test]
fn mirrored_images_are_recognised() {
    let mirrored = |[x, y]: [f64; 2]| [199.0 - x, y];
    let fit = measured(mirrored, |at| at).depth;
    assert_eq!(fit.warp.mirrored, [true, false]);
    let color = measured(|at| at, mirrored).color.unwrap();
    assert_eq!(color.warp.mirrored, [true, false]);
    assert!(color.share > color.declared_share + 0.4, "{color:?}");
}

#[test]
fn masks_on_another_grid_suit_colour_where_they_suit_depth() {
    let moved = |[x, y]: [f64; 2]| [x - 6.0, y];
    let fit = measured(moved, moved);
    assert!(fit.color_with_depth.unwrap() > fit.color.unwrap().declared_share + 0.1, "{fit:?}");
}

#[test]
fn disparities_step_the_other_way_and_nothing_has_no_outline() {
    let mask = drawn(true, false, |at| at);
    let limits = OutlineThresholds::default();
    let inverted = drawn(1.6, 1.1, |at| at);
    let fit = measure(&camera(), [Some(&mask), None], &inverted, None, &limits).unwrap();
    assert!(fit.forward_share > 0.95 && fit.color.is_none(), "{fit:?}");
    let empty = Mask::filled(SIZE[0], SIZE[1], false);
    assert!(measure(&camera(), [Some(&empty), None], &inverted, None, &limits).is_none());
}

#[test]
fn a_part_without_depth_says_nothing() {
    let mask = drawn(true, false, |at| at);
    let mut depth = drawn(0.6_f32, 0.9, |at| at);
    // A black glove: no depth on the left third of what the mask shows.
    for (i, z) in depth.pixels.iter_mut().enumerate() {
        if mask.pixels[i] && i % SIZE[0] < 105 {
            *z = 0.0;
        }
    }
    let fit = measure(&camera(), [Some(&mask), None], &depth, None, &Default::default()).unwrap();
    assert!(fit.depth.declared_share > 0.9 && fit.depth.moved_px < 1.0, "{fit:?}");
}

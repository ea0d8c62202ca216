use bendtwin_capture::raw::Image;

use super::*;

const WIDTH: usize = 30;
const HEIGHT: usize = 20;
const CAMERA: Intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 15.0, cy: 10.0 };

fn image<P: Copy>(pixel: impl Fn(usize, usize) -> P) -> Image<P> {
    let pixels = (0..WIDTH * HEIGHT).map(|i| pixel(i % WIDTH, i / WIDTH)).collect();
    Image { width: WIDTH, height: HEIGHT, pixels }
}

fn at(depth: &DepthImage, labels: &Image<Label>, pixel: [f32; 2]) -> Result<(Label, f64), Miss> {
    let scene = LabelledDepth {
        depth,
        labels,
        intrinsics: &CAMERA,
        masks: &MaskSettings::default(),
        lift: &LiftSettings::default(),
    };
    scene.at(pixel)
}

/// A plane that is steep to the camera, exactly.
fn plane(x: f64, y: f64) -> f64 {
    1.0 / (1.5 + 0.01 * (x - 15.0) - 0.005 * (y - 10.0))
}

fn millimetres(z: f64) -> f32 {
    ((z * 1e3).round() / 1e3) as f32
}

#[test]
fn depth_is_finer_than_its_rounding() {
    let depth = image(|x, y| millimetres(plane(x as f64, y as f64)));
    let labels = image(|_, _| Label::Object);
    let mut square = 0.0;
    for i in 0..200 {
        let (x, y) = (5.0 + 0.097 * f64::from(i), 6.0 + 0.041 * f64::from(i));
        let (label, z) = at(&depth, &labels, [x as f32, y as f32]).unwrap();
        assert_eq!(label, Label::Object);
        square += (z - plane(x, y)).powi(2);
    }
    // Rounding to millimetres alone is off by 0.29 mm.
    assert!((square / 200.0f64).sqrt() < 1.3e-4, "{}", (square / 200.0f64).sqrt());
}

#[test]
fn nothing_leaks_over_an_edge_or_from_an_outlier() {
    let depth = image(|x, _| match x {
        0..15 => 0.5,
        _ => 0.9,
    });
    // Both sides are in the mask.
    let labels = image(|_, _| Label::Object);
    for (x, z) in [(14.0, 0.5), (14.3, 0.5), (14.7, 0.9), (15.0, 0.9)] {
        let (_, found) = at(&depth, &labels, [x, 9.5]).unwrap();
        assert!((found - z).abs() < 1e-6, "{x}: {found}");
    }
    let spiked = image(|x, y| if (x, y) == (11, 9) { 0.505 } else { 0.5 });
    let (_, found) = at(&spiked, &labels, [10.4, 9.2]).unwrap();
    assert!((found - 0.5).abs() < 1e-4, "{found}");
}

#[test]
fn what_lies_off_the_masks_is_missed() {
    let depth = image(|_, _| 0.5);
    let labels = image(|x, _| match x {
        0..15 => Label::Object,
        15..20 => Label::Manipulator,
        _ => Label::None,
    });
    assert_eq!(at(&depth, &labels, [14.4, 9.0]).unwrap().0, Label::Object);
    assert_eq!(at(&depth, &labels, [14.6, 9.0]).unwrap().0, Label::Manipulator);
    assert_eq!(at(&depth, &labels, [19.6, 9.0]).unwrap_err(), Miss::OffMask);
    assert_eq!(at(&depth, &labels, [25.0, 9.0]).unwrap_err(), Miss::OffMask);
    for outside in [[-0.6, 3.0], [29.6, 3.0], [3.0, -0.6], [3.0, 1e9], [f32::NAN, 3.0]] {
        assert_eq!(at(&depth, &labels, outside).unwrap_err(), Miss::Outside, "{outside:?}");
    }
    assert!(at(&depth, &labels, [-0.2, -0.2]).is_ok());
}

#[test]
fn a_few_pixels_are_not_a_surface_and_a_line_is_one() {
    let depth = image(|_, _| 0.5);
    let spot = image(|x, y| if x == 10 && y == 10 { Label::Object } else { Label::None });
    assert_eq!(at(&depth, &spot, [10.0, 10.0]).unwrap_err(), Miss::Unsupported);
    let line = image(|x, _| if x == 10 || x == 11 { Label::Object } else { Label::None });
    assert!((at(&depth, &line, [10.2, 10.0]).unwrap().1 - 0.5).abs() < 1e-9);
}

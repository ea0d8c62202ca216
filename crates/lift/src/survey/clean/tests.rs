use bendtwin_capture::raw::Image;

use super::*;

const WIDTH: usize = 40;
const HEIGHT: usize = 30;
/// A millimetre a pixel at one metre.
const CAMERA: Intrinsics = Intrinsics { fx: 1000.0, fy: 1000.0, cx: 20.0, cy: 15.0 };

fn image<P: Copy>(pixel: impl Fn(usize, usize) -> P) -> Image<P> {
    let pixels = (0..WIDTH * HEIGHT).map(|i| pixel(i % WIDTH, i / WIDTH)).collect();
    Image { width: WIDTH, height: HEIGHT, pixels }
}

/// A patch at one metre before a wall at two.
fn patch(x: usize, y: usize) -> bool {
    (10..30).contains(&x) && (8..22).contains(&y)
}

fn wall(x: usize, y: usize) -> f32 {
    if patch(x, y) { 1.0 } else { 2.0 }
}

fn cleaned(depth: &DepthImage, object: &Mask, manipulator: Option<&Mask>) -> CleanMasks {
    clean(depth, Some(object), manipulator, &CAMERA, &MaskSettings::default())
}

fn is_object(cleaned: &CleanMasks, x: usize, y: usize) -> bool {
    cleaned.labels.get(x, y) == Some(Label::Object)
}

#[test]
fn a_clean_mask_does_not_change() {
    let result = cleaned(&image(wall), &image(patch), None);
    assert_eq!(result.object.kept, 20 * 14);
    assert_eq!(result.object.pixels, 20 * 14);
    assert_eq!(result.object.frames, 1);
    assert_eq!(result.object.empty_frames, 0);
    assert_eq!(result.manipulator, MaskCounts::default());
}

#[test]
fn flying_pixels_and_outliers_go() {
    // A column of pixels halfway to the wall, and one wild pixel in the middle.
    let depth = image(|x, y| match (x, y) {
        (29, _) if patch(x, y) => 1.4,
        (20, 15) => 0.5,
        _ => wall(x, y),
    });
    let result = cleaned(&depth, &image(patch), None);
    assert!(!is_object(&result, 29, 15) && !is_object(&result, 20, 15));
    assert!(is_object(&result, 28, 15) && is_object(&result, 19, 15));
    assert_eq!(result.object.flying, 14 + 1);
}

#[test]
fn background_in_the_mask_is_a_speck_or_flies() {
    // The mask is three pixels too wide on one side, and shows the wall there; elsewhere it has a
    // spot.
    let wide = image(|x, y| patch(x, y) || patch(x.saturating_sub(3), y) || (x < 2 && y < 2));
    let result = cleaned(&image(wall), &wide, None);
    assert_eq!(result.object.kept, 20 * 14 + 3 * 14, "a tenth of the object is no speck");
    let strict = MaskSettings { min_component: 0.2, ..MaskSettings::default() };
    let result = clean(&image(wall), Some(&wide), None, &CAMERA, &strict);
    assert_eq!(result.object.kept, 20 * 14);
    assert_eq!(result.object.specks, 3 * 14);
    assert_eq!(result.object.flying, 4);
}

#[test]
fn holes_and_ranges_are_not_depth() {
    let depth = image(|x, y| match x {
        12 => 0.0,
        15 => f32::NAN,
        18 => 20.0,
        _ => wall(x, y),
    });
    let result = cleaned(&depth, &image(patch), None);
    assert_eq!(result.object.no_depth, 3 * 14);
    assert_eq!(result.object.kept + result.object.flying, 17 * 14);
}

#[test]
fn where_masks_overlap_the_hand_is_in_front() {
    let hand = image(|x, y| patch(x, y) && x >= 20);
    let result = cleaned(&image(wall), &image(patch), Some(&hand));
    assert_eq!(result.object.kept, 10 * 14);
    assert_eq!(result.manipulator.kept, 10 * 14);
}

#[test]
fn a_mask_that_bleeds_into_the_hand_is_cut_back() {
    // The hand's mask has a hole of three by three that the object's mask fills.
    let hole = |x: usize, y: usize| (26..29).contains(&x) && (14..17).contains(&y);
    let object = image(|x, y| patch(x, y) && x < 20 || hole(x, y));
    let hand = image(|x, y| patch(x, y) && x >= 20 && !hole(x, y));
    let keeps_specks = MaskSettings { min_component: 0.0, ..MaskSettings::default() };
    let result = clean(&image(wall), Some(&object), Some(&hand), &CAMERA, &keeps_specks);
    assert_eq!(result.object.contact, 9);
    assert_eq!(result.object.kept, 10 * 14);
    assert_eq!(result.manipulator.kept, 10 * 14 - 9);
}

#[test]
fn an_empty_mask_is_counted() {
    let result = cleaned(&image(wall), &image(|_, _| false), None);
    assert_eq!((result.object.empty_frames, result.object.kept), (1, 0));
}

#[test]
fn a_part_that_a_finger_cuts_off_stays() {
    let cut = image(|x, y| patch(x, y) && !(26..28).contains(&x));
    let strict = MaskSettings { min_component: 0.2, ..MaskSettings::default() };
    let result = clean(&image(wall), Some(&cut), None, &CAMERA, &strict);
    assert_eq!((result.object.specks, result.object.kept), (0, 18 * 14 - result.object.flying));
    assert!(is_object(&result, 29, 15));
}

use bendtwin_capture::raw::{Image, Mask, Region};

use super::View;
use crate::FlowSettings;

const OBJECT: Region = Region::Object;

/// The object in columns 5..25, half a metre away and 10 cm nearer from column 15 on; a hand over
/// rows 0..4.
fn view() -> View {
    let filled = |of: &dyn Fn(usize, usize) -> bool| {
        let mut mask: Mask = Image::filled(30, 20, false);
        for i in 0..mask.pixels.len() {
            mask.pixels[i] = of(i % 30, i / 30);
        }
        mask
    };
    let object = filled(&|column, _| (5..25).contains(&column));
    let hand = filled(&|_, row| row < 4);
    let mut depth = Image::filled(30, 20, 0.5);
    for (i, depth) in depth.pixels.iter_mut().enumerate() {
        if i % 30 >= 15 {
            *depth = 0.4;
        }
    }
    depth.pixels[10 * 30 + 8] = 0.0;
    depth.pixels[10 * 30 + 20] = f32::NAN;
    let color = Image::filled(30, 20, [9; 3]);
    View::new(&color, &depth, &object, Some(&hand), &FlowSettings::default())
}

#[test]
fn a_hand_in_front_covers_the_object() {
    let view = view();
    assert_eq!(view.inset([10.0, 2.0], OBJECT), 0);
    assert_eq!(view.inset([10.0, 2.0], Region::Manipulator), 2);
    assert_eq!(view.inset([10.0, 4.0], OBJECT), 1);
    assert_eq!(view.inset([7.4, 12.0], OBJECT), 3);
    assert_eq!(view.inset([2.0, 12.0], OBJECT), 0);
    assert_eq!(view.inset([-1.0, 99.0], OBJECT), 0);
    assert!(view.shows_near([3.0, 12.0], 2) && !view.shows_near([2.0, 12.0], 2));
}

#[test]
fn depth_is_not_mixed_across_an_edge() {
    let view = view();
    let depth = |x| view.depth([x, 14.0], OBJECT, 0.02);
    assert!(depth(14.4).is_some_and(|d| (d - 0.5).abs() < 1e-6));
    assert!(depth(14.6).is_some_and(|d| (d - 0.4).abs() < 1e-6));
    assert_eq!(depth(3.0), None);
    assert!(view.is_smooth([12.0, 14.0], OBJECT, 0.02));
    assert!(!view.is_smooth([14.0, 14.0], OBJECT, 0.02));
    assert!(view.nearest_depth_near([13.0, 14.0], 3).is_some_and(|d| d < 0.41));
}

#[test]
fn what_was_not_measured_is_unknown() {
    let view = view();
    assert_eq!(view.depth([8.0, 10.0], OBJECT, 0.02), None);
    assert_eq!(view.depth([20.0, 10.0], OBJECT, 0.02), None);
    assert!(view.depth([20.0, 11.0], OBJECT, 0.02).is_some_and(|d| (d - 0.4).abs() < 1e-6));
}

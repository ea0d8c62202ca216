use bendtwin_core::{CancelToken, Environment, settings::ingest::IngestSettings};
use nalgebra::Vector3;

use super::*;
use crate::{
    rigid::distance,
    shape::sight::first_views,
    testing::{BALL_M, HAND_M, TestScene, hand_middle, place, point},
};

const SPACING_M: f64 = 0.006;

/// The ball and its hand, carved by a number of cameras, and the number of points.
fn carved(cameras: usize, ground: Option<Plane>) -> Option<(Shape, usize)> {
    let recording = TestScene { cameras, ..TestScene::default() }.recording();
    let settings = IngestSettings::default();
    let views = first_views(&recording, &settings, &CancelToken::default()).unwrap();
    assert_eq!(views.len(), cameras);
    let surface = |label| views.iter().flat_map(|v| v.surface(label)).collect::<Vec<_>>();
    let (object, hands) = (surface(Label::Object), surface(Label::Manipulator));
    assert!(object.len() > 1000 && hands.len() > 100);
    let seen = FirstFrame { views: &views, object: &object, hands: &hands, ground };
    carve(&seen, SPACING_M, &CancelToken::default()).unwrap()
}

fn middle() -> Point {
    point(place(0, Vector3::zeros()))
}

/// Places on a grid inside the ball, so far from its surface at least.
fn inside(margin_m: f64, wanted: impl Fn(Vector3<f64>) -> bool) -> Vec<Point> {
    let steps = || (-13..=13).map(|i| f64::from(i) * SPACING_M);
    let all = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    let all = all.map(Vector3::from).filter(|p| p.norm() < BALL_M - margin_m && wanted(*p));
    all.map(|p| point(place(0, p))).collect()
}

fn share_filled(of: &[Point], shape: &Shape) -> f64 {
    let all = shape.surface.iter().chain(&shape.interior).copied();
    let grid = Grid::of(all, SPACING_M);
    of.iter().filter(|p| grid.any_within(**p, SPACING_M)).count() as f64 / of.len() as f64
}

#[test]
fn a_ball_is_filled_and_little_more() {
    let (shape, _) = carved(4, None).unwrap();
    let share = share_filled(&inside(SPACING_M, |_| true), &shape);
    assert!(share > 0.97, "{share} of the ball is filled");
    let off = |p: &&Point| distance(**p, middle()) > BALL_M + 2.0 * SPACING_M;
    let all = shape.interior.len() + shape.surface.len();
    let outside = shape.interior.iter().chain(&shape.surface).filter(off).count();
    assert!(20 * outside < all, "{outside} of {all} points lie outside");
    assert!(shape.interior.len() > 5000 && shape.surface.len() > 500);
}

#[test]
fn what_a_hand_hides_is_filled_and_no_hand_beyond_its_middle() {
    let (shape, _) = carved(4, None).unwrap();
    let under = inside(0.0, |p| (p - hand_middle()).norm() < HAND_M + SPACING_M);
    let share = share_filled(&under, &shape);
    assert!(share > 0.9, "{share} of {} places under the hand are filled", under.len());
    let top = point(place(0, hand_middle() + Vector3::z() * HAND_M));
    assert!(shape.surface.iter().chain(&shape.interior).all(|p| distance(*p, top) > HAND_M / 2.0));
}

#[test]
fn nothing_lies_below_the_ground() {
    // Through the middle of the ball.
    let ground = Environment::Z_UP.ground.map(|g| Plane { offset_m: 0.2, ..g });
    let (shape, _) = carved(4, ground).unwrap();
    assert!(shape.interior.iter().all(|p| p[2] > 0.2));
    assert!(shape.interior.len() > 2000);
}

#[test]
fn one_camera_carves_nothing() {
    assert_eq!(carved(1, None), None);
}

use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::testing::{point, sphere};

/// A contact without known facts.
fn unknown() -> Contact {
    Contact::new(Vec::new(), Vec::new())
}

/// Two balls that go different ways, with a dozen tracks each; the last two tracks slide.
fn pair(apart_m: f64, frames: usize) -> Tracks {
    let mut tracks =
        Tracks { count: 28, frames, seen: vec![true; 28 * frames], ..Tracks::default() };
    for frame in 0..frames {
        let f = frame as f64;
        for hand in [0.0, 1.0] {
            let turn =
                Rotation3::from_axis_angle(&Vector3::y_axis(), 0.05 * f * (1.0 - 2.0 * hand));
            let middle = Vector3::new(apart_m * hand, 0.004 * f * hand, 0.002 * f);
            for (i, p) in sphere(14).into_iter().enumerate() {
                let slide = if i >= 13 { 0.002 * f } else { 0.0 };
                let at = turn * p * 0.02 + middle + Vector3::new(0.0, 0.0, slide);
                tracks.points.push(point(at));
            }
        }
    }
    tracks
}

#[test]
fn two_hands_are_separated_even_where_they_touch() {
    for apart_m in [0.2, 0.045] {
        let controls =
            controls(&pair(apart_m, 30), &unknown(), &ControlSettings::default()).unwrap();
        assert_eq!(controls.hands.len(), 2, "{apart_m}");
        assert_eq!(controls.points.len(), 30 * 26, "the slides are left out");
        for hand in &controls.hands {
            assert!(hand.rigid && hand.residual_m < 1e-4, "{hand:?}");
            assert_eq!(hand.controls, 13);
        }
    }
}

#[test]
fn gaps_are_filled_and_noise_is_smoothed() {
    let mut tracks = pair(0.2, 30);
    let clean = controls(&tracks, &unknown(), &ControlSettings::default()).unwrap();
    for frame in 10..13 {
        tracks.seen[frame * 28..frame * 28 + 14].fill(false);
    }
    // A track is alone in being hidden for long, and does not survive.
    (5..25).for_each(|f| tracks.seen[f * 28 + 14] = false);
    for (i, p) in tracks.points.iter_mut().enumerate() {
        p[0] += 0.0005 * ((i * 7919) % 13) as f32 / 6.0 - 0.0005;
    }
    let noisy = controls(&tracks, &unknown(), &ControlSettings::default()).unwrap();
    assert_eq!(noisy.hands[0].filled_frames + noisy.hands[1].filled_frames, 3);
    assert_eq!(noisy.hands.iter().map(|h| h.surviving).sum::<usize>(), 25);
    // Every control point is near one of the clean ones in all frames.
    let (c, n) = (clean.points.len() / 30, noisy.points.len() / 30);
    for control in 0..n {
        let off = |other: usize| -> f64 {
            (0..30)
                .map(|f| {
                    crate::rigid::distance(
                        noisy.points[f * n + control],
                        clean.points[f * c + other],
                    )
                })
                .fold(0.0, f64::max)
        };
        let best = (0..c).map(off).fold(f64::INFINITY, f64::min);
        assert!(best < 1.2e-3, "control {control}: {best}");
    }
    let impatient = ControlSettings { max_gap_frames: 2, ..ControlSettings::default() };
    let made = controls(&tracks, &unknown(), &impatient).unwrap();
    assert_eq!(made.longest_gap, 3);
    assert!(made.findings.iter().any(|f| f.code == "HAND_BARELY_TRACKED"), "{:?}", made.findings);
}

#[test]
fn a_hand_that_opens_is_not_smoothed() {
    let mut tracks = pair(0.2, 30);
    for frame in 0..30 {
        for (i, p) in tracks.points[frame * 28..frame * 28 + 14].iter_mut().enumerate() {
            p[i % 2] += 0.001 * frame as f32;
        }
    }
    (8..12).for_each(|f| tracks.seen[f * 28 + 3] = false);
    let strict = ControlSettings { rigid_m: 0.002, ..ControlSettings::default() };
    let made = controls(&tracks, &unknown(), &strict).unwrap();
    assert!(made.hands.iter().any(|h| !h.rigid));
    assert!(made.findings.iter().any(|f| f.code == "HAND_NOT_RIGID"));
}

#[test]
fn too_few_or_too_many_hands_are_reported() {
    let tracks = pair(0.2, 5);
    let few = tracks.select(&[0, 1, 14]);
    let error = controls(&few, &unknown(), &ControlSettings::default()).err().unwrap();
    assert!(matches!(error, Error::NoHandTracks { tracks: 2, needed: 4 }), "{error}");
    let one = ControlSettings { max_hands: 1, count: 5, ..ControlSettings::default() };
    let made = controls(&tracks, &unknown(), &one).unwrap();
    assert_eq!((made.hands.len(), made.points.len()), (1, 25));
    assert!(made.findings.iter().any(|f| f.code == "TOO_MANY_HANDS"));
}

use super::*;
use crate::{
    rigid::distance,
    testing::{point, sphere},
};

/// A contact without known facts.
fn unknown() -> Contact {
    Contact::new(Vec::new(), Vec::new())
}

/// A curved body, seen from above, and a ball beside it that goes the other way.
fn clouds(frames: usize) -> Vec<Vec<Point>> {
    (0..frames)
        .map(|frame| {
            let (motion, f) = (motion(frame), frame as f64);
            let corners = (0..600).map(|i| {
                let (u, v) = (f64::from(i % 25) / 24.0 - 0.5, f64::from(i / 25) / 23.0 - 0.5);
                // The back of a hand of 8 x 5 x 3 cm.
                [0.08 * u, 0.05 * v, 0.03 * (1.0 - 3.0 * u * u) * (1.0 - 3.0 * v * v)]
            });
            // Every frame sees other points of it.
            let shifted =
                corners.map(|p| [p[0] as f32, (p[1] + 0.0007 * (f % 3.0)) as f32, p[2] as f32]);
            let ball = sphere(500).into_iter().filter(|p| p.z > -0.2);
            let ball = ball
                .map(|p| point(p * 0.02 + nalgebra::Vector3::new(0.2 - 0.003 * f, 0.002 * f, 0.0)));
            shifted.map(|p| motion.apply(p)).chain(ball).collect()
        })
        .collect()
}

fn motion(frame: usize) -> Rigid {
    let f = frame as f64;
    let turn = Rotation3::from_axis_angle(&nalgebra::Vector3::y_axis(), 0.02 * f);
    let translation = nalgebra::Vector3::new(0.0, 0.003 * f, 0.004 * f);
    Rigid { rotation: *turn.matrix(), translation }
}

#[test]
fn hands_without_tracks_are_followed_by_their_shape() {
    let frames = 25;
    let settings = ControlSettings { count: 20, ..ControlSettings::default() };
    let mut clouds = clouds(frames);
    clouds[12].clear();
    let made = controls(&clouds, 0, &unknown(), &settings).unwrap();
    assert_eq!(made.hands.len(), 2);
    assert!(made.hands.iter().all(|h| h.by_shape && h.controls == 10 && h.filled_frames == 1));
    assert_eq!(made.findings[0].code, "HAND_FOLLOWED_BY_SHAPE");
    for frame in 0..frames {
        for control in 0..20 {
            let start = made.points[control];
            let expected = if start[0] > 0.1 {
                let f = frame as f32;
                [start[0] - 0.003 * f, start[1] + 0.002 * f, start[2]]
            } else {
                motion(frame).apply(start)
            };
            let off = distance(made.points[frame * 20 + control], expected);
            assert!(off < 5e-3, "frame {frame}, control {control}: {off}");
        }
    }
}

#[test]
fn a_hand_that_is_not_there_at_first_is_refused_and_one_that_is_lost_is_reported() {
    let settings = ControlSettings::default();
    let mut clouds = clouds(20);
    (5..15).for_each(|f| clouds[f].clear());
    let made = controls(&clouds, 0, &unknown(), &settings).unwrap();
    assert!(made.longest_gap >= 10, "{}", made.longest_gap);
    assert!(made.findings.iter().any(|f| f.code == "HAND_BARELY_TRACKED"), "{:?}", made.findings);
    clouds[0].truncate(5);
    let error = controls(&clouds, 2, &unknown(), &settings).err().unwrap();
    assert!(matches!(error, Error::NoHandTracks { tracks: 2, .. }), "{error}");
    assert!(controls(&[], 0, &unknown(), &settings).is_err());
}

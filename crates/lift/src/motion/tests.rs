use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::testing::point;

/// A sheet that turns by 5 degrees a frame, with points 6 mm apart.
fn sheet(frames: usize) -> Tracks {
    let count = 100;
    let mut tracks =
        Tracks { count, frames, seen: vec![true; count * frames], ..Tracks::default() };
    for frame in 0..frames {
        let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.087 * frame as f64);
        for i in 0..count {
            let at = Vector3::new((i % 10) as f64, (i / 10) as f64, 0.0) * 0.006;
            tracks.points.push(point(turn * at));
        }
    }
    tracks
}

#[test]
fn a_sheet_that_turns_is_valid() {
    let mut tracks = sheet(20);
    let verdict =
        check_motion(&mut tracks, &MotionSettings::default(), &CancelToken::default()).unwrap();
    assert_eq!((verdict.drifted, verdict.unconfirmed, verdict.moved), (0, 0, 1900));
    assert!(verdict.valid[..100].iter().all(|v| !v) && verdict.valid[100..].iter().all(|v| *v));
    assert!(verdict.residual_m < 1e-5);
}

#[test]
fn a_jump_is_not_valid_and_a_slip_is_not_seen() {
    let mut tracks = sheet(20);
    // One point jumps by 8 mm and back, another slides away by 1 mm a frame.
    tracks.points[10 * 100 + 44][1] += 0.008;
    for frame in 0..20 {
        tracks.points[frame * 100 + 77][0] += 0.001 * frame as f32;
    }
    let verdict =
        check_motion(&mut tracks, &MotionSettings::default(), &CancelToken::default()).unwrap();
    let valid = |frame: usize, i: usize| verdict.valid[frame * 100 + i];
    assert!(valid(9, 44) && !valid(10, 44) && !valid(11, 44) && valid(12, 44));
    assert!(tracks.is_seen(10, 44), "8 mm may be a deformation");
    assert!(tracks.is_seen(8, 77) && !tracks.is_seen(12, 77) && !tracks.is_seen(19, 77));
    assert_eq!(verdict.drifts[77] as u64, verdict.drifted);
}

#[test]
fn without_neighbours_nothing_is_confirmed() {
    let mut tracks = sheet(3);
    let narrow = MotionSettings { radius_m: 0.001, ..MotionSettings::default() };
    let verdict = check_motion(&mut tracks, &narrow, &CancelToken::default()).unwrap();
    assert_eq!((verdict.drifted, verdict.unconfirmed, verdict.moved), (0, 200, 200));
}

/// All tracks may start in one place: that would be 10¹⁰ distances if all pairs were compared.
#[test]
fn tracks_in_one_place_are_checked_as_quickly_as_others() {
    let count = 100_000;
    let mut tracks = Tracks { count, frames: 2, seen: vec![true; 2 * count], ..Tracks::default() };
    tracks.points = vec![[0.1, 0.2, 0.3]; 2 * count];
    let start = std::time::Instant::now();
    let near = neighbours(&tracks, &MotionSettings::default());
    assert_eq!(near[0][0], 1);
    assert_eq!(near[count - 1][..3], [0, 1, 2]);
    let verdict =
        check_motion(&mut tracks, &MotionSettings::default(), &CancelToken::default()).unwrap();
    assert_eq!((verdict.drifted, verdict.unconfirmed), (0, 0));
    // Far more than it takes on a busy machine, and far less than comparing all takes.
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

use bendtwin_core::Point;

use super::*;
use crate::scene::{chain, chain_twin};

/// Positions of a sequence's points, each frame moved further along z.
fn path(sequence: &Sequence, z_per_frame: f32) -> Trajectory {
    let points = |f: usize| {
        sequence.points_at(f).iter().map(move |[x, y, z]| [*x, *y, z + z_per_frame * f as f32])
    };
    let positions: Vec<Point> = (0..sequence.frame_count).flat_map(points).collect();
    let node_count = sequence.points_at(0).len();
    Trajectory { start_frame: 0, node_count, positions, diverged: None }
}

#[test]
fn spread_and_error_are_means_over_future_frames() {
    let (capture, twin) = (chain(4, 5, 3, [0.0; 3]), chain_twin(4));
    let sequence = &capture.sequences[0];
    let own = path(sequence, 0.02);
    let member = path(sequence, 0.03);
    let mut errors = SpreadErrors::default();
    errors.add(&twin, sequence, &own, &[&member, &member], 3);
    let score = errors.score().unwrap();
    assert_eq!(score.fits, 3);
    // Frames 3 and 4: the fits are 1 cm a frame apart, the twin's error is 2 cm a frame.
    assert!((score.mean_m - 0.035).abs() < 1e-6, "{score:?}");
    assert!((score.error_m - 0.07).abs() < 1e-6, "{score:?}");
    assert!((score.factor().unwrap() - 2.0).abs() < 1e-4, "{score:?}");
    assert_eq!(score.within, 1.0);
    assert!((score.rank_correlation.unwrap() - 1.0).abs() < 1e-9, "{score:?}");
}

#[test]
fn without_future_frames_those_of_training_count() {
    let (capture, twin) = (chain(4, 3, 3, [0.0; 3]), chain_twin(4));
    let sequence = &capture.sequences[0];
    let mut errors = SpreadErrors::default();
    errors.add(&twin, sequence, &path(sequence, 0.02), &[&path(sequence, 0.0)], 3);
    let score = errors.score().unwrap();
    assert!((score.mean_m - 0.03).abs() < 1e-6, "{score:?}");
}

#[test]
fn points_that_are_not_seen_and_fits_that_diverged_say_nothing() {
    let (mut capture, twin) = (chain(4, 2, 0, [0.0; 3]), chain_twin(4));
    let sequence = &mut capture.sequences[0];
    sequence.visible.fill(false);
    let (own, lost) = (path(sequence, 0.02), path(sequence, f32::NAN));
    let mut errors = SpreadErrors::default();
    errors.add(&twin, sequence, &own, &[&own], 0);
    assert_eq!(errors.score(), None);
    sequence.visible.fill(true);
    errors.add(&twin, sequence, &own, &[&lost], 0);
    assert_eq!(errors.score(), None);
    // Fits that agree predict no error from their spread.
    errors.add(&twin, sequence, &own, &[&own], 0);
    let score = errors.score().unwrap();
    assert_eq!((score.factor(), score.rank_correlation), (None, None));
}

#[test]
fn ranks_of_equal_numbers_are_their_mean() {
    let pairs = [[3.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]];
    assert_eq!(ranks(&pairs, 0), [2.5, 0.0, 2.5, 1.0]);
    assert_eq!(ranks(&pairs, 1), [1.5; 4]);
}

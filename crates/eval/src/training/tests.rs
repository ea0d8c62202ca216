use bendtwin_core::{CancelToken, Point, quality::Predictor};

use super::*;
use crate::{EvaluateOptions, evaluate, predict, scene};

/// A chain that moves by this much in each frame, and another sequence of it.
fn capture(step: Point) -> Capture {
    let mut capture = scene::chain(5, 12, 8, step);
    let mut second = scene::chain(5, 9, 9, step.map(|x| 2.0 * x)).sequences.remove(0);
    second.name = "two".to_owned();
    let mut unseen = capture.sequences[0].clone();
    (unseen.name, unseen.train_frame_count) = ("three".to_owned(), 0);
    capture.sequences.extend([second, unseen]);
    capture
}

/// The errors of a twin and of standing still, and the same of the quality table.
fn errors(capture: &Capture) -> [(TrainingErrors, (Measure, f64)); 2] {
    let (twin, backend) = (scene::chain_twin(5), bendtwin_engine::cpu_with_threads(1));
    let cancel = CancelToken::default();
    let predictions = predict(&*backend, &twin, capture, &cancel).unwrap();
    let still = stand_still(&twin, &predictions, capture);
    let quality =
        evaluate(&*backend, &twin, capture, &EvaluateOptions::default(), &cancel).unwrap();
    let of = |paths: &[Trajectory], predictor| {
        let table = quality.score(predictor).unwrap().train.headline().unwrap();
        (training_errors(&twin, paths, capture, |_| 0).unwrap(), table)
    };
    [of(&predictions, Predictor::Axial), of(&still, Predictor::StandingStill)]
}

#[test]
fn they_are_those_of_the_quality_table() {
    for is_mocap in [true, false] {
        let mut capture = capture([0.0, 0.0, 0.004]);
        if !is_mocap {
            (capture.object.edges, capture.object.pins) = Default::default();
        }
        for (own, (measure, error_m)) in errors(&capture) {
            assert_eq!(measure, if is_mocap { Measure::Track } else { Measure::Chamfer });
            assert_eq!(own, TrainingErrors { measure, error_m, held_back_m: None });
            assert!(error_m > 1e-3);
        }
    }
}

#[test]
fn frames_that_are_held_back_count_apart() {
    let capture = capture([0.0, 0.0, 0.004]);
    let twin = scene::chain_twin(5);
    let backend = bendtwin_engine::cpu_with_threads(1);
    let paths = predict(&*backend, &twin, &capture, &CancelToken::default()).unwrap();
    let still = stand_still(&twin, &paths, &capture);
    let of = |held_back: usize| training_errors(&twin, &still, &capture, |_| held_back).unwrap();
    // What stands still is left behind further in each frame.
    let (all, kept) = (of(0), of(3));
    assert!(kept.error_m < all.error_m && all.error_m < kept.held_back_m.unwrap());
    assert_eq!(training_errors(&twin, &still, &capture, |_| 100), None);
}

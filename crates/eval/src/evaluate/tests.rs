use super::*;
use crate::scene;

fn backend() -> std::sync::Arc<dyn Backend> {
    bendtwin_engine::cpu_with_threads(1)
}

#[test]
fn an_object_at_rest_is_predicted_exactly() {
    let capture = scene::chain(5, 4, 3, [0.0; 3]);
    let twin = scene::chain_twin(5);
    let options = EvaluateOptions { axial: None, per_frame: true };
    let quality =
        evaluate(&*backend(), &twin, &capture, &options, &CancelToken::default()).unwrap();
    let own = quality.score(Predictor::Axial).unwrap();
    assert!(own.future.track_m.unwrap() < 1e-6 && own.future.coordinate_m.unwrap() < 1e-6);
    assert_eq!(own.per_frame.len(), 3);
    let rows: Vec<Predictor> = quality.scores.iter().map(|s| s.predictor).collect();
    use Predictor::*;
    assert_eq!(rows, [Axial, StandingStill, LastResidual, ClampInterpolation]);
    assert_eq!(quality.score(LastResidual).unwrap().train, Default::default());
}

#[test]
fn a_twin_that_is_worse_than_nothing_is_warned_about() {
    let mut capture = scene::chain(5, 30, 20, [0.0; 3]);
    capture.object.pins.clear();
    let mut twin = scene::chain_twin(5);
    twin.environment.gravity = [0.0, 0.0, -9.81];
    let quality = evaluate(
        &*backend(),
        &twin,
        &capture,
        &EvaluateOptions::default(),
        &CancelToken::default(),
    )
    .unwrap();
    assert!(quality.warnings.iter().any(|w| w.contains("no better than standing still")));
}

#[test]
fn a_diverging_twin_gets_finite_scores_and_a_warning() {
    let capture = scene::chain(5, 6, 3, [0.0, 0.0, 0.01]);
    let mut prediction =
        predict(&*backend(), &scene::chain_twin(5), &capture, &CancelToken::default()).unwrap();
    prediction[0].diverged = Some(bendtwin_engine::backend::Divergence { frame: 2, node: 1 });
    let quality = score(&scene::chain_twin(5), &prediction, None, &capture, false);
    assert!(quality.warnings[0].contains("diverged in frame 2"), "{:?}", quality.warnings);
    assert!(serde_json::to_string(&quality).unwrap().contains("track_m"));
}

#[test]
fn a_twin_of_another_capture_is_refused() {
    let capture = scene::chain(4, 4, 3, [0.0; 3]);
    let refuse = |twin: &Twin, capture: &Capture| {
        let options = EvaluateOptions::default();
        evaluate(&*backend(), twin, capture, &options, &CancelToken::default()).unwrap_err()
    };
    let mut slow = scene::chain_twin(4);
    slow.timing.fps = 30.0;
    assert!(matches!(refuse(&slow, &capture), Error::Mismatch(_)));
    assert!(matches!(refuse(&scene::chain_twin(6), &capture), Error::Mismatch(_)));
    let mut short = capture;
    short.sequences[0].visible.pop();
    assert!(matches!(refuse(&scene::chain_twin(4), &short), Error::Inconsistent(_)));
}

#[test]
fn the_motion_of_a_sequence_has_the_errors_of_its_frames() {
    let mut capture = scene::chain(5, 8, 5, [0.0, 0.0, 0.001]);
    let mut second = capture.sequences[0].clone();
    (second.name, second.train_frame_count) = ("two".to_owned(), 0);
    capture.sequences.push(second);
    let (twin, options) = (scene::chain_twin(5), EvaluateOptions::default());
    let run = |sequence| {
        let cancel = CancelToken::default();
        evaluate_with_motion(&*backend(), &twin, &capture, &options, sequence, &cancel).unwrap()
    };
    let (quality, motion) = run(0);
    let motion = motion.unwrap();
    assert_eq!(quality, run(7).0);
    assert_eq!((motion.sequence.as_str(), motion.train_frame_count), ("one", 5));
    assert_eq!((motion.frame_count, motion.errors.len()), (8, 8));
    assert_eq!(motion.prediction.positions.len(), 8 * 5);
    assert_eq!(motion.errors[0].track_m, Some(0.0));
    // The mean of those after the training frames is the table's.
    let future: f64 = motion.errors[5..].iter().map(|e| e.track_m.unwrap()).sum();
    let both = quality.score(Predictor::Axial).unwrap().future.track_m.unwrap();
    let held_out = run(1).1.unwrap();
    assert_eq!((held_out.sequence.as_str(), held_out.train_frame_count), ("two", 0));
    let all: f64 = held_out.errors[1..].iter().map(|e| e.track_m.unwrap()).sum();
    assert!(both > 0.0 && ((future + all) / 10.0 - both).abs() < 1e-12, "{both}");
    assert_eq!(run(2).1, None);
}

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

/// A twin of a chain that moves, with two members of other stiffness whose fits ended with other losses.
fn twin_with_members() -> (Capture, Twin) {
    let capture = scene::chain(5, 12, 6, [0.0, 0.0, 0.002]);
    let mut twin = scene::chain_twin(5);
    twin.environment.gravity = [0.0, 0.0, -2.0];
    twin.provenance.loss = Some(1e-3);
    let member = |stiffness: f32, loss| {
        let mut fit = twin.clone();
        fit.params.spring_stiffness.fill(stiffness);
        fit.provenance.loss = Some(loss);
        bendtwin_core::twin::Member::of(&fit, &twin).unwrap()
    };
    twin.members = vec![member(5.0, 1e-3), member(20.0, 2e-3)];
    (capture, twin)
}

#[test]
fn the_mean_of_the_fits_has_the_errors_of_the_weighted_mean_of_their_positions() {
    let (capture, twin) = twin_with_members();
    let cancel = CancelToken::default();
    let options = EvaluateOptions { axial: None, per_frame: true };
    let quality = evaluate(&*backend(), &twin, &capture, &options, &cancel).unwrap();
    let alone = Twin { members: Vec::new(), ..twin.clone() };
    let paths = |twin: &Twin| predict(&*backend(), twin, &capture, &cancel).unwrap();
    let all =
        [paths(&alone), paths(&twin.members[0].twin(&twin)), paths(&twin.members[1].twin(&twin))];
    let mut mean = all[0].clone();
    for (i, point) in mean[0].positions.iter_mut().enumerate() {
        let at = |fit: usize, axis: usize| f64::from(all[fit][0].positions[i][axis]);
        let of = |axis: usize| (4.0 * at(0, axis) + 4.0 * at(1, axis) + at(2, axis)) / 9.0;
        *point = [0, 1, 2].map(|axis| of(axis) as f32);
    }
    let expected = score(&alone, &mean, None, &capture, true);
    let (expected, row) = (&expected.scores[0], &quality.scores[1]);
    assert_eq!(row.predictor, Predictor::MeanOfFits);
    let near = |a: &bendtwin_core::quality::ErrorSummary,
                b: &bendtwin_core::quality::ErrorSummary| {
        let (a, b) = (a.track_m.unwrap(), b.track_m.unwrap());
        assert!((a - b).abs() < 1e-8 && a > 1e-5, "{a} is not {b}");
    };
    near(&row.train, &expected.train);
    near(&row.future, &expected.future);
    assert_eq!(row.per_frame.len(), expected.per_frame.len());
    row.per_frame.iter().zip(&expected.per_frame).skip(1).for_each(|(a, b)| near(a, b));
    // The twin's own rows are as without members.
    let without = evaluate(&*backend(), &alone, &capture, &options, &cancel).unwrap();
    let others: Vec<&Score> =
        quality.scores.iter().filter(|s| s.predictor != Predictor::MeanOfFits).collect();
    assert_eq!(others, without.scores.iter().collect::<Vec<_>>());
    assert_ne!(row.future, quality.scores[0].future);
}

#[test]
fn a_fit_that_diverged_has_no_part_in_the_mean() {
    let capture = scene::chain(3, 4, 2, [0.0; 3]);
    let sequence = &capture.sequences[0];
    let path = |z: f32, lost: bool| Trajectory {
        start_frame: 1,
        node_count: 3,
        positions: vec![[0.0, 0.0, z]; 9],
        diverged: lost.then_some(bendtwin_engine::backend::Divergence { frame: 1, node: 0 }),
    };
    let mean = |own: bool, member: bool| {
        let (own, member, third) = (path(1.0, own), path(3.0, member), path(5.0, member));
        let (mean, warning) = mean_of_fits(sequence, &own, &[&member, &third], &[0.5, 0.25, 0.25]);
        (mean.positions[0][2], warning.unwrap_or_default())
    };
    assert_eq!(mean(false, false), (2.5, String::new()));
    let (z, warning) = mean(false, true);
    assert_eq!(z, 1.0);
    assert!(warning.contains("leaves out 2 of 3 in sequence `one`"), "{warning}");
    assert_eq!(mean(true, false).0, 4.0);
    let (z, warning) = mean(true, true);
    assert!(z == 2.5 && warning.contains("all 3 fits diverged"), "{z} {warning}");
}

use bendtwin_core::{
    ObserverError, Problem, Stage,
    quality::Predictor,
    settings::{GradientWindow, Substeps},
};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

/// A fit of a second or so, with both models, both stages and all windows of one kind.
fn settings(window: GradientWindow) -> FitSettings {
    let mut s = FitSettings { seed: 5, compare_axial: true, ..FitSettings::default() };
    s.graph.max_nodes = Some(24);
    s.graph.max_neighbours = Some(6);
    s.substeps = Substeps::Auto { safety: 1.2, max: Some(60) };
    s.search.starts = Some(1);
    s.search.generations = Some(3);
    s.search.population = Some(4);
    s.search.topology = true;
    s.refine.passes = Some(3);
    s.refine.window = window;
    s.refine.batch = Some(2);
    s
}

fn job(capture: &Capture, settings: FitSettings) -> FitJob<'_> {
    let backend = bendtwin_engine::cpu_with_threads(2);
    FitJob { capture, capture_digest: "digest".into(), settings, backend, look: None }
}

/// Keeps everything, and stops or cancels after a number of checkpoints.
#[derive(Default)]
struct Recorder {
    checkpoints: Vec<Vec<u8>>,
    progress: Vec<Progress>,
    refuse_after: Option<usize>,
    cancel_after: Option<(usize, CancelToken)>,
}

impl Observer<Progress> for Recorder {
    fn progress(&mut self, progress: Progress) {
        self.progress.push(progress);
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        if self.refuse_after == Some(self.checkpoints.len()) {
            return Err("the lease is lost".into());
        }
        self.checkpoints.push(checkpoint);
        if let Some((after, cancel)) = &self.cancel_after
            && *after == self.checkpoints.len()
        {
            cancel.cancel();
        }
        Ok(())
    }
}

#[test]
fn a_fit_interrupted_anywhere_ends_in_the_same_twin() {
    for (scene, window) in [
        (Scene::Rope, GradientWindow::Pass),
        (Scene::Rope, GradientWindow::Frame),
        (Scene::Cable, GradientWindow::Frames(7)),
    ] {
        let capture = make(scene, &MakeOptions::tiny(2)).unwrap();
        let mut settings = settings(window);
        settings.search.starts = Some(if scene == Scene::Cable { 2 } else { 1 });
        let job = job(&capture, settings);
        let mut recorder = Recorder::default();
        let cancel = CancelToken::default();
        let whole = job.run(None, &mut recorder, &cancel).unwrap();
        assert_eq!(recorder.checkpoints.len(), 6);
        for checkpoint in &recorder.checkpoints {
            let resumed = job.run(Some(checkpoint), &mut (), &cancel).unwrap();
            assert_eq!(resumed.axial, whole.axial);
            assert_eq!(resumed.twin.encode().unwrap(), whole.twin.encode().unwrap());
        }
    }
}

#[test]
fn progress_rises_and_names_stage_and_variant() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut recorder = Recorder::default();
    let outcome = job(&capture, settings(GradientWindow::Pass))
        .run(None, &mut recorder, &CancelToken::default())
        .unwrap();
    let fractions: Vec<f64> = recorder.progress.iter().map(|p| p.fraction).collect();
    assert!(fractions.is_sorted() && fractions.last() == Some(&1.0), "{fractions:?}");
    for stage in [Stage::Search, Stage::Refine] {
        for variant in ["bending", "axial"] {
            let of = |p: &&Progress| p.stage == stage && p.variant == variant && p.iterations == 3;
            assert_eq!(recorder.progress.iter().filter(of).count(), 3);
        }
    }
    let q = &outcome.twin.quality;
    assert!(q.score(Predictor::Bending).is_some() && q.score(Predictor::Axial).is_some());
    let fast = q.fast.unwrap();
    assert!((1..=outcome.twin.timing.substeps).contains(&fast.substeps), "{fast:?}");
    assert!(fast.mean_deviation_m <= 1e-3 && fast.mean_travel_m > 0.0, "{fast:?}");
    assert!(outcome.axial.unwrap().graph.triplets.is_empty());
    assert!(!outcome.twin.graph.triplets.is_empty());
}

#[test]
fn refinement_never_makes_the_training_loss_worse() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(4)).unwrap();
    let mut settings = settings(GradientWindow::Pass);
    settings.compare_axial = false;
    // Steps so long that they cannot gain for this many passes.
    settings.refine.learning_rate = 1.0;
    settings.refine.passes = Some(24);
    let mut recorder = Recorder::default();
    job(&capture, settings).run(None, &mut recorder, &CancelToken::default()).unwrap();
    let best: Vec<f64> = recorder
        .progress
        .iter()
        .filter_map(|p| p.best_loss.filter(|_| p.stage == Stage::Refine))
        .collect();
    assert!(best.windows(2).all(|w| w[1] <= w[0]), "{best:?}");
    assert!(
        recorder.progress.iter().any(|p| p.note.as_ref().is_some_and(|n| n.contains("halved")))
    );
}

#[test]
fn cancelling_and_refusing_end_the_fit() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let job = job(&capture, settings(GradientWindow::Pass));
    let cancel = CancelToken::default();
    let mut recorder = Recorder { cancel_after: Some((2, cancel.clone())), ..Recorder::default() };
    let error = job.run(None, &mut recorder, &cancel).unwrap_err();
    assert_eq!(error.reason(), "CANCELLED");
    assert_eq!(recorder.checkpoints.len(), 2);

    let mut recorder = Recorder { refuse_after: Some(4), ..Recorder::default() };
    let error = job.run(None, &mut recorder, &CancelToken::default()).unwrap_err();
    assert_eq!(error.reason(), "CHECKPOINT_NOT_KEPT");
}

#[test]
fn the_start_that_predicts_frames_held_back_is_kept() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut settings = settings(GradientWindow::Pass);
    settings.search.starts = Some(3);
    settings.search.held_back = 0.4;
    settings.refine.passes = Some(8);
    let job = job(&capture, settings);
    let mut recorder = Recorder::default();
    let whole = job.run(None, &mut recorder, &CancelToken::default()).unwrap();
    let choice = whole.twin.quality.choice.clone().unwrap();
    assert!(choice.held_back_frames >= 5, "{choice:?}");
    let losses: Vec<f64> = choice.losses.iter().map(|l| l.unwrap()).collect();
    let kept = losses[choice.start as usize];
    assert!(losses.len() == 3 && losses.iter().all(|l| *l >= kept), "{choice:?}");
    let as_good = losses.iter().filter(|l| **l <= 2.0 * kept).count() - 1;
    assert_eq!(whole.twin.members.len(), as_good);
    assert!(as_good > 0, "no other start is as good: the test says nothing of members");
    assert!(whole.axial.as_ref().unwrap().quality.scores.len() == 1);
    // All starts of both models make four passes, then the chosen ones eight on all frames.
    let passes = recorder.progress.iter().filter(|p| p.stage == Stage::Refine);
    assert_eq!(passes.clone().count(), 6 * 4 + 2 * 8);
    assert!(passes.clone().all(|p| p.iterations == 12 && p.iteration <= 12));
    let fractions: Vec<f64> = recorder.progress.iter().map(|p| p.fraction).collect();
    assert!(fractions.is_sorted(), "{fractions:?}");
    for checkpoint in &recorder.checkpoints {
        let resumed = job.run(Some(checkpoint), &mut (), &CancelToken::default()).unwrap();
        assert_eq!(resumed.twin.encode().unwrap(), whole.twin.encode().unwrap());
    }
}

#[test]
fn a_checkpoint_of_other_settings_is_refused() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut one = settings(GradientWindow::Pass);
    one.search.generations = Some(1);
    one.refine.passes = Some(0);
    let mut recorder = Recorder::default();
    job(&capture, one.clone()).run(None, &mut recorder, &CancelToken::default()).unwrap();
    one.seed += 1;
    let other = job(&capture, one);
    let error =
        other.run(Some(&recorder.checkpoints[0]), &mut (), &CancelToken::default()).unwrap_err();
    assert_eq!(error.reason(), "CHECKPOINT_OF_ANOTHER_FIT");
}

#[test]
fn hopeless_limits_are_explained() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut settings = settings(GradientWindow::Pass);
    settings.substeps = Substeps::Fixed(1);
    let mut recorder = Recorder::default();
    let error =
        job(&capture, settings).run(None, &mut recorder, &CancelToken::default()).unwrap_err();
    assert_eq!(error.reason(), "NO_STABLE_CANDIDATE");
    let note = recorder.progress[0].note.clone().unwrap();
    assert!(note.contains("need more substeps"), "{note}");
}

#[test]
fn of_several_starts_the_one_with_the_lowest_training_loss_is_the_twin() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(7)).unwrap();
    let fit = |starts: u32| {
        let mut settings = settings(GradientWindow::Pass);
        (settings.seed, settings.search.starts) = (6, Some(starts));
        let mut recorder = Recorder::default();
        let job = job(&capture, settings);
        let outcome = job.run(None, &mut recorder, &CancelToken::default()).unwrap();
        let ends = recorder.progress.into_iter().filter(|p| p.stage == Stage::Refine);
        let ends = ends.filter(|p| p.iteration == p.iterations);
        let losses: Vec<_> = ends.map(|p| (p.variant, p.best_loss.unwrap())).collect();
        (outcome, losses)
    };
    let (several, losses) = fit(4);
    let names: Vec<_> = losses.iter().map(|(name, _)| name.as_str()).collect();
    let of = |model: &str| [1, 2, 3, 4].map(|start| format!("{model} {start}/4"));
    assert_eq!(names, [of("bending"), of("axial")].concat());
    // The first start is what a fit with one start does.
    let (single, alone) = fit(1);
    assert_eq!((losses[0].1, losses[4].1), (alone[0].1, alone[1].1));
    let best = |from: usize| {
        let own = losses[from..from + 4].iter().enumerate();
        own.min_by(|a, b| a.1.1.total_cmp(&b.1.1)).unwrap().0
    };
    let pairs = [
        (best(0), &several.twin, &single.twin),
        (best(4), several.axial.as_ref().unwrap(), single.axial.as_ref().unwrap()),
    ];
    for (best, several, single) in pairs {
        assert_eq!(best == 0, several.params == single.params);
    }
    assert!(best(0) > 0 || best(4) > 0, "the first start won twice: the test says little");
    let report = single.twin.quality.identifiability.as_ref().unwrap();
    assert!(report.motions.len() >= 3 && !report.summary.is_empty(), "{:?}", report.summary);
    report.check(single.twin.graph.node_count(), single.twin.skin.len()).unwrap();
    assert!(single.twin.members.is_empty() && single.twin.quality.spread.is_none());
    let ends: Vec<f64> = losses[..4].iter().map(|(_, loss)| *loss).collect();
    let as_good = ends.iter().filter(|l| **l <= 2.0 * ends[best(0)]).count() - 1;
    assert_eq!(several.twin.members.len(), as_good);
    // Of several fits the losses are kept, which their mean prediction is weighted by.
    assert_eq!(several.twin.provenance.loss, Some(ends[best(0)]));
    let mut others: Vec<f64> = several.twin.members.iter().map(|m| m.loss.unwrap()).collect();
    assert!(others.is_sorted() && others.iter().all(|loss| ends.contains(loss)), "{others:?}");
    others.dedup();
    assert_eq!(others.len(), as_good);
    assert_eq!(single.twin.provenance.loss, None);
    let scores = &several.twin.quality.scores;
    assert_eq!(scores[1].predictor, Predictor::MeanOfFits);
    assert_ne!(scores[1].train, scores[0].train);
    assert!(single.twin.quality.score(Predictor::MeanOfFits).is_none());
    let spread = several.twin.quality.spread.unwrap();
    assert_eq!(spread.fits as usize, 1 + as_good);
    assert!(spread.mean_m > 0.0 && spread.error_m > 0.0, "{spread:?}");
}

#[test]
fn gravity_is_searched_if_the_settings_say_so() {
    let capture = make(Scene::Cable, &MakeOptions::tiny(3)).unwrap();
    let mut settings = FitSettings { compare_axial: false, ..FitSettings::default() };
    settings.search.gravity = Some(true);
    settings.search.generations = Some(3);
    settings.refine.passes = Some(1);
    let fit = |settings: &FitSettings| {
        let backend = bendtwin_engine::cpu_with_threads(1);
        let settings = settings.clone();
        let job =
            FitJob { capture: &capture, capture_digest: "d".into(), settings, backend, look: None };
        job.run(None, &mut (), &CancelToken::default()).unwrap().twin
    };
    let twin = fit(&settings);
    let ratio = twin.environment.gravity[2] / capture.environment.gravity[2];
    assert!(ratio != 1.0 && (0.5..=2.0).contains(&ratio), "{ratio} of what the capture says");
    assert_eq!(twin.environment.ground, capture.environment.ground);
    settings.search.gravity = Some(false);
    assert_eq!(fit(&settings).environment, capture.environment);
}

#[test]
fn a_time_limit_ends_a_fit_early() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let mut endless = settings(GradientWindow::Pass);
    endless.within_s = Some(1.0);
    // One of two models may gain nothing more some passes before the other.
    endless.compare_axial = false;
    (endless.search.generations, endless.refine.passes) = (Some(10_000), Some(100_000));
    let mut recorder = Recorder::default();
    let outcome =
        job(&capture, endless.clone()).run(None, &mut recorder, &CancelToken::default()).unwrap();
    let made = outcome.twin.provenance.settings.unwrap();
    assert!(made.search.generations < Some(10_000), "{:?}", made.search.generations);
    assert!(made.refine.passes < Some(100_000), "{:?}", made.refine.passes);
    let done =
        |stage| recorder.progress.iter().filter(move |p| p.stage == stage).map(|p| p.iteration);
    assert_eq!(done(Stage::Search).max(), made.search.generations);
    assert_eq!(done(Stage::Refine).max(), made.refine.passes);
    // A fit that is resumed at its end has no time for more.
    let last = recorder.checkpoints.last().unwrap();
    let mut resumed = Recorder::default();
    job(&capture, endless).run(Some(last), &mut resumed, &CancelToken::default()).unwrap();
    assert!(resumed.progress.iter().all(|p| p.stage != Stage::Search));
}

#[test]
fn an_object_in_pieces_is_reported_before_the_search() {
    let capture = make(Scene::Toy, &MakeOptions::tiny(2)).unwrap();
    let first = |radius_m: Option<f64>| {
        let mut settings = settings(GradientWindow::Pass);
        settings.graph.radius_m = radius_m;
        // The first checkpoint is refused: nothing is simulated longer than a generation.
        let mut recorder = Recorder { refuse_after: Some(0), ..Recorder::default() };
        let stopped = job(&capture, settings).run(None, &mut recorder, &CancelToken::default());
        assert!(matches!(stopped, Err(Error::Observer(_))), "{stopped:?}");
        recorder.progress.into_iter().next()
    };
    let reported = first(Some(1e-3)).unwrap();
    assert_eq!((reported.stage, reported.iteration), (Stage::Search, 0));
    assert!(reported.note.unwrap().contains("falls into 24 pieces"));
    assert_eq!(first(None), None);
}

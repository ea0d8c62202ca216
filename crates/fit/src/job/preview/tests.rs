use bendtwin_core::{CancelToken, FitSettings, Observer, Progress, quality::Predictor};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;
use crate::{FitJob, Outcome, job::validation::Validation};

/// Keeps the previews of a fit.
#[derive(Default)]
struct Watcher(Vec<Progress>);

impl Observer<Progress> for Watcher {
    fn progress(&mut self, progress: Progress) {
        self.0.push(progress);
    }

    fn wants_previews(&self) -> bool {
        true
    }
}

impl Watcher {
    fn previews(&self) -> Vec<Preview> {
        self.0.iter().filter_map(|p| p.preview.as_deref().cloned()).collect()
    }
}

fn settings(starts: u32) -> FitSettings {
    let mut s = FitSettings { seed: 5, ..FitSettings::default() };
    s.graph.max_nodes = Some(24);
    s.graph.max_neighbours = Some(6);
    s.search.starts = Some(starts);
    s.search.held_back = 0.4;
    s.search.generations = Some(3);
    s.search.population = Some(4);
    s.refine.passes = Some(4);
    s
}

/// A fit with a preview of everything that is new, or at the times of other fits.
fn fit(job: &FitJob<'_>, every: bool) -> (Outcome, Watcher) {
    let (mut watcher, cancel) = (Watcher::default(), CancelToken::default());
    let task = job.task(&cancel).unwrap();
    let validation = Validation::new(&task);
    let mut run = Run::new(job, &task, validation.as_ref(), &mut watcher, &cancel);
    if every {
        (run.previews.share, run.previews.interval) = (f64::INFINITY, Duration::ZERO);
    }
    run.search().unwrap();
    let finished = run.refine().unwrap();
    let outcome = run.evaluate(finished).unwrap();
    (outcome, watcher)
}

#[test]
fn the_last_preview_is_of_the_twin_and_has_the_errors_of_its_table() {
    for scene in [Scene::Rope, Scene::Cable] {
        let capture = make(scene, &MakeOptions::tiny(2)).unwrap();
        let backend = bendtwin_engine::cpu_with_threads(2);
        let (capture_digest, settings) = ("digest".into(), settings(1));
        let job = FitJob { capture: &capture, capture_digest, settings, backend, look: None };
        let (Outcome { twin, .. }, watcher) = fit(&job, true);
        let previews = watcher.previews();
        let stages: Vec<Stage> = previews.iter().map(|p| p.stage).collect();
        assert!(stages.is_sorted() && stages[0] == Stage::Search);
        let last = previews.last().unwrap();
        assert_eq!((last.stage, last.variant.as_str()), (Stage::Refine, "bending"));
        let headline = |p| twin.quality.score(p).unwrap().train.headline().unwrap();
        let PreviewErrors { measure, error_m, held_back_m, baseline_m } = last.errors;
        assert_eq!((measure, error_m), headline(Predictor::Bending));
        assert_eq!((measure, baseline_m), headline(Predictor::StandingStill));
        assert_eq!(held_back_m, None);

        let sequence = &capture.sequences[last.sequence as usize];
        let paths = predict(&*job.backend, &twin, &capture, &CancelToken::default()).unwrap();
        assert!(last.frames.is_sorted() && last.frames.len() <= Preview::MOST_FRAMES);
        assert_eq!(last.frames.first(), Some(&(sequence.start_frame() as u32)));
        assert_eq!(last.frames.last(), Some(&(sequence.frame_count as u32 - 1)));
        let shown = spread(twin.skin.len(), Preview::MOST_POINTS);
        assert_eq!(last.point_count(), shown.len());
        for (frame, positions) in last.frames.iter().zip(last.positions.chunks(shown.len())) {
            let placed = twin.skin.positions(paths[0].at(*frame as usize).unwrap());
            let expected: Vec<_> = shown.iter().map(|&p| placed[p]).collect();
            assert_eq!(positions, expected);
        }
        // The curve of the losses has the error where a preview was made.
        let of = |p: &&Progress| p.preview.is_some();
        let newest = watcher.0.iter().rev().find(of).unwrap();
        assert_eq!(newest.model_loss().unwrap().error_m, Some(error_m));
        assert_eq!(watcher.0.last().unwrap().error_m, Some(error_m));

        let (unwatched, _) = fit(&job, false);
        assert_eq!(unwatched.twin.encode().unwrap(), twin.encode().unwrap());
    }
}

#[test]
fn frames_held_back_from_several_starts_have_their_own_error() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(2)).unwrap();
    let backend = bendtwin_engine::cpu_with_threads(2);
    let (capture_digest, settings) = ("digest".into(), settings(2));
    let job = FitJob { capture: &capture, capture_digest, settings, backend, look: None };
    let (outcome, watcher) = fit(&job, true);
    let previews = watcher.previews();
    let with = |p: &&Preview| p.errors.held_back_m.is_some();
    let (before, after): (Vec<_>, Vec<_>) = previews.iter().partition(with);
    assert!(before.iter().any(|p| p.stage == Stage::Refine));
    assert!(after.iter().all(|p| p.stage == Stage::Refine));
    // Each is measured over the frames of its own stage.
    let still = |p: &Preview| p.errors.baseline_m;
    assert!(before.iter().all(|p| still(p) == still(before[0])));
    let table = outcome.twin.quality.score(Predictor::StandingStill).unwrap();
    assert_eq!(Some(still(after[0])), table.train.headline().map(|(_, error_m)| error_m));
    assert!(still(before[0]) != still(after[0]));
}

#[test]
fn previews_take_a_small_share_of_the_time_and_only_where_they_are_wanted() {
    let ago = |s: f64| Instant::now().checked_sub(Duration::from_secs_f64(s)).unwrap();
    let after = |began: f64, ended: f64, took: f64| Previews {
        began: ago(began),
        spent: Duration::from_secs_f64(took),
        last: Some((ago(ended), Duration::from_secs_f64(took))),
        ..Previews::new(true)
    };
    assert!(Previews::new(true).is_due(false) && !Previews::new(false).is_due(true));
    // Two that take a tenth of a second need four seconds.
    assert!(after(5.0, 3.0, 0.1).is_due(false) && !after(3.0, 2.0, 0.1).is_due(true));
    assert!(!after(5.0, 0.5, 0.001).is_due(false) && after(5.0, 0.5, 0.001).is_due(true));
    let shown = Previews { shown: Some((Stage::Search, true, 0.5)), ..Previews::new(true) };
    assert!(shown.is_new(Stage::Search, true, 0.4) && !shown.is_new(Stage::Search, true, 0.5));
    assert!(shown.is_new(Stage::Search, false, 0.9) && shown.is_new(Stage::Refine, true, 0.9));
    assert!(!shown.is_new(Stage::Refine, true, f64::INFINITY));
}

#[test]
fn a_few_of_many_are_spread_evenly() {
    assert_eq!(spread(3, 24), [0, 1, 2]);
    assert_eq!(spread(101, 5), [0, 25, 50, 75, 100]);
    assert_eq!((spread(0, 5), spread(1, 5)), (vec![], vec![0]));
}

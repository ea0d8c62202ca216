use bendtwin_core::{PreviewErrors, Stage, quality::Measure};

use super::*;

fn progress(stage: Stage, variant: &str, iteration: u32) -> Progress {
    Progress {
        stage,
        variant: variant.to_owned(),
        iteration,
        iterations: 10,
        fraction: 0.5,
        loss: Some(f64::from(iteration)),
        best_loss: Some(1.0),
        eta_s: None,
        note: None,
        models: Vec::new(),
        error_m: None,
        preview: None,
    }
}

fn preview(iteration: u32) -> Arc<Preview> {
    let errors = PreviewErrors {
        measure: Measure::Track,
        error_m: 1.0 / f64::from(iteration),
        held_back_m: None,
        baseline_m: 1.0,
    };
    Arc::new(Preview {
        stage: Stage::Refine,
        variant: "bending".to_owned(),
        iteration,
        sequence: 0,
        frames: vec![0],
        positions: vec![[0.0; 3]],
        errors,
    })
}

#[test]
fn a_preview_is_reported_once_and_its_error_with_the_loss() {
    let latest = LatestProgress::default();
    let with = |iteration| Progress {
        preview: Some(preview(iteration)),
        ..progress(Stage::Refine, "bending", iteration)
    };
    latest.set(with(1));
    latest.set(progress(Stage::Refine, "bending", 2));
    let news = latest.news();
    assert_eq!(news.preview.as_ref().unwrap().iteration, 1);
    assert_eq!(news.losses.iter().map(|l| l.error_m).collect::<Vec<_>>(), [Some(1.0), None]);
    // A newer one that came while the report was under way goes with the next.
    latest.set(with(3));
    latest.acknowledge(&news);
    let news = latest.news();
    assert_eq!(news.preview.as_ref().unwrap().iteration, 3);
    latest.acknowledge(&news);
    assert!(latest.news().preview.is_none());
}

fn models(latest: &LatestProgress) -> Vec<(String, u32)> {
    let models = latest.news().progress.unwrap().models;
    models.into_iter().map(|m| (m.variant, m.iteration)).collect()
}

#[test]
fn models_that_are_fitted_side_by_side_are_reported_together() {
    let latest = LatestProgress::default();
    for iteration in 1..=3 {
        latest.set(progress(Stage::Search, "bending", iteration));
        latest.set(progress(Stage::Search, "axial", iteration));
    }
    assert_eq!(models(&latest), [("bending".to_owned(), 3), ("axial".to_owned(), 3)]);
    latest.set(progress(Stage::Refine, "axial", 1));
    assert_eq!(models(&latest), [("axial".to_owned(), 1)]);
    // Of several starts one continues.
    latest.set(progress(Stage::Refine, "axial 2", 1));
    latest.set(progress(Stage::Refine, "axial", 2));
    assert_eq!(models(&latest), [("axial".to_owned(), 2), ("axial 2".to_owned(), 1)]);
    latest.set(progress(Stage::Refine, "axial", 3));
    assert_eq!(models(&latest), [("axial".to_owned(), 3)]);
    latest.set(progress(Stage::Evaluate, "bending", 0));
    assert_eq!(latest.news().progress.unwrap().models, []);
}

#[test]
fn every_loss_is_reported_though_progress_is_not() {
    let latest = LatestProgress::default();
    for iteration in 1..=5 {
        latest.set(progress(Stage::Search, "bending", iteration));
    }
    let news = latest.news();
    assert_eq!(news.losses.iter().map(|l| l.iteration).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    latest.set(progress(Stage::Search, "bending", 6));
    // A report that failed is sent again, with later losses.
    assert_eq!(latest.news().losses.len(), 6);
    latest.acknowledge(&news);
    assert_eq!(latest.news().losses.iter().map(|l| l.iteration).collect::<Vec<_>>(), [6]);
}

#[test]
fn unreported_losses_are_thinned_out() {
    let latest = LatestProgress::default();
    for iteration in 1..=100_000 {
        latest.set(progress(Stage::Refine, "bending", iteration));
    }
    let waiting = latest.lock().losses.len();
    assert!((MOST_WAITING / 4..=MOST_WAITING).contains(&waiting), "{waiting}");
    assert_eq!(latest.news().losses.len(), MOST_LOSSES);
}

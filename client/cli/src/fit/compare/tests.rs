use bendtwin_client::{CaptureId, Job, JobState, LossCurve, Quality};
use bendtwin_core::FitSettings;

use super::*;

fn details(seed: u64, capture: CaptureId, track_mm: f64, loss: f64) -> Details {
    let settings = FitSettings { seed, ..FitSettings::default() };
    let job = Job {
        state: JobState::Succeeded,
        settings: serde_json::to_value(&settings).unwrap(),
        progress: None,
        fault: None,
        attempt_faults: Vec::new(),
        attempts: 1,
        worker: None,
        cancel_requested: false,
        create_time: "2026-01-01T00:00:00Z".parse().unwrap(),
        start_time: None,
        end_time: None,
        run_s: 0.0,
        revision: 1,
    };
    let fit = Fit {
        name: FitId::generate(),
        capture,
        twin: None,
        priority: 0,
        job,
        display_name: format!("try {seed}"),
        note: String::new(),
        tags: Vec::new(),
        owner: String::new(),
        error_m: None,
        measure: None,
        requirements: bendtwin_client::Requirements::default(),
    };
    let curve = LossCurve {
        stage: "refine".into(),
        variant: "bending 2/3".into(),
        iterations: vec![1, 2],
        losses: vec![None, Some(loss)],
        best_losses: vec![None, Some(loss)],
        errors_m: vec![None, None],
    };
    let quality: Quality = serde_json::from_value(serde_json::json!({"scores": [{
        "predictor": "bending", "train": {"track_m": 0.001},
        "future": {"track_m": 1e-3 * track_mm, "chamfer_l1_m": 1e-3 * (9.0 - track_mm)}}]}))
    .unwrap();
    Details {
        fit,
        capture_display_name: Some("rope".into()),
        losses: vec![curve],
        quality: Some(quality),
    }
}

#[test]
fn what_differs_and_who_is_nearest_is_said() {
    let capture = CaptureId::generate();
    let fits = vec![details(1, capture, 3.0, 0.5), details(2, capture, 5.0, 0.25)];
    let compared = Comparison::of(fits);
    let names: Vec<_> = compared.settings.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(names, ["seed"]);
    assert_eq!(compared.losses[0].best, Some(1));
    let best: Vec<_> = compared.errors.iter().map(|m| (m.name.as_str(), m.best)).collect();
    assert_eq!(best, [("track future", Some(0)), ("CD future", Some(1)), ("track train", None)]);
    let text = compared.text();
    for part in [
        "3.00 *",
        "4.00 *",
        "2.50e-1 *",
        "A is nearest on: track future",
        "B is nearest on: CD future",
    ] {
        assert!(text.contains(part), "{part} in:\n{text}");
    }
    assert!(!text.contains("note:"), "{text}");
}

#[test]
fn what_seeds_differ_by_has_no_winner() {
    let capture = CaptureId::generate();
    let fits = vec![details(1, capture, 4.5, 0.5), details(2, capture, 4.6, 0.25)];
    let text = Comparison::of(fits).text();
    assert!(!text.contains("nearest"), "{text}");
    assert!(text.contains("no difference beyond what seeds make on: track future, CD future"));
}

#[test]
fn fits_of_different_captures_have_no_winner() {
    let [first, second] = [CaptureId::generate(), CaptureId::generate()];
    let fits = vec![details(1, first, 3.0, 0.5), details(1, second, 5.0, 0.25)];
    let compared = Comparison::of(fits);
    assert!(compared.errors.iter().chain(&compared.losses).all(|m| m.best.is_none()));
    let text = compared.text();
    assert!(text.contains("different captures") && !text.contains("nearest"), "{text}");
    assert!(text.contains("settings that differ\n  none"), "{text}");
}

#[test]
fn a_tie_and_a_single_number_have_no_winner() {
    assert_eq!(best(&[Some(1.0), None]), None);
    assert_eq!(best(&[Some(1.0), Some(1.0), Some(2.0)]), None);
    assert_eq!(best(&[Some(2.0), None, Some(1.0)]), Some(2));
    assert_eq!(best(&[]), None);
    assert_eq!((letter(0), letter(25), letter(26)), ("A".into(), "Z".into(), "27".into()));
}

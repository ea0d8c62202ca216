//! Healthy captures have no warning.

use bendtwin_broken::{
    Footage,
    healthy::{COUNT, Half, Healthy, half, healthy},
};
use bendtwin_capture::raw::Recording;
use bendtwin_core::{CancelToken, Finding, Severity, settings::ingest::IngestSettings};
use bendtwin_inspect::{inspect, inspect_observed};

fn findings(recording: &Recording) -> Vec<Finding> {
    let (settings, cancel) = (IngestSettings::default(), CancelToken::default());
    inspect(recording, &settings, &cancel, &mut |_| {}).unwrap().findings
}

/// Everything that a report of a capture asks to be done.
fn complaints(index: usize) -> Vec<String> {
    let (name, capture) = healthy(index);
    let findings = match capture {
        Healthy::Recording(recording) => findings(&recording),
        Healthy::Points(capture) => inspect_observed(&capture).findings,
    };
    let asks = |f: &&Finding| f.severity != Severity::Info;
    let text = |f: &Finding| format!("{index} ({name}): {} {}", f.code, f.message);
    findings.iter().filter(asks).map(text).collect()
}

fn all_complaints(which: impl Iterator<Item = usize>) -> Vec<String> {
    which.flat_map(complaints).collect()
}

/// Every fifth: each shape and each kind of capture, and most motions.
#[test]
fn twelve_healthy_captures_have_no_warning() {
    let found = all_complaints((0..COUNT).step_by(5));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Four cameras, of which the second drops every tenth frame and closes up the rest.
fn drifting() -> Footage {
    let (_, Healthy::Recording(recording)) = healthy(51) else { panic!("it is staged") };
    let mut footage = Footage::of(&recording).unwrap();
    footage.about.frame_count = footage.about.frame_count * 9 / 10;
    (0..footage.reels.len()).for_each(|camera| {
        footage.retime(camera, |frame| Some(if camera == 1 { frame * 10 / 9 } else { frame }));
    });
    footage
}

#[test]
fn a_camera_that_closes_up_gaps_drifts() {
    let findings = findings(&drifting().recording());
    let drift = findings.iter().find(|f| f.code == "CLOCKS_DRIFT");
    assert!(drift.is_some_and(|f| f.cameras == [1]), "{findings:?}");
}

#[test]
fn equal_time_stamps_rule_a_drift_out() {
    let mut footage = drifting();
    let (frames, fps) = (footage.about.frame_count, footage.about.fps);
    for camera in &mut footage.about.cameras {
        camera.times_s = (0..frames).map(|frame| frame as f64 / fps).collect();
    }
    let findings = findings(&footage.recording());
    assert!(!findings.iter().any(|f| f.code == "CLOCKS_DRIFT"), "{findings:?}");
}

#[test]
fn cables_of_motion_capture_have_no_warning() {
    let found = all_complaints((2..36).step_by(3));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// `cargo test -p bendtwin-broken --test healthy -- --ignored --nocapture` prints how many of each half
/// have a warning.
#[test]
#[ignore = "takes minutes"]
fn no_healthy_capture_has_a_warning() {
    let mut all = Vec::new();
    for (which, words) in [(Half::Tuning, "tuning"), (Half::Held, "held")] {
        let of = (0..COUNT).filter(|index| half(*index) == which);
        let total = of.clone().count();
        let found: Vec<Vec<String>> = of.map(complaints).filter(|c| !c.is_empty()).collect();
        println!("{words}: {} of {total} have a warning", found.len());
        all.extend(found.into_iter().flatten());
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

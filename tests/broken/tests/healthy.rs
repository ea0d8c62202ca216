//! Healthy captures have no warning.

use bendtwin_broken::healthy::{COUNT, Half, Healthy, half, healthy};
use bendtwin_core::{CancelToken, Finding, Severity, settings::ingest::IngestSettings};
use bendtwin_inspect::{inspect, inspect_observed};

/// Everything that a report of a capture asks to be done.
fn complaints(index: usize) -> Vec<String> {
    let (name, capture) = healthy(index);
    let findings = match capture {
        Healthy::Recording(recording) => {
            let settings = IngestSettings::default();
            let cancel = CancelToken::default();
            inspect(&recording, &settings, &cancel, &mut |_| {}).unwrap().findings
        }
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

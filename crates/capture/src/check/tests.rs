//! Every way in which recordings were seen to be broken, and that the check says
//! so: by code for programs, by naming the thing for people.

mod content;
mod files;

use std::sync::OnceLock;

use bendtwin_core::Capture;
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

pub(crate) fn rope() -> Capture {
    static ROPE: OnceLock<Capture> = OnceLock::new();
    ROPE.get_or_init(|| make(Scene::Rope, &MakeOptions::tiny(11)).unwrap()).clone()
}

fn cable() -> Capture {
    static CABLE: OnceLock<Capture> = OnceLock::new();
    CABLE.get_or_init(|| make(Scene::Cable, &MakeOptions::tiny(11)).unwrap()).clone()
}

/// Complaint if a report lacks a finding with this code that names the thing.
fn lacks(report: &CheckReport, severity: Severity, code: &str, names: &str) -> Option<String> {
    let Some(found) = report.findings.iter().find(|f| f.code == code) else {
        return Some(format!("{code} ({names}) is missing: {:#?}", report.findings));
    };
    let named = report.findings.iter().any(|f| f.code == code && f.sentence().contains(names));
    (found.severity != severity || !named)
        .then(|| format!("{code} does not name {names:?} as {severity:?}: {found:?}"))
}

fn expect(report: &CheckReport, severity: Severity, code: &str, names: &str) {
    assert_eq!(lacks(report, severity, code, names), None);
}

#[test]
fn repetitions_are_shortened() {
    let finding = |n: usize| Finding::warning("A", n.to_string());
    let merged = report::merge((0..70).map(finding).chain([Finding::error("B", "x")]).collect());
    assert_eq!(merged.len(), 5);
    assert_eq!(merged[0].severity, Severity::Error);
    assert!(merged.iter().any(|f| f.message == "the same in 67 more places"));
}

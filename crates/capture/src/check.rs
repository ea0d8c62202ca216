//! Why does my data not fit: looks for what goes wrong in recordings and says it
//! in plain words, with numbers and what to do. Reading refuses what cannot be
//! understood; this judges what can.

mod controls;
mod geometry;
mod motion;
mod report;
mod setting;
pub(crate) mod structure;
mod tracks;

use std::path::Path;

use bendtwin_core::{Capture, Environment, Finding, Problem, Sequence, Severity};

pub use report::CheckReport;
pub(crate) use report::Note;

use self::structure::validate;
use crate::{Limits, read::read_noting};

/// Checks a capture in memory, with all recordings of its object. Findings come with errors first.
pub fn check(capture: &Capture) -> CheckReport {
    if let Err(error) = validate(capture) {
        let findings = vec![Finding::error(error.reason(), error.to_string())];
        return CheckReport { findings: report::merge(findings), ..CheckReport::default() };
    }
    let mut findings = one(capture);
    for other in &capture.others {
        // Nothing of it may be for fitting: then it is only predicted.
        let is_split = |f: &Finding| f.code == "SPLIT_EMPTY";
        let named = |f: Finding| Finding {
            message: format!("recording `{}`: {}", other.name, f.message),
            ..f
        };
        findings.extend(one(other).into_iter().filter(|f| !is_split(f)).map(named));
    }
    CheckReport { findings: report::merge(findings), ..CheckReport::default() }
}

/// Findings about one recording.
fn one(capture: &Capture) -> Vec<Finding> {
    let mut findings = Vec::new();
    setting::check(capture, &mut findings);
    for sequence in &capture.sequences {
        tracks::check(capture, sequence, &mut findings);
    }
    // Numbers that are not there cannot be judged further.
    if !findings.iter().any(|f| f.severity == Severity::Error) {
        geometry::check(capture, &mut findings);
        for sequence in &capture.sequences {
            motion::check(capture, sequence, &mut findings);
        }
    }
    controls::check(capture, &mut findings);
    findings
}

/// Findings about the direction and the size of gravity.
pub fn check_gravity(environment: &Environment) -> Vec<Finding> {
    let mut findings = Vec::new();
    setting::gravity(environment, &mut findings);
    report::merge(findings)
}

/// Reads and checks a capture; what reading refuses becomes a finding too.
pub fn check_path(path: &Path, limits: &Limits) -> CheckReport {
    match read_noting(path, limits) {
        Ok((capture, remarks)) => {
            let mut findings = check(&capture).findings;
            // The reader knows why.
            let named =
                |code: &String| remarks.findings.iter().any(|f| f.consequences.contains(code));
            findings.retain(|f| !named(&f.code));
            findings.extend(remarks.findings);
            CheckReport { findings: report::merge(findings), sources: remarks.sources }
        }
        Err(error) => {
            let finding =
                Finding::from_sentence(Severity::Error, error.reason(), error.to_string());
            CheckReport { findings: vec![finding], ..CheckReport::default() }
        }
    }
}

/// Positions of a frame's visible, finite points.
fn visible_points(sequence: &Sequence, frame: usize) -> Vec<bendtwin_core::Point> {
    let seen = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
    seen.filter(|(p, v)| **v && p.iter().all(|x| x.is_finite())).map(|(p, _)| *p).collect()
}

fn distance(a: &bendtwin_core::Point, b: &bendtwin_core::Point) -> f32 {
    bendtwin_core::geometry::distance(*a, *b)
}

/// Median of finite numbers; 0 of none.
fn median(mut values: Vec<f32>) -> f32 {
    bendtwin_core::geometry::median(&mut values).unwrap_or(0.0)
}

fn percent(part: usize, whole: usize) -> usize {
    (100 * part).checked_div(whole).unwrap_or(0)
}

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
pub(crate) mod tests;

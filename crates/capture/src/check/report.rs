//! Report of a check.

use bendtwin_core::{Finding, Severity};
use serde::{Deserialize, Serialize};

use crate::{Error, Sources};

/// Remark of a reader that did not fail.
#[derive(Debug)]
pub(crate) struct Note(pub(crate) Finding);

impl Note {
    pub(crate) fn info(code: &str, message: String) -> Self {
        Self(Finding::from_sentence(Severity::Info, code, message))
    }
}

/// Everything that a check found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckReport {
    /// Findings, the worst first.
    pub findings: Vec<Finding>,
    /// What was taken as what, and what was left out; empty if a format leaves no choice.
    #[serde(default, skip_serializing_if = "Sources::is_empty")]
    pub sources: Sources,
}

impl CheckReport {
    /// `true` if a fit can run: there is no error.
    pub fn is_usable(&self) -> bool {
        self.of(Severity::Error).next().is_none()
    }

    /// Findings of one severity.
    pub fn of(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |f| f.severity == severity)
    }

    /// `true` if a code was found.
    pub fn has(&self, code: &str) -> bool {
        self.findings.iter().any(|f| f.code == code)
    }

    /// Turns errors into one failure that names them all.
    ///
    /// # Errors
    /// [`Error::Unusable`] if the report has an error.
    pub fn require(&self) -> Result<(), Error> {
        let Some(first) = self.of(Severity::Error).next() else { return Ok(()) };
        let all: Vec<String> = self.of(Severity::Error).map(Finding::sentence).collect();
        Err(Error::Unusable { code: first.code.clone(), message: all.join("; ") })
    }
}

/// Most messages that are kept of one code; a capture of 70 sequences with one
/// fault should not say it 70 times.
const PER_CODE: usize = 3;

/// Sorts by severity, shortens repetitions and separates messages from advice.
pub(super) fn merge(findings: Vec<Finding>) -> Vec<Finding> {
    let mut kept: Vec<Finding> = Vec::new();
    let mut dropped: Vec<(String, Severity, usize)> = Vec::new();
    for finding in findings {
        if kept.iter().filter(|f| f.code == finding.code).count() < PER_CODE {
            kept.push(finding.split());
            continue;
        }
        match dropped.iter_mut().find(|(code, ..)| *code == finding.code) {
            Some((_, _, count)) => *count += 1,
            None => dropped.push((finding.code, finding.severity, 1)),
        }
    }
    for (code, severity, count) in dropped {
        let message = format!("the same in {count} more places");
        kept.push(Finding::new(severity, &code, message));
    }
    kept.sort_by_key(|f| f.severity);
    kept
}

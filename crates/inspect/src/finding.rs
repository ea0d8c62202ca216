//! The verdict of a report, and the order of its findings.

use bendtwin_core::Severity;
use serde::{Deserialize, Serialize};

use crate::{Code, Finding};

/// Judgement of a recording as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing limits the twin.
    Good,
    /// A fit will run; the warnings say what makes the twin worse than it could be.
    Usable,
    /// A fit is impossible or meaningless.
    Unusable,
}

impl Verdict {
    /// The verdict that findings amount to.
    pub fn of(findings: &[Finding]) -> Self {
        match findings.iter().map(|f| f.severity).min() {
            Some(Severity::Error) => Self::Unusable,
            Some(Severity::Warning) => Self::Usable,
            _ => Self::Good,
        }
    }
}

/// Gives each finding without advice the one of its code.
pub(crate) fn advise(findings: &mut [Finding]) {
    for finding in findings.iter_mut().filter(|f| f.advice.is_empty()) {
        let advice = Code::named(&finding.code).map_or("", Code::advice);
        advice.clone_into(&mut finding.advice);
    }
}

/// Sorts findings: the worst first, and what has to be repaired first before what follows from it.
pub(crate) fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| {
        let key = |f: &Finding| (f.severity, Code::rank(&f.code));
        key(a).cmp(&key(b)).then_with(|| a.cameras.cmp(&b.cameras))
    });
}

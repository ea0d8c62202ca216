//! What a report finds, and what it makes of all of it.

use std::collections::BTreeMap;

use bendtwin_capture::{Severity, check};
use serde::{Deserialize, Serialize};

use crate::codes;

/// Most frames that a finding names.
const FRAMES: usize = 20;

/// One thing that is wrong with a recording, or worth knowing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Stable UPPER_SNAKE_CASE word for programs; [`crate::CODES`] has them all.
    pub code: String,
    /// What is wrong, with numbers, for a person.
    pub message: String,
    /// What to do about it.
    pub advice: String,
    /// Indices of the cameras concerned; empty if it concerns all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<usize>,
    /// The first frames concerned, at most 20; empty if it concerns all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<usize>,
    /// The numbers of the message by name, with their unit in it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
}

impl Finding {
    fn new(severity: Severity, code: &str, message: String) -> Self {
        Self {
            severity,
            code: code.to_owned(),
            message,
            advice: codes::advice(code).to_owned(),
            cameras: Vec::new(),
            frames: Vec::new(),
            numbers: BTreeMap::new(),
        }
    }

    pub(crate) fn error(code: &str, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message.into())
    }

    pub(crate) fn warning(code: &str, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, message.into())
    }

    pub(crate) fn info(code: &str, message: impl Into<String>) -> Self {
        Self::new(Severity::Info, code, message.into())
    }

    /// An error if `is_error`, else a warning.
    pub(crate) fn graded(is_error: bool, code: &str, message: impl Into<String>) -> Self {
        let severity = if is_error { Severity::Error } else { Severity::Warning };
        Self::new(severity, code, message.into())
    }

    pub(crate) fn cameras(mut self, cameras: impl IntoIterator<Item = usize>) -> Self {
        self.cameras = cameras.into_iter().collect();
        self
    }

    pub(crate) fn frames(mut self, frames: impl IntoIterator<Item = usize>) -> Self {
        self.frames = frames.into_iter().take(FRAMES).collect();
        self
    }

    /// Keeps a number; one that is not finite is left out, since JSON cannot hold it.
    pub(crate) fn number(mut self, name: &str, value: f64) -> Self {
        if value.is_finite() {
            self.numbers.insert(name.to_owned(), value);
        }
        self
    }

    /// Message and advice in one sentence.
    pub fn sentence(&self) -> String {
        match self.advice.as_str() {
            "" => self.message.clone(),
            advice => format!("{}: {advice}", self.message),
        }
    }
}

impl From<check::Finding> for Finding {
    fn from(found: check::Finding) -> Self {
        // The message of a check says what to do after its last colon.
        let (message, advice) = match found.message.rsplit_once(": ") {
            Some((message, advice)) => (message.to_owned(), advice.to_owned()),
            None => (found.message, String::new()),
        };
        Self { advice, ..Self::new(found.severity, &found.code, message) }
    }
}

impl From<&Finding> for check::Finding {
    fn from(found: &Finding) -> Self {
        Self { severity: found.severity, code: found.code.clone(), message: found.sentence() }
    }
}

/// Judgement of a recording as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing holds the twin back.
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

/// Sorts findings: the worst first, and what has to be repaired first before what follows from it.
pub(crate) fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| {
        let key = |f: &Finding| (f.severity, codes::rank(&f.code));
        key(a).cmp(&key(b)).then_with(|| a.cameras.cmp(&b.cameras))
    });
}

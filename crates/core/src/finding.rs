//! Findings: faults of a capture, and their remedies.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Most frames that a finding names.
const MOST_FRAMES: usize = 20;

/// Severity of a finding, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// A fit is impossible or meaningless.
    Error,
    /// A fit will run, and be worse than it could be.
    Warning,
    /// Worth knowing.
    Info,
}

/// A fault of a capture, or a fact about it worth knowing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Severity.
    pub severity: Severity,
    /// Stable UPPER_SNAKE_CASE word for programs.
    pub code: String,
    /// Description of the fault, with numbers, for a person.
    pub message: String,
    /// Remedy; empty if no remedy is known.
    #[serde(default)]
    pub advice: String,
    /// Indices of the cameras concerned; empty if it concerns all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<usize>,
    /// The first frames concerned, at most 20; empty if it concerns all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<usize>,
    /// Codes of findings that merely follow from this one and are left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub consequences: Vec<String>,
    /// The numbers of the message by name, with their unit in it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
}

impl Finding {
    /// A finding without advice.
    pub fn new(severity: Severity, code: impl AsRef<str>, message: impl Into<String>) -> Self {
        Self {
            severity,
            code: code.as_ref().to_owned(),
            message: message.into(),
            advice: String::new(),
            cameras: Vec::new(),
            frames: Vec::new(),
            consequences: Vec::new(),
            numbers: BTreeMap::new(),
        }
    }

    /// A finding of a sentence that ends in advice after its last colon, `3 files are damaged: copy
    /// them again` say.
    pub fn from_sentence(
        severity: Severity,
        code: impl AsRef<str>,
        sentence: impl Into<String>,
    ) -> Self {
        Self::new(severity, code, sentence).split()
    }

    /// An error without advice.
    pub fn error(code: impl AsRef<str>, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// A warning without advice.
    pub fn warning(code: impl AsRef<str>, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, message)
    }

    /// A remark without advice.
    pub fn info(code: impl AsRef<str>, message: impl Into<String>) -> Self {
        Self::new(Severity::Info, code, message)
    }

    /// An error if `is_error`, else a warning.
    pub fn graded(is_error: bool, code: impl AsRef<str>, message: impl Into<String>) -> Self {
        let severity = if is_error { Severity::Error } else { Severity::Warning };
        Self::new(severity, code, message)
    }

    /// Sets the cameras concerned.
    #[must_use]
    pub fn cameras(mut self, cameras: impl IntoIterator<Item = usize>) -> Self {
        self.cameras = cameras.into_iter().collect();
        self
    }

    /// Sets the frames concerned, of which the first 20 are kept.
    #[must_use]
    pub fn frames(mut self, frames: impl IntoIterator<Item = usize>) -> Self {
        self.frames = frames.into_iter().take(MOST_FRAMES).collect();
        self
    }

    /// Keeps a number; one that is not finite is left out, since JSON cannot hold it.
    #[must_use]
    pub fn number(mut self, name: &str, value: f64) -> Self {
        if value.is_finite() {
            self.numbers.insert(name.to_owned(), value);
        }
        self
    }

    /// Adds the code of a finding that follows from this one.
    #[must_use]
    pub fn explains(mut self, code: impl AsRef<str>) -> Self {
        let code = code.as_ref();
        if !self.consequences.iter().any(|known| known == code) {
            self.consequences.push(code.to_owned());
        }
        self
    }

    /// Moves what stands after the last colon of the message to the advice, unless there is advice
    /// already.
    #[must_use]
    pub fn split(mut self) -> Self {
        if self.advice.is_empty()
            && let Some((message, advice)) = self.message.rsplit_once(": ")
        {
            (self.message, self.advice) = (message.to_owned(), advice.to_owned());
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

#[cfg(test)]
mod tests;

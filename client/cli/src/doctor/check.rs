//! A check of `doctor` and its outcome.

use std::fmt;

use serde::Serialize;

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum State {
    /// In order.
    Ok,
    /// Worth knowing; everything works.
    Note,
    /// Something will not work.
    Problem,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Ok => "ok",
            Self::Note => "note",
            Self::Problem => "PROBLEM",
        })
    }
}

/// A check: its subject, outcome, and the state found with what to do about it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Check {
    pub(super) name: &'static str,
    pub(super) state: State,
    pub(super) message: String,
}

impl Check {
    pub(super) fn ok(name: &'static str, message: impl Into<String>) -> Self {
        Self { name, state: State::Ok, message: message.into() }
    }

    pub(super) fn note(name: &'static str, message: impl Into<String>) -> Self {
        Self { name, state: State::Note, message: message.into() }
    }

    pub(super) fn problem(name: &'static str, message: impl Into<String>) -> Self {
        Self { name, state: State::Problem, message: message.into() }
    }
}

//! Remarks of a reader that did not fail.

use bendtwin_core::Finding;

use crate::{Sources, check::Note};

/// What a reader of tracked points noticed, and what it took as what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remarks {
    /// What it noticed.
    pub findings: Vec<Finding>,
    /// What was taken as what; empty if the format leaves no choice.
    pub sources: Sources,
}

impl Remarks {
    pub(crate) fn add(&mut self, notes: Vec<Note>) {
        self.findings.extend(notes.into_iter().map(|note| note.0));
    }

    pub(crate) fn extend(&mut self, other: Self) {
        self.findings.extend(other.findings);
        self.sources.extend(other.sources);
    }
}

impl IntoIterator for Remarks {
    type Item = Finding;
    type IntoIter = std::vec::IntoIter<Finding>;

    fn into_iter(self) -> Self::IntoIter {
        self.findings.into_iter()
    }
}

//! Labels of workers, and what jobs ask of a worker.

use bendtwin_proto::v1::WorkerRequirements;
use bendtwin_store::Requirements;

use super::{Error, Result};

/// Backends that a job can ask for; empty means either.
const BACKENDS: [&str; 3] = ["", "cpu", "cuda"];
/// Most labels of a worker, and of a job.
const MAX_LABELS: usize = 32;
/// Longest label [characters].
const LABEL_LENGTH: usize = 50;

/// Requirements as a message states them; absent means any worker.
pub(crate) fn of(wire: Option<WorkerRequirements>) -> Requirements {
    let WorkerRequirements { backend, memory_bytes, labels } = wire.unwrap_or_default();
    Requirements { backend, memory_bytes, labels, ..Requirements::default() }
}

/// Refuses what no worker could have.
pub(super) fn check(requirements: &Requirements) -> Result<()> {
    let backend = &requirements.backend;
    if !BACKENDS.contains(&backend.as_str()) {
        let fault = format!("is {backend:.20?}: use \"cpu\" or \"cuda\", or leave it out");
        return Err(Error::invalid("requirements.backend", fault));
    }
    check_labels("requirements.labels", &requirements.labels)
}

/// Refuses labels that are too many, too long, or no single words.
pub(super) fn check_labels(field: &'static str, labels: &[String]) -> Result<()> {
    if labels.len() > MAX_LABELS {
        return Err(Error::invalid(field, format!("has more than {MAX_LABELS} labels")));
    }
    let is_word = |label: &String| {
        let separates = |c: char| c == ',' || c.is_whitespace() || c.is_control();
        (1..=LABEL_LENGTH).contains(&label.chars().count()) && !label.contains(separates)
    };
    match labels.iter().all(is_word) {
        true => Ok(()),
        false => Err(Error::invalid(
            field,
            format!("takes words of up to {LABEL_LENGTH} characters without spaces and commas"),
        )),
    }
}

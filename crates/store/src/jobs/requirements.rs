//! Requirements of a job to its worker, and what a worker offers.

use semver::Version;
use serde::{Deserialize, Serialize};

use super::Kind;
use crate::{
    Error, Result,
    sql::{Transaction, query_scalar},
};

/// Most different requirements in the queue: a claim checks each.
pub(super) const MAX_DIFFERENT: usize = 256;

/// Different requirements of queued jobs of a kind, each found in an index after the one before.
pub(crate) const DIFFERENT: &str = "with recursive different (requirements) as (
         select (select requirements from jobs where state = 'queued' and kind = $1
             order by kind, requirements, owner, priority desc, due_at, id limit 1)
         union all
         select (select requirements from jobs
             where state = 'queued' and kind = $1 and requirements > before.requirements
             order by kind, requirements, owner, priority desc, due_at, id limit 1)
         from different as before where before.requirements is not null)
     select requirements from different where requirements is not null";

/// Worker that a job asks for; by default any.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(default)]
pub struct Requirements {
    /// `cpu` or `cuda`; empty means either.
    pub backend: String,
    /// Memory of the device at least [bytes]; on a CPU, that which a fit may take.
    pub memory_bytes: u64,
    /// Labels that the worker must have.
    pub labels: Vec<String>,
    /// Version of the worker's program at least.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<Version>,
    /// True for an ingest that took long before: a worker begins it only where others do not wait for its end.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub long: bool,
}

impl Requirements {
    /// Canonical text of the requirements; empty for none.
    pub(crate) fn to_text(&self) -> Result<String> {
        let mut sorted = self.clone();
        sorted.labels.sort();
        sorted.labels.dedup();
        if sorted == Self::default() {
            return Ok(String::new());
        }
        serde_json::to_string(&sorted).map_err(|e| Error::Io(std::io::Error::other(e.to_string())))
    }

    /// Requirements from their text, as far as this version knows them.
    pub(crate) fn from_text(text: &str) -> serde_json::Result<Self> {
        if text.is_empty() { Ok(Self::default()) } else { serde_json::from_str(text) }
    }

    /// What was asked for, without what became known since.
    pub(crate) fn asked(&self) -> Self {
        Self { long: false, ..self.clone() }
    }

    /// All requirements of a text; none if it has some of a newer version.
    pub(super) fn known(text: &str) -> Option<Self> {
        let requirements = Self::from_text(text).ok()?;
        (requirements.to_text().ok()? == text).then_some(requirements)
    }
}

/// Properties of a worker that jobs can ask for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// `cpu` or `cuda`.
    pub backend: String,
    /// Memory of its device; of a CPU, that which a fit may take [bytes].
    pub memory_bytes: u64,
    /// Words that it was started with.
    pub labels: Vec<String>,
    /// Version of its program, if it is known.
    pub version: Option<Version>,
    /// True if it asks for brief jobs alone.
    pub brief: bool,
}

impl Capabilities {
    /// True if the worker is one that these ask for.
    pub fn satisfies(&self, requirements: &Requirements) -> bool {
        let Requirements { backend, memory_bytes, labels, version, long } = requirements;
        (backend.is_empty() || *backend == self.backend)
            && *memory_bytes <= self.memory_bytes
            && labels.iter().all(|label| self.labels.contains(label))
            && *version <= self.version
            && !(*long && self.brief)
    }
}

/// Requirements of the queued jobs of a kind, each once, as their texts.
pub(super) async fn queued(tx: &mut Transaction, kind: Kind) -> Result<Vec<String>> {
    query_scalar(DIFFERENT).bind(kind.as_str()).fetch_all(tx).await
}

/// Refuses requirements that would exceed the number of kinds that a claim checks.
pub(super) async fn admit(tx: &mut Transaction, kind: Kind, text: &str) -> Result<()> {
    if text.is_empty() {
        return Ok(());
    }
    let queued = queued(tx, kind).await?;
    if queued.len() < MAX_DIFFERENT || queued.iter().any(|before| before == text) {
        return Ok(());
    }
    Err(Error::TooManyRequirements { limit: MAX_DIFFERENT })
}

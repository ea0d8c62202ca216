//! Names of jobs. The collection gives the kind.

use std::{fmt, str::FromStr};

use bendtwin_core::ids::{FitId, IngestId, InvalidName};
use uuid::Uuid;

/// Kind of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Capture in, observation and report out.
    Ingest,
    /// Observation in, twin out.
    Fit,
}

impl Kind {
    /// Name of the kind in the database and in metrics.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Ingest => "ingest",
            Self::Fit => "fit",
        }
    }

    pub(super) fn parse(word: &str) -> Option<Self> {
        [Self::Ingest, Self::Fit].into_iter().find(|k| k.as_str() == word)
    }
}

/// The id of a job of either kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JobId {
    /// `ingests/{uuid}`
    Ingest(IngestId),
    /// `fits/{uuid}`
    Fit(FitId),
}

impl JobId {
    /// Kind of the job.
    pub fn kind(self) -> Kind {
        match self {
            Self::Ingest(_) => Kind::Ingest,
            Self::Fit(_) => Kind::Fit,
        }
    }

    /// The bare UUID.
    pub fn uuid(self) -> Uuid {
        match self {
            Self::Ingest(id) => id.uuid(),
            Self::Fit(id) => id.uuid(),
        }
    }

    /// The fit's id, if it is one.
    pub fn fit(self) -> Option<FitId> {
        match self {
            Self::Fit(id) => Some(id),
            Self::Ingest(_) => None,
        }
    }

    /// Id from the columns of a row.
    pub(crate) fn stored(kind: &str, id: &str) -> Option<Self> {
        Some(Self::new(Kind::parse(kind)?, Uuid::try_parse(id).ok()?))
    }

    pub(super) fn new(kind: Kind, uuid: Uuid) -> Self {
        match kind {
            Kind::Ingest => Self::Ingest(uuid.into()),
            Kind::Fit => Self::Fit(uuid.into()),
        }
    }
}

impl From<FitId> for JobId {
    fn from(id: FitId) -> Self {
        Self::Fit(id)
    }
}

impl From<IngestId> for JobId {
    fn from(id: IngestId) -> Self {
        Self::Ingest(id)
    }
}

/// The name, `collection/uuid`.
impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ingest(id) => id.fmt(f),
            Self::Fit(id) => id.fmt(f),
        }
    }
}

/// Parses full names only: a bare UUID does not give the kind.
impl FromStr for JobId {
    type Err = InvalidName;
    fn from_str(name: &str) -> Result<Self, InvalidName> {
        if name.starts_with(IngestId::COLLECTION) {
            return name.parse().map(Self::Ingest);
        }
        if name.contains('/') {
            return name.parse().map(Self::Fit);
        }
        let given = name.chars().take(80).collect();
        Err(InvalidName { collection: "fits or ingests", given })
    }
}

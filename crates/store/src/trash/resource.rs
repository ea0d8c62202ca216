//! The resources that can be in the trash.

use std::fmt;

use bendtwin_core::ids::{CaptureId, FitId, TwinId};
use uuid::Uuid;

use crate::{labels::Collection, owners::deleted_requests::Kind};

/// Name of a capture, a fit or a twin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Resource {
    /// `captures/{uuid}`
    Capture(CaptureId),
    /// `fits/{uuid}`
    Fit(FitId),
    /// `twins/{uuid}`
    Twin(TwinId),
}

impl Resource {
    pub(crate) fn new(collection: Collection, id: Uuid) -> Self {
        match collection {
            Collection::Captures => Self::Capture(id.into()),
            Collection::Fits => Self::Fit(id.into()),
            Collection::Twins => Self::Twin(id.into()),
        }
    }

    /// The collection that it belongs to.
    pub fn collection(self) -> Collection {
        match self {
            Self::Capture(_) => Collection::Captures,
            Self::Fit(_) => Collection::Fits,
            Self::Twin(_) => Collection::Twins,
        }
    }

    /// The bare UUID.
    pub fn uuid(self) -> Uuid {
        match self {
            Self::Capture(id) => id.uuid(),
            Self::Fit(id) => id.uuid(),
            Self::Twin(id) => id.uuid(),
        }
    }

    /// The id as rows have it.
    pub(crate) fn key(self) -> String {
        self.uuid().to_string()
    }

    /// The kind of its request id.
    pub(super) fn requests(self) -> Kind {
        match self {
            Self::Capture(_) => Kind::Captures,
            Self::Fit(_) => Kind::Jobs,
            Self::Twin(_) => Kind::Twins,
        }
    }
}

impl fmt::Display for Resource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Capture(id) => id.fmt(f),
            Self::Fit(id) => id.fmt(f),
            Self::Twin(id) => id.fmt(f),
        }
    }
}

impl From<CaptureId> for Resource {
    fn from(id: CaptureId) -> Self {
        Self::Capture(id)
    }
}

impl From<FitId> for Resource {
    fn from(id: FitId) -> Self {
        Self::Fit(id)
    }
}

impl From<TwinId> for Resource {
    fn from(id: TwinId) -> Self {
        Self::Twin(id)
    }
}

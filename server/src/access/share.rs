//! Shares: what the holder of a key that is limited to one twin may call. Anything that is not listed here
//! is refused, for any scope; that the twin of a call is the one of the share is for the use
//! cases (`app/rights.rs`).

use bendtwin_core::{
    Problem,
    ids::{KeyId, ShareId, TwinId},
};
use bendtwin_store::Key;

use super::{Grant, Scopes};

/// Words in the place of scopes. Programs that know no shares do not know them, and so allow nothing.
pub(crate) const SHARE: &str = "share";
pub(crate) const EXPORT: &str = "share:export";

/// Scopes of the calls below.
const SCOPES: [&str; 2] = ["twins:read", "rollouts:run"];

/// Calls that every share allows.
const LOOK_AND_PLAY: [&str; 10] = [
    // What the share allows, and until when.
    "GET /v1/caller",
    "/bendtwin.v1.SignInService/GetCaller",
    "GET /v1/twins/{id}",
    "/bendtwin.v1.TwinService/GetTwin",
    "GET /v1/twins/{id}/geometry",
    "/bendtwin.v1.TwinService/GetTwinGeometry",
    "GET /v1/twins/{id}/surface",
    "/bendtwin.v1.TwinService/GetTwinSurface",
    "GET /v1/twins/{id}/thumbnail",
    "GET /v1/twins/{id}/play",
];

/// Calls that a share allows which was made for it.
const DOWNLOADS: [&str; 3] = [
    "GET /v1/twins/{id}/content",
    "/bendtwin.v1.TwinService/ExportTwin",
    "GET /v1/twins/{id}/export",
];

/// A share, as its holder shows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedTwin {
    pub(crate) share: ShareId,
    pub(crate) twin: TwinId,
    may_export: bool,
}

/// What the holder of a share may not do.
#[derive(Debug, thiserror::Error, Problem)]
pub(crate) enum Limited {
    #[error("this link is for looking at {0} and playing with it, and for nothing else")]
    #[problem(PermissionDenied, "SHARE_LIMITED")]
    ToTwin(TwinId),
    #[error(
        "this link does not allow downloads of {0}: ask the person who sent it for one that does \
         (`bendtwin twin share --allow-export`)"
    )]
    #[problem(PermissionDenied, "SHARE_LIMITED")]
    WithoutExport(TwinId),
}

/// The share that has the same UUID as its key.
pub(crate) fn share_of(key: KeyId) -> ShareId {
    key.uuid().into()
}

/// True if the holder of a share may download its twin.
pub(crate) fn may_export(key: &Key) -> bool {
    key.scopes.iter().any(|word| word == EXPORT)
}

impl SharedTwin {
    /// The share of a key; none if it is not one.
    pub(super) fn of(key: &Key) -> Option<Self> {
        let share = key.share.as_ref()?;
        Some(Self { share: share_of(key.id), twin: share.twin, may_export: may_export(key) })
    }

    /// The scopes of a share, within which its calls are.
    pub(super) fn scopes(key: &Key) -> Scopes {
        let is_known = key.scopes.iter().any(|word| word == SHARE);
        SCOPES.into_iter().filter(|_| is_known).filter_map(Grant::parse).collect()
    }

    /// Refuses a call that is not for holders of this share.
    pub(super) fn require(&self, call: &str) -> Result<(), Limited> {
        if LOOK_AND_PLAY.contains(&call) || self.may_export && DOWNLOADS.contains(&call) {
            return Ok(());
        }
        if DOWNLOADS.contains(&call) {
            return Err(Limited::WithoutExport(self.twin));
        }
        Err(Limited::ToTwin(self.twin))
    }
}

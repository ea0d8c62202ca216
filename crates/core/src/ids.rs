//! Typed ids. Resources are named `captures/{id}`, `fits/{id}`, `twins/{id}`, `uploads/{id}`,
//! `sessions/{id}`, `plays/{id}`, `workers/{id}`, `keys/{id}`, `shares/{id}`, `projects/{id}` and `retention/{id}`, what
//! is no resource `ingests/{id}` and `servers/{id}`; ids are UUIDv7, so they sort by creation time.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use uuid::Uuid;

/// A resource name that does not parse.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{given}` is not a name of the form {collection}/{{uuid}}")]
pub struct InvalidName {
    /// The collection that was expected.
    pub collection: &'static str,
    /// The given text, cut to 80 characters.
    pub given: String,
}

macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $collection:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(into = "String", try_from = "String")]
        pub struct $name(Uuid);

        impl $name {
            /// The collection part of the name.
            pub const COLLECTION: &'static str = $collection;

            /// A new id; later ids sort after earlier ones.
            pub fn generate() -> Self {
                Self(Uuid::now_v7())
            }

            /// The bare UUID.
            pub fn uuid(self) -> Uuid {
                self.0
            }
        }

        impl From<Uuid> for $name {
            fn from(uuid: Uuid) -> Self {
                Self(uuid)
            }
        }

        /// The resource name, `collection/uuid`.
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($collection, "/{}"), self.0)
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(self, f)
            }
        }

        /// Takes the full name `collection/uuid` or the bare UUID.
        impl FromStr for $name {
            type Err = InvalidName;
            fn from_str(s: &str) -> Result<Self, InvalidName> {
                let bare = s.strip_prefix(concat!($collection, "/")).unwrap_or(s);
                Uuid::parse_str(bare).map(Self).map_err(|_| InvalidName {
                    collection: $collection,
                    given: s.chars().take(80).collect(),
                })
            }
        }

        impl TryFrom<String> for $name {
            type Error = InvalidName;
            fn try_from(s: String) -> Result<Self, InvalidName> {
                s.parse()
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> String {
                id.to_string()
            }
        }
    };
}

id!(
    /// A stored capture.
    CaptureId, "captures"
);
id!(
    /// A fit job.
    FitId, "fits"
);
id!(
    /// A job that reads a capture, from the upload to the observation that is fitted.
    IngestId, "ingests"
);
id!(
    /// A fitted twin.
    TwinId, "twins"
);
id!(
    /// A worker process, new at every start: a restarted worker is another one.
    WorkerId, "workers"
);
id!(
    /// A server process, new at every start.
    ServerId, "servers"
);
id!(
    /// A rule by which servers delete.
    RetentionId, "retention"
);
id!(
    /// A simulation that lives at a worker between calls.
    SessionId, "sessions"
);
id!(
    /// A simulation in real time that a person plays with.
    PlayId, "plays"
);
id!(
    /// An upload that can be resumed.
    UploadId, "uploads"
);
id!(
    /// A key with which a client identifies itself.
    KeyId, "keys"
);
id!(
    /// A share of a twin: a key that is limited to it, which has the same UUID.
    ShareId, "shares"
);
id!(
    /// A set of owners who share what they have.
    ProjectId, "projects"
);

/// Leading bytes of a session's id that are its own; the others are the last ones of its worker's id.
const OWN_BYTES: usize = 12;

impl SessionId {
    /// A new id of a session at a worker.
    pub fn generate_at(worker: WorkerId) -> Self {
        let (mut bytes, of_worker) = (*Uuid::now_v7().as_bytes(), worker.uuid());
        let tail = bytes.iter_mut().zip(of_worker.as_bytes()).skip(OWN_BYTES);
        tail.for_each(|(byte, of_worker)| *byte = *of_worker);
        Self(Uuid::from_bytes(bytes))
    }

    /// True if it may be at this worker, false if it is not there.
    pub fn may_be_at(self, worker: WorkerId) -> bool {
        let (own, of_worker) = (self.0.as_bytes(), worker.uuid());
        own.iter().zip(of_worker.as_bytes()).skip(OWN_BYTES).all(|(own, other)| own == other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_names_its_worker() {
        let (here, there) = (WorkerId::generate(), WorkerId::generate());
        let (one, two) = (SessionId::generate_at(here), SessionId::generate_at(here));
        assert!(one != two && one.may_be_at(here) && two.may_be_at(here));
        assert!(!one.may_be_at(there));
        assert_eq!(one.uuid().get_version_num(), 7);
    }
}

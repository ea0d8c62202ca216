//! Keys that are not valid any more, and the refusals of those who show them.

use bendtwin_core::{Problem, ids::KeyId};
use bendtwin_store::Key;
use jiff::Timestamp;

/// The end of a key.
#[derive(Debug, thiserror::Error, Problem)]
pub(crate) enum Ended {
    #[error("{0} was revoked: have another key made with `bendtwin key create`")]
    #[problem(Unauthenticated, "KEY_REVOKED")]
    Revoked(KeyId),
    #[error("{0} expired at {1:.0}: have another key made with `bendtwin key create`")]
    #[problem(Unauthenticated, "KEY_EXPIRED")]
    Expired(KeyId, Timestamp),
    #[error(
        "the sign-in {0}: sign in again, with `bendtwin login` or on the login page of the console"
    )]
    #[problem(Unauthenticated, "SIGN_IN_ENDED")]
    SignIn(String),
    #[error("this link {0}: ask the person who sent it for a new one")]
    #[problem(Unauthenticated, "SHARE_ENDED")]
    Share(String),
}

impl Ended {
    /// The end of a key, if it has ended.
    pub(crate) fn of(key: &Key, now: Timestamp) -> Option<Self> {
        let expired = key.expires.filter(|end| *end <= now);
        if key.revoked.is_none() && expired.is_none() {
            return None;
        }
        let how = match (key.revoked, expired) {
            (None, Some(end)) => format!("expired at {end:.0}"),
            _ => "was revoked".to_owned(),
        };
        Some(match (key.revoked, expired) {
            _ if key.share.is_some() => Self::Share(how),
            _ if key.signed_in_as.is_some() => Self::SignIn(format!("{} {how}", key.id)),
            (None, Some(end)) => Self::Expired(key.id, end),
            _ => Self::Revoked(key.id),
        })
    }
}

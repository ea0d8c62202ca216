//! Access: which caller may make which call. A request shows the client token or a key; that makes it a [`Caller`] with
//! scopes. The table says which scope a route or an RPC takes, over both transports alike.

pub(crate) mod client_token;
mod gate;
mod in_flight;
pub(crate) mod key;
mod key_ring;
mod refusals;
mod table;
mod tokens;

use std::{sync::Arc, time::Instant};

use bendtwin_core::{Category, Fault, ids::KeyId};
use bendtwin_store::{Creator, Key, Quotas};

use self::refusals::{Refusals, Refused};
use crate::{audit, refusal::Refusal};

pub(crate) use gate::Gate;
pub(crate) use in_flight::{Flight, InFlight};
pub(crate) use key_ring::KeyRing;
pub use table::{Access, TABLE};
pub(crate) use table::{find, is_open, route_name};
pub(crate) use tokens::{Bearer, Child, Tokens};

/// Right to a kind of calls, which a key may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scope {
    /// Make, list and revoke keys.
    Admin,
    /// Read captures and everything that belongs to them.
    CapturesRead,
    /// Upload captures, add files to them, change, read again and delete them.
    CapturesWrite,
    /// Read fits and their losses.
    FitsRead,
    /// Start, change, cancel and delete fits.
    FitsWrite,
    /// Read the metrics of a server, and nothing else.
    MetricsRead,
    /// Rollouts, sessions, plays, plans, registrations and evaluations.
    RolloutsRun,
    /// Read and export twins.
    TwinsRead,
    /// Import, change and delete twins.
    TwinsWrite,
}

impl Scope {
    /// All scopes, in the order of their words.
    pub const ALL: [Self; 9] = [
        Self::Admin,
        Self::CapturesRead,
        Self::CapturesWrite,
        Self::FitsRead,
        Self::FitsWrite,
        Self::MetricsRead,
        Self::RolloutsRun,
        Self::TwinsRead,
        Self::TwinsWrite,
    ];

    /// The word of the scope in the API.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Admin => "admin",
            Self::CapturesRead => "captures:read",
            Self::CapturesWrite => "captures:write",
            Self::FitsRead => "fits:read",
            Self::FitsWrite => "fits:write",
            Self::MetricsRead => "metrics:read",
            Self::RolloutsRun => "rollouts:run",
            Self::TwinsRead => "twins:read",
            Self::TwinsWrite => "twins:write",
        }
    }

    /// The scope of a word.
    pub fn parse(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scope| scope.as_str() == word)
    }

    fn bit(self) -> u16 {
        1 << (self as u16)
    }
}

/// A set of scopes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Scopes(u16);

impl Scopes {
    pub(crate) const ALL: Self = Self(u16::MAX);

    pub(crate) fn has(self, scope: Scope) -> bool {
        self.0 & scope.bit() != 0
    }

    /// True if there is this scope alone.
    fn is(self, scope: Scope) -> bool {
        self.0 == scope.bit()
    }
}

impl FromIterator<Scope> for Scopes {
    fn from_iter<I: IntoIterator<Item = Scope>>(scopes: I) -> Self {
        Self(scopes.into_iter().fold(0, |bits, scope| bits | scope.bit()))
    }
}

/// The owner of what is made with the client token.
pub(crate) const TOKEN_OWNER: &str = "local";

/// The client of a request, as far as it has shown who it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Caller {
    /// Key of the request; `None` with the client token, or where no key is required.
    pub(crate) key: Option<KeyId>,
    /// Recorded with what it makes; empty where nothing is asked for.
    pub(crate) owner: Arc<str>,
    pub(crate) scopes: Scopes,
    pub(crate) quotas: Quotas,
    /// Calls under way of all callers.
    pub(crate) in_flight: InFlight,
    /// Refusals of all callers.
    pub(crate) refusals: Refusals,
}

impl Caller {
    /// Anyone, where no token is asked for.
    fn anyone() -> Self {
        Self { scopes: Scopes::ALL, ..Self::default() }
    }

    /// The holder of the client token.
    fn with_token() -> Self {
        Self { owner: TOKEN_OWNER.into(), ..Self::anyone() }
    }

    /// The holder of a key. Words that are not scopes allow nothing.
    fn with_key(key: &Key, in_flight: InFlight) -> Self {
        Self {
            key: Some(key.id),
            owner: key.owner.as_str().into(),
            scopes: key.scopes.iter().filter_map(|word| Scope::parse(word)).collect(),
            quotas: key.quotas,
            in_flight,
            ..Self::default()
        }
    }

    /// The caller as the maker of something.
    pub(crate) fn creator(&self) -> Creator {
        Creator { owner: self.owner.to_string(), quotas: self.quotas }
    }

    /// Lets a call in that the caller may make, and counts it as long as the result is held, if
    /// calls of its kind are bounded. The audit has what is refused under the name of the call.
    pub(crate) fn enter(
        &self,
        access: Option<Access>,
        call: &str,
    ) -> Result<Option<Flight>, Refusal> {
        self.require(access).inspect_err(|refusal| {
            let holder = Refused::Holder(self.key);
            if let Some(times) = self.refusals.note(holder, call, Instant::now()) {
                audit::refused(self, call, refusal.reason(), times);
            }
        })?;
        match (access, self.quotas.rollouts) {
            (Some(Access::Scope(Scope::RolloutsRun)), Some(limit)) => {
                self.in_flight.enter(&self.owner, limit).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Refuses what the caller may not do. `None` is what the table does not list: nobody may.
    fn require(&self, access: Option<Access>) -> Result<(), Refusal> {
        match access {
            // The metrics are a part of every scope.
            Some(Access::Open | Access::Worker | Access::Scope(Scope::MetricsRead)) => Ok(()),
            Some(Access::Anyone) if self.scopes.is(Scope::MetricsRead) => Err(denied(format!(
                "the key has the scope {} alone, which reads /metrics and nothing else: use another \
                 key",
                Scope::MetricsRead.as_str()
            ))),
            Some(Access::Anyone) => Ok(()),
            Some(Access::Scope(scope)) if self.scopes.has(scope) => Ok(()),
            Some(Access::Scope(scope)) => Err(denied(format!(
                "the key lacks the scope {}, which this call takes: use a key that has it, or have \
                 one made with `bendtwin key create --scope {}`",
                scope.as_str(),
                scope.as_str()
            ))),
            None => Err(denied("no scope allows this call".to_owned())),
        }
    }
}

fn denied(message: String) -> Refusal {
    Refusal::new(Fault {
        category: Category::PermissionDenied,
        reason: "SCOPE_MISSING".to_owned(),
        message,
    })
}

#[cfg(test)]
mod tests;

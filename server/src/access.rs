//! Access: which caller may make which call. A request shows the client token or a key; that makes it a [`Caller`] with
//! scopes. The table says which scope a route or an RPC takes, over both transports alike.

pub(crate) mod client_token;
mod ended;
mod gate;
mod in_flight;
pub(crate) mod key;
mod key_ring;
mod refusals;
mod scopes;
mod share;
mod table;
mod tokens;

use std::{sync::Arc, time::Instant};

use bendtwin_core::{Category, Fault, Problem as _, ids::KeyId};
use bendtwin_store::{Creator, Memberships, Quotas};

use crate::{audit, refusal::Refusal};

pub(crate) use ended::Ended;
pub(crate) use gate::Gate;
pub(crate) use in_flight::{Flight, InFlight};
pub(crate) use key_ring::{Holder, KeyRing};
pub(crate) use refusals::{Refusals, Refused};
pub use scopes::Scope;
pub(crate) use scopes::{Grant, Scopes};
pub(crate) use share::{EXPORT, Limited, SHARE, SharedTwin, may_export, share_of};
pub use table::{Access, TABLE};
pub(crate) use table::{PAGES, find, is_open, route_name};
pub(crate) use tokens::{Bearer, Child, Tokens};

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
    /// The share that it shows, which limits it to a twin.
    pub(crate) share: Option<SharedTwin>,
    /// The projects of all owners.
    memberships: Arc<Memberships>,
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
    fn with_key(holder: &Holder, in_flight: InFlight) -> Self {
        let Holder { key, memberships } = holder;
        let share = SharedTwin::of(key);
        Self {
            key: Some(key.id),
            owner: key.owner.as_str().into(),
            scopes: match share {
                Some(_) => SharedTwin::scopes(key),
                None => key.scopes.iter().filter_map(|word| Grant::parse(word)).collect(),
            },
            share,
            quotas: key.quotas,
            memberships: Arc::clone(memberships),
            in_flight,
            ..Self::default()
        }
    }

    /// True if a call for a scope may be about resources of an owner. Those whose owner is not known
    /// are for scopes without a bound.
    pub(crate) fn reaches(&self, scope: Scope, owner: &str) -> bool {
        let is_own = || self.owner.as_ref() == owner || self.memberships.share(&self.owner, owner);
        self.scopes.reach_all(scope) || !owner.is_empty() && self.scopes.has(scope) && is_own()
    }

    /// The owner to whom and to whose projects the scope is bound; `None` without a bound.
    pub(crate) fn bound(&self, scope: Scope) -> Option<String> {
        (!self.scopes.reach_all(scope)).then(|| self.owner.to_string())
    }

    /// The highest priority that the caller may give a fit.
    pub(crate) fn most_priority(&self) -> i32 {
        let most = most_priority(self.key.is_none() || self.scopes.has(Scope::Admin), self.quotas);
        i32::try_from(most).unwrap_or(i32::MAX)
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
        self.require(access, call).inspect_err(|refusal| {
            let holder = Refused::Holder(self.key);
            if let Some(times) = self.refusals.note(holder, call, Instant::now()) {
                audit::refused(self, call, refusal.reason(), times);
            }
        })?;
        // Plays of shares have another bound, and take nothing of what their owner may have.
        let bound = self.quotas.rollouts.filter(|_| self.share.is_none());
        match (access, bound) {
            (Some(Access::Scope(Scope::RolloutsRun)), Some(limit)) => {
                self.in_flight.enter(&self.owner, limit).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Refuses what the caller may not do. `None` is what the table does not list: nobody may.
    fn require(&self, access: Option<Access>, call: &str) -> Result<(), Refusal> {
        if let Some(share) = &self.share {
            share.require(call).map_err(|limited| Refusal::new(limited.fault()))?;
        }
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

/// The highest priority that fits may have.
pub(crate) const MOST_PRIORITY: u32 = 100;

/// The highest priority that the holder of a key may give a fit: normal, unless the key says otherwise
/// or its holder may make any key.
pub(crate) fn most_priority(is_admin: bool, quotas: Quotas) -> u32 {
    quotas.priority.unwrap_or(if is_admin { MOST_PRIORITY } else { 0 })
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

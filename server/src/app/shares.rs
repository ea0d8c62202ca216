//! Shares: links by which people without a token look at one twin and play with it. Their keys are rows
//! of the table of keys, `access/share.rs` lists what they allow, and `rights.rs` limits it to their twin.

use std::{sync::Arc, time::Duration};

use bendtwin_core::ids::{ShareId, TwinId};
use bendtwin_store::{Key, Labels, NewKey, NewShare, Page, PageRequest, Quotas, Twin, TwinFacts};
use jiff::{SignedDuration, Timestamp};

use super::{App, Error, Result, labels};
use crate::{
    access::{EXPORT, Flight, InFlight, SHARE, Scope, SharedTwin, key, share_of},
    audit,
    context::Context,
    options::ClientTokenPolicy,
};

const DAY: Duration = Duration::from_secs(86_400);
/// Time until a share expires, unless the request says otherwise, and the longest.
const USUAL: Duration = Duration::from_secs(7 * DAY.as_secs());
const LONGEST: Duration = Duration::from_secs(90 * DAY.as_secs());
/// Plays of a share that run at the same time at a server.
const MOST_PLAYS: u64 = 4;

/// A requested share.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShareOrder {
    pub(crate) twin: String,
    pub(crate) display_name: String,
    /// Zero means that `expires` says it, or [`USUAL`].
    pub(crate) ttl_s: u64,
    pub(crate) expires: Option<Timestamp>,
    pub(crate) may_export: bool,
}

/// Plays that were begun with shares. Clones share them.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedPlays {
    by_share: InFlight,
    all: InFlight,
}

/// The seat of a play that was begun with a share, until it is dropped.
#[derive(Debug)]
pub(super) struct Seat {
    _of_share: Flight,
    _of_all: Flight,
}

impl App {
    /// Makes a share. The text of its key is returned here and nowhere else.
    pub(crate) async fn share_twin(&self, order: ShareOrder) -> Result<(Key, String)> {
        let done: Result<(Key, String)> = async {
            let twin: TwinId = self.reach(Scope::TwinsWrite, &order.twin).await?;
            let caller = Context::current().caller;
            if !caller.scopes.has(Scope::RolloutsRun) {
                return Err(Error::ShareWithoutRollouts);
            }
            self.reach::<TwinId>(Scope::RolloutsRun, &order.twin).await?;
            self.store.twins().get(twin).await?;
            let display_name = labels::display_name(order.display_name)?;
            let expires = end(self.store.now(), order.ttl_s, order.expires)?;
            if self.options.client_token == ClientTokenPolicy::None {
                return Err(Error::ShareNotNeeded { twin });
            }
            self.require_room(0)?;
            let made = key::make().map_err(|e| Error::Internal(format!("random numbers: {e}")))?;
            let words = [Some(SHARE), order.may_export.then_some(EXPORT)];
            let key = NewKey {
                id: made.id,
                display_name,
                owner: caller.owner.to_string(),
                hash: made.hash,
                scopes: words.into_iter().flatten().map(str::to_owned).collect(),
                quotas: Quotas::default(),
                expires: Some(expires),
                signed_in_as: None,
            };
            let new = NewShare { key, twin, by: caller.key };
            let store = self.store.clone();
            let key = self.change(async move { store.keys().share(new).await }).await?;
            self.keys.learn(&key);
            tracing::info!(share = %share_of(key.id), %twin, owner = key.owner, "twin shared");
            Ok((key, made.text))
        }
        .await;
        audit::made("ShareTwin", &done, |(key, _)| {
            let twin = key.share.as_ref().map(|share| share.twin.to_string()).unwrap_or_default();
            format!("{} of {twin}", share_of(key.id))
        });
        done
    }

    /// A page of the shares of a twin.
    pub(crate) async fn list_shares(&self, twin: &str, page: &PageRequest) -> Result<Page<Key>> {
        let twin: TwinId = self.reach(Scope::TwinsWrite, twin).await?;
        Ok(self.store.keys().shares_of(twin, page).await?)
    }

    /// Revokes a share, here immediately, and at other servers once they read it again.
    pub(crate) async fn revoke_share(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let id: ShareId = self.reach(Scope::TwinsWrite, name).await?;
            let (key, share) = self.store.keys().get_share(id).await?;
            let key = self.revoke(key.id).await?;
            tracing::info!(share = %id, twin = %share.twin, owner = key.owner, "share revoked");
            Ok(())
        }
        .await;
        audit::changed("DeleteShare", name, &done);
        done
    }

    /// The seat of a play that the caller begins, if it shows a share.
    pub(super) fn share_seat(&self) -> Result<Option<Seat>> {
        let Some(SharedTwin { share, .. }) = Context::current().caller.share else {
            return Ok(None);
        };
        let share: Arc<str> = share.to_string().into();
        let of_share = self.shared_plays.by_share.count(&share, MOST_PLAYS);
        // Some of the plays of the server are always left to people with a token.
        let most = (self.options.limits.plays as u64).div_ceil(2);
        let of_all = self.shared_plays.all.count(&"".into(), most);
        match (of_share, of_all) {
            (Some(of_share), Some(of_all)) => {
                Ok(Some(Seat { _of_share: of_share, _of_all: of_all }))
            }
            (None, _) => Err(Error::ShareFull { by: "this link", most: MOST_PLAYS }),
            (_, None) => Err(Error::ShareFull { by: "links of this server", most }),
        }
    }
}

/// The time at which a share expires.
fn end(now: Timestamp, ttl_s: u64, expires: Option<Timestamp>) -> Result<Timestamp> {
    if let Some(expires) = expires {
        if ttl_s != 0 {
            return Err(Error::invalid("expire_time", "stands beside `ttl_s`: give one of them"));
        }
        if expires <= now {
            return Err(Error::invalid("expire_time", "is past: choose a later time"));
        }
        if expires > later(now, LONGEST) {
            return Err(Error::invalid("expire_time", "is more than 90 days from now"));
        }
        return Ok(expires);
    }
    match Duration::from_secs(ttl_s) {
        Duration::ZERO => Ok(later(now, USUAL)),
        ttl if ttl <= LONGEST => Ok(later(now, ttl)),
        _ => Err(Error::invalid("ttl_s", format!("is more than 90 days, {} s", LONGEST.as_secs()))),
    }
}

fn later(now: Timestamp, by: Duration) -> Timestamp {
    let by = SignedDuration::try_from(by).unwrap_or(SignedDuration::MAX);
    now.saturating_add(by).unwrap_or(Timestamp::MAX)
}

/// The part of a twin that holders of a share see: what it is called and how large it is, and nothing
/// of the people who made it, of what else they have, or of what they wrote about it.
pub(super) fn for_visitors(twin: Twin) -> Twin {
    Twin {
        labels: Labels { display_name: twin.labels.display_name, ..Labels::default() },
        capture: None,
        fit: None,
        error_m: None,
        owner: String::new(),
        facts: TwinFacts { quality: "{}".to_owned(), ..twin.facts },
        ..twin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_expire_within_ninety_days() {
        let now = Timestamp::UNIX_EPOCH;
        let after = |days: i64| now + SignedDuration::from_hours(24 * days);
        let days = |days: u64| days * DAY.as_secs();
        assert_eq!(end(now, 0, None).unwrap(), after(7));
        assert_eq!(end(now, days(90), None).unwrap(), after(90));
        assert_eq!(end(now, 0, Some(after(90))).unwrap(), after(90));
        assert!(end(now, days(90) + 1, None).is_err());
        assert!(end(now, u64::MAX, None).is_err());
        assert!(end(now, 0, Some(after(91))).is_err());
        assert!(end(now, 0, Some(now)).is_err());
        assert!(end(now, 1, Some(after(1))).is_err());
    }
}

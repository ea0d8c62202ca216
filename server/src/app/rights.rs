//! Rights between people: a name that a client sends becomes an id here alone, once the caller has been
//! found to reach what it names. A scope that is bound to its owner (`captures:read:own`) reaches what
//! that owner has, and what the members of the owner's projects have; any other scope reaches
//! everything, and costs nothing here. Lists are confined where they are read, by the same rule. The
//! holder of a share reaches its twin, and the sessions of its plays, alone.

use std::{fmt::Display, str::FromStr, sync::Arc};

use bendtwin_core::ids::{
    CaptureId, FitId, InvalidName, KeyId, PlayId, ProjectId, RetentionId, SessionId, ShareId,
    TwinId, UploadId, WorkerId,
};
use bendtwin_proto::v1::{
    InitialState, RollOutRequest,
    initial_state::{CaptureFrame, SessionSlots, State},
};
use bendtwin_store::Error as StoreError;

use super::{App, Error, Result};
use crate::{
    access::{Limited, Scope},
    context::Context,
};

/// Scope of rollouts and of all that simulates.
const SIMULATE: Scope = Scope::RolloutsRun;

/// Ids of what has an owner.
pub(super) trait Owned: Copy + Display + FromStr<Err = InvalidName> + Send + Sync {
    /// The owner; empty if it is not known.
    fn owner(self, app: &App) -> impl Future<Output = Result<Arc<str>>> + Send;

    /// The twin whose shares reach it; none if no share does.
    fn shared_twin(self, _: &App) -> impl Future<Output = Result<Option<TwinId>>> + Send {
        std::future::ready(Ok(None))
    }
}

/// Ids of what has no owner: the scope of a call decides alone.
pub(crate) trait Ownerless: FromStr<Err = InvalidName> {}

impl Ownerless for KeyId {}
impl Ownerless for WorkerId {}
impl Ownerless for ProjectId {}
impl Ownerless for RetentionId {}

impl Owned for CaptureId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        Ok(app.store.owners().of_capture(self).await?.into())
    }
}

impl Owned for FitId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        Ok(app.store.owners().of_fit(self).await?.into())
    }
}

impl Owned for TwinId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        match app.dispatch.twin_owner(self).await {
            // It may be restored, or purged.
            Err(Error::Store(StoreError::InTrash { .. })) => {
                Ok(app.store.owners().of_twin(self).await?.into())
            }
            owner => owner,
        }
    }

    async fn shared_twin(self, _: &App) -> Result<Option<TwinId>> {
        Ok(Some(self))
    }
}

/// Those who may change a twin may revoke all of its shares.
impl Owned for ShareId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        let (_, share) = app.store.keys().get_share(self).await?;
        share.twin.owner(app).await
    }
}

impl Owned for UploadId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        Ok(app.store.owners().of_upload(self).await?.into())
    }
}

impl Owned for SessionId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        app.dispatch.session_owner(self).await
    }

    async fn shared_twin(self, app: &App) -> Result<Option<TwinId>> {
        Ok(Some(app.dispatch.session_twin(self).await?))
    }
}

impl Owned for PlayId {
    async fn owner(self, app: &App) -> Result<Arc<str>> {
        Ok(app.plays.get(self)?.owner().into())
    }
}

impl App {
    /// The id of what a client names, if the caller reaches it with the scope of the call.
    ///
    /// # Errors
    /// [`Error::Name`]; [`Error::NotOwner`]; [`Error::Shared`]; for a scope that is bound, that there is
    /// no such thing.
    pub(super) async fn reach<T: Owned>(&self, scope: Scope, name: &str) -> Result<T> {
        let id: T = name.parse().map_err(Error::Name)?;
        if let Some(share) = Context::current().caller.share {
            return match id.shared_twin(self).await? {
                Some(twin) if twin == share.twin => Ok(id),
                _ => Err(Limited::ToTwin(share.twin).into()),
            };
        }
        if is_bound(scope) {
            require(scope, id, &id.owner(self).await?)?;
        }
        Ok(id)
    }

    /// A session that the caller reaches, with its twin, which may be shared no more.
    pub(super) async fn reach_session(&self, name: &str) -> Result<SessionId> {
        let id: SessionId = self.reach(SIMULATE, name).await?;
        if is_bound(SIMULATE) {
            let twin = self.dispatch.session_twin(id).await?;
            require(SIMULATE, twin, &twin.owner(self).await?)?;
        }
        Ok(id)
    }

    /// Refuses a rollout of a twin, or from a capture or a session, that the caller does not reach. The
    /// twin of one that begins in a session is the session's.
    pub(super) async fn require_rollout(&self, rollout: &RollOutRequest) -> Result<()> {
        let initial = rollout.initial.as_ref();
        let state = initial.and_then(|initial| initial.state.as_ref());
        if is_bound(SIMULATE) && !matches!(state, Some(State::Session(_))) {
            self.reach::<TwinId>(SIMULATE, &rollout.twin).await?;
        }
        self.require_initial(initial).await
    }

    /// Refuses an initial state in a capture or a session that the caller does not reach.
    pub(super) async fn require_initial(&self, initial: Option<&InitialState>) -> Result<()> {
        if let Some(share) = Context::current().caller.share {
            // Nothing of recordings, the twin's own included.
            return match initial.and_then(|initial| initial.state.as_ref()) {
                Some(State::CaptureFrame(_) | State::Session(_)) => {
                    Err(Limited::ToTwin(share.twin).into())
                }
                _ => Ok(()),
            };
        }
        if !is_bound(SIMULATE) {
            return Ok(());
        }
        match initial.and_then(|initial| initial.state.as_ref()) {
            Some(State::CaptureFrame(CaptureFrame { capture, .. })) if !capture.is_empty() => {
                self.reach::<CaptureId>(SIMULATE, capture).await.map(drop)
            }
            Some(State::Session(SessionSlots { session, .. })) => {
                self.reach_session(session).await.map(drop)
            }
            _ => Ok(()),
        }
    }
}

fn is_bound(scope: Scope) -> bool {
    Context::current().caller.bound(scope).is_some()
}

/// Refuses what the caller does not reach.
fn require(scope: Scope, name: impl Display, owner: &str) -> Result<()> {
    let caller = Context::current().caller;
    if caller.reaches(scope, owner) {
        return Ok(());
    }
    let (name, scope) = (name.to_string(), scope.as_str());
    Err(Error::NotOwner { name, owner: caller.owner.to_string(), scope })
}

/// The owner to whom a list is confined, with those who share a project with it.
pub(super) fn confined(scope: Scope) -> Option<String> {
    Context::current().caller.bound(scope)
}

/// Parses the name of what has no owner.
pub(crate) fn name<T: Ownerless>(text: &str) -> Result<T> {
    text.parse().map_err(Error::Name)
}

/// Parses a name that a worker sends: its token and its leases decide.
pub(crate) fn name_of_worker<T: FromStr<Err = InvalidName>>(text: &str) -> Result<T> {
    text.parse().map_err(Error::Name)
}

/// The whole name of what the path of a route names by its last part.
pub(crate) fn whole_name<T: FromStr<Err = InvalidName> + Display>(text: &str) -> Result<String> {
    Ok(text.parse::<T>().map_err(Error::Name)?.to_string())
}

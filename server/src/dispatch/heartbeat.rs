//! Heartbeats as workers send them.

use std::str::FromStr;

use bendtwin_contract::rollout::SessionParts;
use bendtwin_core::ids::InvalidName;
use bendtwin_proto::worker::v1::{HeartbeatRequest, HeldSession as SessionMessage};

use super::{Heartbeat, HeldSession, Memory};
use crate::{
    app::name_of_worker as of_worker,
    error::{Error, Result},
};

impl TryFrom<HeartbeatRequest> for Heartbeat {
    type Error = Error;

    fn try_from(sent: HeartbeatRequest) -> Result<Self> {
        let session = |s: &SessionMessage| {
            let parts = SessionParts { colliders: s.colliders, grasps: s.grasps };
            let (twin, owner) = (of_worker(&s.twin)?, s.owner.as_str().into());
            Ok((of_worker(&s.session)?, HeldSession { twin, owner, slots: s.slots, parts }))
        };
        Ok(Self {
            warm: sent.warm_twins.iter().map(|t| of_worker(t)).collect::<Result<_>>()?,
            sessions: sent.sessions.iter().map(session).collect::<Result<_>>()?,
            in_flight: sent.rollouts_in_flight,
            memory: (sent.memory_total_bytes > 0)
                .then_some(Memory { used: sent.memory_used_bytes, total: sent.memory_total_bytes }),
            fit_bytes: sent.fit_memory_bytes,
            fit: optional(&sent.fit)?,
            ingest: optional(&sent.ingest)?,
        })
    }
}

/// The name of a job; empty means none.
fn optional<T: FromStr<Err = InvalidName>>(text: &str) -> Result<Option<T>> {
    if text.is_empty() { Ok(None) } else { of_worker(text).map(Some) }
}

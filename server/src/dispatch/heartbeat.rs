//! Heartbeats as workers send them.

use bendtwin_contract::rollout::SessionParts;
use bendtwin_proto::worker::v1::{HeartbeatRequest, HeldSession as SessionMessage};

use super::{Heartbeat, HeldSession, Memory};
use crate::{
    app,
    error::{Error, Result},
};

impl TryFrom<HeartbeatRequest> for Heartbeat {
    type Error = Error;

    fn try_from(sent: HeartbeatRequest) -> Result<Self> {
        let session = |s: &SessionMessage| {
            let parts = SessionParts { colliders: s.colliders, grasps: s.grasps };
            let held = HeldSession { twin: app::name(&s.twin)?, slots: s.slots, parts };
            Ok((app::name(&s.session)?, held))
        };
        Ok(Self {
            warm: sent.warm_twins.iter().map(|t| app::name(t)).collect::<Result<_>>()?,
            sessions: sent.sessions.iter().map(session).collect::<Result<_>>()?,
            in_flight: sent.rollouts_in_flight,
            memory: (sent.memory_total_bytes > 0)
                .then_some(Memory { used: sent.memory_used_bytes, total: sent.memory_total_bytes }),
            fit_bytes: sent.fit_memory_bytes,
            fit: app::optional_name(&sent.fit)?,
            ingest: app::optional_name(&sent.ingest)?,
        })
    }
}

//! Registrations: what comes before the geometry, and its memory. Their frames of physics wait for
//! their turn at the device like a rollout's.

use std::sync::Arc;

use bendtwin_contract::registration;
use bendtwin_core::ids::{InvalidName, TwinId};
use bendtwin_proto::{v1::RegisteredState, worker::v1::ExecuteRegisterStateRequest};
use bendtwin_rollout::{register_state, shape};

use super::{
    error::Error,
    service::{Inner, Unary},
};
use crate::{budget, device::Priority};

impl Inner {
    /// Answers a registration.
    pub(super) async fn register(
        self: &Arc<Self>,
        request: ExecuteRegisterStateRequest,
        call: &Unary,
    ) -> Result<RegisteredState, Error> {
        let wire = request.request.ok_or_else(|| Error::field("request", "is missing"))?;
        let twin: TwinId =
            wire.twin.parse().map_err(|e: InvalidName| Error::field("twin", e.to_string()))?;
        let warm = self.twins.get(twin).await?;
        let shape = shape(warm.twin(), !request.capture.is_empty());
        registration::check_registration(&wire, &shape, &self.limits())?;
        // A preceding simulation takes its memory first.
        let begun = registration::begun(&wire);
        let starts = self.first_states(&warm, &begun, &request.capture, call.cancel()).await?;
        let start = starts.into_iter().next();
        let start = start.ok_or_else(|| Error::field("initial", "has no state"))?;
        let bytes = registration::memory_bytes(wire.observation.as_ref(), &shape);
        let purpose = "the registration: send fewer points";
        let share = budget::take(&self.memory.rollouts, bytes, purpose).await?;
        let backend = self.device.backend(Priority::Interactive);
        call.blocking(move |cancel| {
            let _share = share;
            Ok(register_state(&warm, start, wire, &backend, cancel)?)
        })
        .await
    }
}

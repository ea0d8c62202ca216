//! Registrations: what comes before the geometry, and its memory. Their frames of physics wait for
//! their turn at the device like a rollout's.

use std::sync::Arc;

use bendtwin_contract::registration;
use bendtwin_proto::{v1::RegisteredState, worker::v1::ExecuteRegisterStateRequest};
use bendtwin_rollout::{register_state, shape};

use super::{
    error::Error,
    service::{Inner, Unary},
};
use crate::budget;

impl Inner {
    /// Answers a registration.
    pub(super) async fn register(
        self: &Arc<Self>,
        request: ExecuteRegisterStateRequest,
        call: &Unary,
    ) -> Result<RegisteredState, Error> {
        let ExecuteRegisterStateRequest { request, capture, .. } = request;
        let request = request.ok_or_else(|| Error::field("request", "is missing"))?;
        let warm = self.twins.get(Error::parsed("twin", &request.twin)?).await?;
        let shape = shape(warm.twin(), !capture.is_empty());
        registration::check_registration(&request, &shape, &self.limits())?;
        // A preceding simulation takes its memory first.
        let begun = registration::begun(&request);
        let starts = self.first_states(&warm, &begun, &capture, call).await?;
        let start = starts.into_iter().next();
        let start = start.ok_or_else(|| Error::field("initial", "has no state"))?;
        let bytes = registration::memory_bytes(request.observation.as_ref(), &shape);
        let purpose = "the registration: send fewer points";
        let share = budget::take(&self.memory.rollouts, bytes, purpose).await?;
        let backend = call.backend(&self.device);
        call.blocking(move |cancel| {
            let _share = share;
            Ok(register_state(&warm, start, request, &backend, cancel)?)
        })
        .await
    }
}

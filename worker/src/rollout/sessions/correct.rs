//! Corrections of the states of a session: its turn and its memory, before the geometry.

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_contract::registration;
use bendtwin_proto::v1::{CorrectSessionRequest, CorrectedSession};
use bendtwin_rollout::{CorrectionInput, RestShape, corrected, shape};

use crate::{
    budget,
    rollout::{
        error::Error,
        service::{Inner, Unary},
    },
};

impl Inner {
    /// Corrects slots of a session.
    pub(super) async fn correct(
        &self,
        request: CorrectSessionRequest,
        call: &Unary,
    ) -> Result<CorrectedSession, Error> {
        let session = self.sessions.get(&request.name)?;
        let slots = session.distinct(&request.slots, [0])?;
        let warm = self.twins.get(session.setup.twin).await?;
        let shape = shape(warm.twin(), false);
        let (count, grasps) = (slots.len() as u64, session.setup.grasps.len() as u64);
        registration::check_correction(&request, count, grasps, &shape, &self.limits())?;
        let options = request.options.unwrap_or_default();
        let states = registration::correction_reply_bytes(&options, count, grasps, &shape);
        let bytes = registration::memory_bytes(request.observation.as_ref(), &shape) + states;
        // As an advance: the turn before the memory.
        let turn = session.begin_advance().await;
        let purpose = "the correction: send fewer points";
        let share = budget::take(&self.memory.rollouts, bytes, purpose).await?;
        let memory = match registration::carry(&options) > 0.0 {
            true => self.rest_shapes(slots.len(), RestShape::bytes(&warm.twin().graph)).await?,
            false => Vec::new(),
        };
        let to = Arc::clone(&session);
        let backend = call.backend(&self.device);
        let corrections = call.blocking(move |cancel| {
            let (_share, _turn) = (share, turn);
            let seen =
                CorrectionInput::new(&warm, &backend, &to.setup, request.observation, options)?;
            Ok(corrected(&to, &slots, &seen, memory, cancel)?)
        });
        let corrections = corrections.await?;
        Ok(CorrectedSession { session: Some(session.describe(&self.worker)), corrections })
    }

    /// Memory of rest shapes, each of which is held for as long as a slot has it.
    async fn rest_shapes(&self, count: usize, bytes: u64) -> Result<Vec<Share>, Error> {
        let advice =
            "the rest shapes of the slots: close other sessions, or correct with a `carry` of 0";
        let mut shares = Vec::with_capacity(count);
        for _ in 0..count {
            shares.push(budget::take(&self.memory.sessions, bytes, advice).await?);
        }
        Ok(shares)
    }
}

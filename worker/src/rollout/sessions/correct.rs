//! Corrections: states of a session that are brought closer to what is seen, all of the slots that a
//! call names or none of them.

use std::sync::Arc;

use bendtwin_core::CancelToken;
use bendtwin_engine::{Model, backend};
use bendtwin_proto::{
    registration,
    v1::{CorrectSessionRequest, CorrectedSession, World, corrected_session::Correction},
};
use bendtwin_register::{CorrectOptions, Observation, correct};

use super::Session;
use crate::{
    budget,
    rollout::{
        error::Error,
        initial::Start,
        observation,
        plan::shape,
        service::{Inner, Unary},
        world::Surroundings,
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
        let shape = shape(&warm.twin, false);
        registration::check_correction(&request, &shape, &self.limits())?;
        let bytes = registration::memory_bytes(request.observation.as_ref(), &shape);
        // As an advance: the turn before the memory.
        let turn = session.begin_advance().await;
        let purpose = "the correction: send fewer points";
        let share = budget::take(&self.memory.rollouts, bytes, purpose).await?;
        let to = Arc::clone(&session);
        let corrections = call.blocking(move |cancel| {
            let (_share, _turn) = (share, turn);
            let model = around(warm.loaded.model(), to.setup.world.as_ref());
            let seen = observation::read(request.observation, &model.graph)?;
            let options = observation::correct_options(request.options);
            corrected(&to, &slots, &Seen { model: &model, seen, options }, cancel)
        });
        let corrections = corrections.await?;
        Ok(CorrectedSession { session: Some(session.describe(&self.worker)), corrections })
    }
}

/// What slots are corrected by.
pub(in crate::rollout) struct Seen<'m> {
    pub(in crate::rollout) model: &'m Model,
    pub(in crate::rollout) seen: Observation,
    pub(in crate::rollout) options: CorrectOptions,
}

/// Corrects slots and leaves them in the corrected states, unless one of them is refused.
pub(in crate::rollout) fn corrected(
    session: &Session,
    slots: &[usize],
    by: &Seen<'_>,
    cancel: &CancelToken,
) -> Result<Vec<Correction>, Error> {
    let (starts, _) = session.states(slots);
    let mut states = Vec::with_capacity(slots.len());
    let mut corrections = Vec::with_capacity(slots.len());
    for (&slot, start) in slots.iter().zip(starts) {
        let corrected =
            correct(by.model, &start.state, &start.controls, &by.seen, &by.options, cancel)
                .map_err(|error| Error::of_slot(slot, error))?;
        corrections.push(Correction {
            slot: slot as u32,
            before: Some(observation::residual(corrected.before)),
            after: Some(observation::residual(corrected.after)),
            moved_mm: 1e3 * corrected.moved_m,
        });
        states.push(Start { state: Arc::new(corrected.state), ..start });
    }
    if cancel.is_cancelled() {
        // Nobody would hear of it.
        return Err(backend::Error::Cancelled.into());
    }
    session.commit(slots, states, 0);
    Ok(corrections)
}

/// The model with the ground of the session.
pub(in crate::rollout) fn around(model: &Arc<Model>, world: Option<&World>) -> Arc<Model> {
    let surroundings = world.map(Surroundings::without_bodies);
    match surroundings.and_then(|s| s.environment(model.environment)) {
        None => Arc::clone(model),
        Some(environment) => Arc::new(Model { environment, ..Model::clone(model) }),
    }
}

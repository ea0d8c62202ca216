//! Corrections: states of a session that are brought closer to what is seen, and their rest shapes
//! with them, all of the slots that a call names or none of them.

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_core::{CancelToken, Params};
use bendtwin_engine::{Model, backend, model::State};
use bendtwin_proto::{
    registration,
    v1::{CorrectSessionRequest, CorrectedSession, World, corrected_session::Correction},
};
use bendtwin_register::{CorrectOptions, Observation, carried, correct};

use super::Session;
use crate::{
    budget,
    rollout::{
        error::Error,
        initial::Start,
        observation,
        plan::shape,
        rest_shape::RestShape,
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
        let carry = registration::carry(&request);
        let memory = match carry > 0.0 {
            true => self.rest_shapes(slots.len(), RestShape::bytes(&warm.twin.graph)).await?,
            false => Vec::new(),
        };
        let to = Arc::clone(&session);
        let corrections = call.blocking(move |cancel| {
            let (_share, _turn) = (share, turn);
            let model = around(warm.loaded.model(), to.setup.world.as_ref());
            let seen = observation::read(request.observation, &model.graph)?;
            let options = observation::correct_options(request.options);
            let by = Seen { model: &model, seen, options, carry };
            corrected(&to, &slots, &by, memory, cancel)
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

/// What slots are corrected by.
pub(in crate::rollout) struct Seen<'m> {
    pub(in crate::rollout) model: &'m Model,
    pub(in crate::rollout) seen: Observation,
    pub(in crate::rollout) options: CorrectOptions,
    /// Share of the correction, beyond the noise of the points, that rest shapes take, 0..=1.
    pub(in crate::rollout) carry: f64,
}

impl Seen<'_> {
    /// The rest shape of a slot that takes a share of the way to another state.
    fn rest(&self, from: &Start, to: &State, share: f64) -> Params {
        let mut model = Model::clone(self.model);
        if let Some(rest) = &from.rest {
            rest.put_into(&mut model.params);
        }
        carried(&model, &self.model.params, &from.state, to, &from.controls, share)
    }
}

/// Corrects slots and leaves them in the corrected states with their rest shapes, for each of which
/// memory was taken if it is counted; unless one of the slots is refused.
pub(in crate::rollout) fn corrected(
    session: &Session,
    slots: &[usize],
    by: &Seen<'_>,
    memory: Vec<Share>,
    cancel: &CancelToken,
) -> Result<Vec<Correction>, Error> {
    let (starts, _) = session.states(slots);
    let mut memory = memory.into_iter();
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
        let share = by.carry * corrected.beyond_noise(by.options.noise_m);
        let own = memory.next();
        let rest = match share > 0.0 {
            true => Some(Arc::new(RestShape::new(by.rest(&start, &corrected.state, share), own))),
            false => start.rest.clone(),
        };
        states.push(Start { state: Arc::new(corrected.state), rest, ..start });
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

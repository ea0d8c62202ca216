//! Steps of a closed loop: a correction, a plan and an advance of one slot of a session, each as the
//! call for it alone makes it. All of the request is checked before the first of them changes anything.

use std::{sync::Arc, time::Duration};

use bendtwin_contract::{
    plan::Template,
    registration,
    rollout::{self, SessionParts, TwinShape},
};
use bendtwin_core::Category;
use bendtwin_proto::v1::{
    AdvanceSessionRequest, CorrectOptions, CorrectSessionRequest, GetSessionStatesRequest,
    InitialState, PlanRequest, PlanUpdate, Returns, RollOutRequest, RollOutResponse,
    StepSessionRequest, SteppedSession, Tensor,
    corrected_session::Correction,
    initial_state::{GivenState, SessionSlots, State},
    stepped_session::Times,
};
use futures::StreamExt as _;
use tokio::{sync::oneshot, time::Instant};

use super::{
    Dispatch, HeldSession,
    plan::{Plan, Ready},
    rollout::{LONGEST, ReplyHold, Whole},
};
use crate::{
    context::Context,
    error::{Error, Result},
    memory::Shares,
};

/// Share of the time of a step after which its search ends: the rest is for the frames that are
/// executed.
const SEARCH: f64 = 0.9;
/// The reason of a correction that is refused because the slot does not explain the points; any other
/// says that the slot is lost.
const NOT_EXPLAINED: &str = "OBSERVATION_NOT_EXPLAINED";

/// A step to be taken.
pub(crate) struct Step {
    pub(crate) request: StepSessionRequest,
    /// Time that the caller allows, if it said.
    pub(crate) timeout: Option<Duration>,
    /// True if the reply is to be written as nested lists of JSON.
    pub(crate) as_lists: bool,
    /// Memory of the request, held until the slot is advanced.
    pub(crate) memory: Arc<Shares>,
}

/// A step that was taken.
pub(crate) struct Stepped {
    pub(crate) response: SteppedSession,
    pub(crate) held: ReplyHold,
}

/// A step that has passed the check.
struct Checked {
    correction: Option<CorrectSessionRequest>,
    plan: Ready,
    /// The advance, with the nominal plan in place of the best one; none without frames.
    advance: Option<RollOutRequest>,
    /// True if its final state was asked for.
    returns_final_state: bool,
}

impl Dispatch {
    /// Corrects a slot by what is seen, plans from there, and advances it by the first frames of the
    /// plan. Its parts are on the heap, as the futures of rollouts are large.
    pub(crate) async fn step_session(&self, step: Step) -> Result<Stepped> {
        let began = Instant::now();
        let end = began + step.timeout.unwrap_or(LONGEST).min(LONGEST);
        let left = || Some(end.saturating_duration_since(Instant::now()));
        let deadline = deadline(step.request.deadline_s)?;
        let (name, slot) = (step.request.name.clone(), step.request.slot);
        let (as_lists, memory) = (step.as_lists, Arc::clone(&step.memory));
        let Checked { correction, mut plan, advance, returns_final_state } =
            Box::pin(self.checked_step(step)).await?;
        let mut response = SteppedSession::default();
        let mut times = Times::default();

        if let Some(correction) = correction {
            let correcting = Instant::now();
            match Box::pin(self.correct_session(correction, left(), as_lists)).await {
                Ok((corrected, _)) => {
                    let is_lost = |c: &Correction| c.tracking.is_some_and(|t| t.lost);
                    response.lost = corrected.corrections.iter().any(is_lost);
                    response.corrected = Some(corrected);
                }
                Err(Error::Worker(fault)) if fault.category == Category::FailedPrecondition => {
                    response.lost = fault.reason != NOT_EXPLAINED;
                    response.refused = Some((&fault).into());
                }
                Err(error) => return Err(error),
            }
            times.correct_s = correcting.elapsed().as_secs_f64();
        }

        let planning = Instant::now();
        if let Some(deadline) = deadline {
            let rest = deadline.mul_f64(SEARCH).saturating_sub(began.elapsed());
            let own = &mut plan.checked.settings.deadline;
            *own = Some(own.map_or(rest, |own| own.min(rest)));
        }
        let best = Box::pin(self.best_plan(plan)).await?;
        times.plan_s = planning.elapsed().as_secs_f64();

        let advancing = Instant::now();
        let mut held = None;
        if let Some(mut rollout) = advance {
            Template::put(&mut rollout, best.knots.clone().unwrap_or_default());
            let advance = AdvanceSessionRequest {
                name: name.clone(),
                slots: vec![slot],
                rollout: Some(rollout),
            };
            let advanced = Box::pin(self.advance_session(advance, left(), as_lists, memory));
            let Whole { response: mut advanced, held: of_advance } = advanced.await?;
            held = Some(of_advance.memory());
            if advanced.diverged.is_empty() {
                response.state = Some(final_state(&mut advanced, returns_final_state));
            }
            response.advanced = Some(advanced);
        }
        if response.state.is_none() {
            // After a divergence the memory of that reply is held meanwhile; it is rare, and the wait
            // for memory ends by itself.
            let asked = GetSessionStatesRequest { name, slots: vec![slot] };
            let states = Box::pin(self.session_states(asked, left(), as_lists));
            let (states, of_states) = states.await?;
            response.state = states.states.map(single);
            held.get_or_insert(of_states);
        }
        times.advance_s = advancing.elapsed().as_secs_f64();
        times.total_s = began.elapsed().as_secs_f64();
        response.plan = Some(best);
        response.times = Some(times);
        let missing = || Error::Internal("a step without a state".to_owned());
        Ok(Stepped { response, held: held.ok_or_else(missing)? })
    }

    /// Checks all of a step.
    async fn checked_step(&self, step: Step) -> Result<Checked> {
        let Step { request, timeout, as_lists, memory } = step;
        let StepSessionRequest { name, slot, correction, search, execute_frames, returns, .. } =
            request;
        let (_, _, HeldSession { twin, slots, parts, .. }) = self.named(&name).await?;
        if slot >= slots {
            let fault = format!("is {slot}: the session has {slots} slots (counted from 0)");
            return Err(Error::invalid("slot", fault));
        }
        let shape = self.twins.get(&self.store, twin).await?.shape;
        let correction = correction.map(|correction| {
            let correction = of_slot(correction, &name, slot)?;
            let (grasps, limits) = (u64::from(parts.grasps), &self.limits.rollout);
            registration::check_correction(&correction, 1, grasps, &shape, limits)?;
            Ok::<_, Error>(correction)
        });
        let correction = correction.transpose()?;
        let request = search_from(search, &name, slot)?;
        // Of its updates only the last is used, which is written with the rest.
        let plan = Plan { request, timeout, as_lists, memory };
        let plan = self.ready(plan).await?;
        let horizon = plan.checked.settings.frames;
        if execute_frames as usize > horizon {
            let fault = format!("is {execute_frames}: the plan has {horizon} frames");
            return Err(Error::invalid("execute_frames", fault));
        }
        let returns_final_state = returns.as_ref().is_some_and(|returns| returns.final_state);
        let returns = Returns { final_state: true, ..returns.unwrap_or_default() };
        let advance = (execute_frames > 0)
            .then(|| self.checked_advance(&plan, execute_frames, returns, parts, &shape));
        let advance = advance.transpose()?;
        Ok(Checked { correction, plan, advance, returns_final_state })
    }

    /// The rollout that advances a slot by the first frames of a plan.
    fn checked_advance(
        &self,
        plan: &Ready,
        frames: u32,
        returns: Returns,
        parts: SessionParts,
        shape: &TwinShape,
    ) -> Result<RollOutRequest> {
        let mut advance = plan.checked.first_frames(frames, Some(returns));
        // Both are those of the session.
        (advance.initial, advance.fidelity) = (None, 0);
        let check = rollout::check_advance(&advance).and_then(|()| {
            rollout::check_in(&advance, parts, shape, &self.limits.rollout, 0).map(drop)
        });
        // What else there is of a rollout was checked with the search.
        check.map_err(|error| match error {
            rollout::Error::Field { field, fault } => {
                let field = field.strip_prefix("rollout.").map_or(field.clone(), str::to_owned);
                rollout::Error::Field { field, fault }
            }
            other => other,
        })?;
        Ok(advance)
    }

    /// The last update of a search, which ends when its caller is gone.
    async fn best_plan(&self, plan: Ready) -> Result<PlanUpdate> {
        let dispatch = self.clone();
        let (mut sender, best) = oneshot::channel();
        // In a separate task, since its future is large and this one is part of others.
        tokio::spawn(Context::current().scope(async move {
            tokio::select! {
                () = sender.closed() => {}
                best = dispatch.last_update(plan) => {
                    let _ = sender.send(best);
                }
            }
        }));
        best.await.map_err(|e| Error::Internal(format!("the search of a step: {e}")))?
    }

    async fn last_update(&self, plan: Ready) -> Result<PlanUpdate> {
        let mut updates = self.search(plan).await?;
        let mut last = None;
        while let Some(update) = updates.next().await {
            last = Some(update?);
        }
        last.ok_or_else(|| Error::Internal("a plan without an update".to_owned()))
    }
}

/// Time for a step.
fn deadline(seconds: f64) -> Result<Option<Duration>> {
    if seconds == 0.0 {
        return Ok(None);
    }
    Duration::try_from_secs_f64(seconds).map(Some).map_err(|_| {
        let fault = format!("is {seconds}: it must be 0 or more, and finite");
        Error::invalid("deadline_s", fault)
    })
}

/// The correction of the slot of a step.
fn of_slot(
    correction: CorrectSessionRequest,
    name: &str,
    slot: u32,
) -> Result<CorrectSessionRequest> {
    if !correction.name.is_empty() || !correction.slots.is_empty() {
        let fault = "has a name or slots: leave them out, they are those of the step";
        return Err(Error::invalid("correction", fault));
    }
    // The reply has the state that the slot ends in.
    let options = CorrectOptions { omit_state: true, ..correction.options.unwrap_or_default() };
    let observation = correction.observation;
    let (name, slots, options) = (name.to_owned(), vec![slot], Some(options));
    Ok(CorrectSessionRequest { name, slots, observation, options })
}

/// The search of a step, from where the slot is.
fn search_from(search: Option<PlanRequest>, name: &str, slot: u32) -> Result<PlanRequest> {
    let missing = || Error::invalid("search", "is missing: say what to plan");
    let mut search = search.ok_or_else(missing)?;
    let missing = || Error::invalid("search.rollout", "is missing: say what to minimize");
    let rollout = search.rollout.as_mut().ok_or_else(missing)?;
    if rollout.initial.is_some() {
        let fault = "must be left out: a step begins where the session is";
        return Err(Error::invalid("search.rollout.initial", fault));
    }
    if rollout.returns.is_some() {
        let fault =
            "must be left out: `returns` of the step are those of the frames that are executed";
        return Err(Error::invalid("search.rollout.returns", fault));
    }
    let slots = SessionSlots { session: name.to_owned(), slots: vec![slot] };
    rollout.initial = Some(InitialState { state: Some(State::Session(slots)) });
    Ok(search)
}

/// The final state of a rollout of one instance, which keeps it if it was asked for.
fn final_state(advanced: &mut RollOutResponse, keeps: bool) -> GivenState {
    let of = |tensor: &mut Option<Tensor>| if keeps { tensor.clone() } else { tensor.take() };
    single(GivenState {
        positions: of(&mut advanced.final_positions),
        velocities: of(&mut advanced.final_velocities),
        twists: of(&mut advanced.final_twists),
        controls: of(&mut advanced.final_controls),
        commanded_controls: of(&mut advanced.final_commanded_controls),
        grasping: match keeps {
            true => advanced.final_grasping.clone(),
            false => advanced.final_grasping.take(),
        },
    })
}

/// The state of one instance, without a dimension for instances.
fn single(mut state: GivenState) -> GivenState {
    let grasping = state.grasping.as_mut();
    let of_grasps = grasping.map(|g| [&mut g.phases, &mut g.holders, &mut g.places]);
    let tensors = [
        &mut state.positions,
        &mut state.velocities,
        &mut state.twists,
        &mut state.controls,
        &mut state.commanded_controls,
    ];
    for tensor in tensors.into_iter().chain(of_grasps.into_iter().flatten()).flatten() {
        if tensor.shape.first() == Some(&1) {
            tensor.shape.remove(0);
        }
    }
    state
}

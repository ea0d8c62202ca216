//! A plan under way.

use std::{convert::Infallible, sync::Arc, time::Duration};

use bendtwin_budget::Share;
use bendtwin_plan::{Origin, Progress};
use bendtwin_proto::v1::{
    PlanUpdate, RollOutRequest, RollOutResponse, Tensor, plan_update::Origin as WireOrigin,
};
use tokio::time::Instant;

use super::{
    beside::beside,
    evaluation::{Costs, Extremes},
    start::Parts,
};
use crate::{
    context::Context,
    dispatch::{Dispatch, ReplyHold, RollOut, Whole},
    error::{Error, Result},
    memory::Shares,
};

/// A plan under way: everything that the next update needs. It is on the heap, as it goes from step to
/// step by value, and stacks are small.
pub(super) struct Run {
    dispatch: Dispatch,
    context: Context,
    parts: Parts,
    began: Instant,
    /// The end of the call.
    deadline: Instant,
    /// Names of the cost terms, and their values and the extremes of the best plan so far.
    names: Vec<String>,
    terms: Vec<f64>,
    extremes: Extremes,
    /// True once a plan has grasped something, or if none need.
    has_grasped: bool,
    is_first: bool,
    /// The next batch; none once there is no other.
    next: Option<RollOutRequest>,
    /// Memory of the request, of the plans, and of the reply for the best, until all was sent.
    _request: Arc<Shares>,
    _plans: Share,
    held: Option<ReplyHold>,
    has_ended: bool,
}

/// An update, and the plan unless it has ended.
type Step = (Result<PlanUpdate>, Option<Box<Run>>);

impl Run {
    pub(super) fn new(
        dispatch: Dispatch,
        parts: Parts,
        deadline: Instant,
        request: Arc<Shares>,
        plans: Share,
    ) -> Self {
        Self {
            dispatch,
            context: Context::current(),
            parts,
            began: Instant::now(),
            deadline,
            names: Vec::new(),
            terms: Vec::new(),
            extremes: Extremes::default(),
            has_grasped: false,
            is_first: true,
            next: None,
            _request: request,
            _plans: plans,
            held: None,
            has_ended: false,
        }
    }

    /// The next update.
    pub(super) async fn update(self: Box<Self>) -> Option<Step> {
        if self.has_ended {
            return None;
        }
        let stopping = self.dispatch.stopping.clone();
        let made = tokio::select! {
            biased;
            () = stopping.cancelled() => Err(Error::Stopping),
            made = self.iteration() => made,
        };
        Some(match made {
            Ok((update, run)) => (Ok(update), Some(run)),
            Err(error) => (Err(error), None),
        })
    }

    /// Simulates a batch, and proposes the next one.
    async fn iteration(mut self: Box<Self>) -> Result<(PlanUpdate, Box<Self>)> {
        if self.is_first {
            self = self.proposed().await?;
        }
        if let Some(request) = self.next.take() {
            let left = self.left();
            match self.simulate(request, left).await {
                Ok(Whole { response, .. }) => {
                    self = self.learned(response).await?.proposed().await?;
                }
                // The best until then is the plan.
                Err(Error::Deadline) if !self.is_first && Instant::now() < self.deadline => {}
                Err(error) => return Err(error),
            }
            self.is_first = false;
        }
        let is_last = self.next.is_none();
        let mut update = self.best()?;
        if is_last {
            self.has_ended = true;
            update.last = true;
            update.rollout = self.last().await?;
        }
        Ok((update, self))
    }

    /// Time for the next batch: to the end of the call, or of the plan once there is one.
    fn left(&self) -> Duration {
        let left = self.deadline.saturating_duration_since(Instant::now());
        match self.parts.search.settings().deadline.filter(|_| !self.is_first) {
            Some(deadline) => left.min(deadline.saturating_sub(self.began.elapsed())),
            None => left,
        }
    }

    async fn simulate(&self, request: RollOutRequest, left: Duration) -> Result<Whole> {
        let rollout = RollOut {
            request,
            timeout: Some(left),
            in_parts: false,
            as_lists: false,
            commit_slots: Vec::new(),
            // That of the plans is held here.
            memory: Arc::default(),
        };
        // On the heap, as the future of a rollout is large and this one is part of others.
        Box::pin(self.context.clone().scope(self.dispatch.roll_out(rollout))).await
    }

    /// Takes in the reply to a batch.
    async fn learned(mut self: Box<Self>, reply: RollOutResponse) -> Result<Box<Self>> {
        let (bytes, elapsed) = (self.parts.bytes, self.began.elapsed());
        let work = move || {
            let Parts { search, spaces, template, .. } = &mut self.parts;
            let gradients = search.settings().method.needs_gradients();
            let plans = search.batch().map(|(place, knots)| (&spaces[place], knots));
            let costs = Costs::read(reply, plans, gradients, template)?;
            self.has_grasped |= costs.has_grasped;
            let learned = search.learn(costs.evaluation.clone(), elapsed);
            if let Some(best) = learned.map_err(|e| failed(e, self.has_grasped))? {
                self.terms = costs.of(best);
                self.extremes = costs.extremes_of(best);
                self.names = costs.names;
            }
            Ok(self)
        };
        beside(bytes, work).await?
    }

    /// Proposes the next batch, if there is another.
    async fn proposed(mut self: Box<Self>) -> Result<Box<Self>> {
        let (bytes, elapsed) = (self.parts.bytes, self.began.elapsed());
        let work = move || {
            let Parts { search, spaces, template, .. } = &mut self.parts;
            let gradients = search.settings().method.needs_gradients();
            self.next = search.propose(elapsed).then(|| {
                let plans = search.batch().map(|(place, knots)| spaces[place].actions(knots));
                template.batch(&plans.collect::<Vec<_>>(), gradients)
            });
            self
        };
        beside(bytes, work).await
    }

    /// The best so far.
    fn best(&self) -> Result<PlanUpdate> {
        let Parts { search, spaces, searches_grasps, template, .. } = &self.parts;
        let (place, best) = search.progress().ok_or(Error::EveryPlanDiverged)?;
        let (settings, force) = (search.settings(), template.force());
        let costs = || search.costs();
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        Ok(PlanUpdate {
            knots: Some(template.actions(&spaces[place].actions(best.knots))),
            coordinates: Some(Tensor::pack(&[settings.knots, settings.dims], best.knots)),
            cost: best.cost,
            cost_names: self.names.clone(),
            cost_terms: Some(Tensor::pack(&[self.terms.len()], &self.terms)),
            origin: origin(&best).into(),
            nominal_cost: best.nominal_cost,
            iterations: count(best.iterations),
            simulated: count(best.simulated),
            diverged: count(best.diverged),
            stopped_by_deadline: self.next.is_none() && best.iterations < settings.iterations,
            time_s: self.began.elapsed().as_secs_f64(),
            last: false,
            rollout: None,
            strain: self.extremes.strain,
            strain_limit: template.strain_limit(),
            overstrained: count(best.beyond_limit),
            grasp: searches_grasps.then(|| count(place)),
            grasp_costs: searches_grasps.then(|| Tensor::pack(&[spaces.len()], &costs())),
            grasp_force_n: force.map(|_| self.extremes.force_n),
            grasp_force_limit_n: force.map(|force| force.limit_n).filter(|limit| limit.is_finite()),
        })
    }

    /// The rollout of the best plan, if returns were asked for.
    async fn last(&mut self) -> Result<Option<RollOutResponse>> {
        let Parts { search, spaces, template, .. } = &self.parts;
        let (place, best) = search.progress().ok_or(Error::EveryPlanDiverged)?;
        let actions = spaces[place].actions(best.knots);
        let Some(request) = template.last(&actions) else { return Ok(None) };
        let left = self.deadline.saturating_duration_since(Instant::now());
        let Whole { response, held } = self.simulate(request, left).await?;
        self.held = Some(held.memory());
        Ok(Some(response))
    }
}

fn origin(best: &Progress<'_>) -> WireOrigin {
    match best.origin {
        Origin::Nominal => WireOrigin::Nominal,
        Origin::Mean => WireOrigin::Mean,
        Origin::Sample => WireOrigin::Sample,
    }
}

/// The error of a search, where a plan may have grasped something.
fn failed(error: bendtwin_plan::Error<Infallible>, has_grasped: bool) -> Error {
    match error {
        bendtwin_plan::Error::EveryPlanDiverged if !has_grasped => Error::NothingGrasped,
        bendtwin_plan::Error::EveryPlanDiverged => Error::EveryPlanDiverged,
        other => Error::Internal(format!("a worker's reply to plans: {other}")),
    }
}

//! One plan being made: batches to simulate one after the other, and the best so far. Whoever
//! simulates calls [`Search::propose`] and [`Search::learn`] in turn, so this works with any clock
//! and any way to wait.

use std::{borrow::BorrowMut, time::Duration};

use crate::{
    Knots, Planner, Settings,
    error::Error,
    method::{Descent, Method, Sampling},
};

/// Result of simulating a batch of plans.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Cost of each plan; infinite where it diverged.
    pub costs: Vec<f64>,
    /// d cost / d knots of each plan, shape [K, D]; only [`Method::Gradient`] needs them.
    pub gradients: Vec<Knots>,
}

/// Origin of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The plan that the search began with.
    Nominal,
    /// The mean that the method arrived at.
    Mean,
    /// A sample.
    Sample,
}

/// The best of all plans that were simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Its knots, shape [K, D].
    pub knots: Knots,
    /// Cost of exactly these knots, as simulated.
    pub cost: f64,
    /// Its source.
    pub origin: Origin,
    /// Cost of the nominal plan.
    pub nominal_cost: f64,
    /// Best of the samples, with its cost; none if none was simulated.
    pub best_sample: Option<(Knots, f64)>,
    /// Costs of all that was simulated, batch by batch.
    pub costs: Vec<Vec<f64>>,
    /// Iterations that were finished.
    pub iterations: usize,
    /// True if there was no time for all iterations.
    pub met_deadline: bool,
    /// Time that it took.
    pub time: Duration,
}

/// The best so far, while a plan is being made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'s> {
    /// Its knots, shape [K, D].
    pub knots: &'s Knots,
    /// Cost of exactly these knots, as simulated.
    pub cost: f64,
    /// Its source.
    pub origin: Origin,
    /// Cost of the nominal plan.
    pub nominal_cost: f64,
    /// Iterations that were finished.
    pub iterations: usize,
    /// Plans that were simulated.
    pub simulated: usize,
    /// Those of them that diverged.
    pub diverged: usize,
}

/// A plan being made. The planner is in it, or borrowed.
#[derive(Debug)]
pub struct Search<P> {
    planner: P,
    state: State,
    batch: Vec<Knots>,
    is_mean: bool,
    finished: usize,
    started: Duration,
    longest: Duration,
    best: Option<(Knots, f64, Origin)>,
    best_sample: Option<(Knots, f64)>,
    nominal_cost: f64,
    costs: Vec<Vec<f64>>,
    simulated: usize,
    diverged: usize,
}

#[derive(Debug)]
enum State {
    Sampling(Sampling),
    Descent(Descent),
}

impl<P: BorrowMut<Planner>> Search<P> {
    pub(crate) fn begin(mut planner: P) -> Self {
        let Planner { settings, random, nominal } = planner.borrow_mut();
        let state = match settings.method {
            Method::Gradient { .. } => State::Descent(Descent::begin(settings, nominal, random)),
            _ => State::Sampling(Sampling::begin(settings, nominal)),
        };
        Self {
            planner,
            state,
            batch: Vec::new(),
            is_mean: false,
            finished: 0,
            started: Duration::ZERO,
            longest: Duration::ZERO,
            best: None,
            best_sample: None,
            nominal_cost: f64::INFINITY,
            costs: Vec::new(),
            simulated: 0,
            diverged: 0,
        }
    }

    /// The next plans to simulate, `elapsed` after the search began; none if it has ended, or if
    /// there is no time for another batch.
    pub fn propose(&mut self, elapsed: Duration) -> Option<&[Knots]> {
        let Planner { settings, random, nominal } = self.planner.borrow_mut();
        self.is_mean = self.finished == settings.iterations;
        if self.costs.len() > settings.iterations {
            return None;
        }
        let needs = if self.is_mean { Duration::ZERO } else { self.longest };
        let is_first = self.costs.is_empty();
        if !is_first && settings.deadline.is_some_and(|d| elapsed + needs >= d) {
            return None;
        }
        self.batch = match &mut self.state {
            State::Sampling(sampling) if self.is_mean => sampling.mean().into_iter().collect(),
            State::Sampling(sampling) => sampling.propose(settings, random),
            State::Descent(_) if self.is_mean => Vec::new(),
            State::Descent(descent) => descent.plans(),
        };
        if self.batch.is_empty() {
            return None;
        }
        for plan in &mut self.batch {
            settings.project(plan);
        }
        if is_first && matches!(self.state, State::Sampling(_)) {
            self.batch.insert(0, nominal.clone());
        }
        self.started = elapsed;
        Some(&self.batch)
    }

    /// Takes in what the simulation of the last batch says, `elapsed` after the search began. Returns
    /// the place in the batch of the best so far, if it is there.
    ///
    /// # Errors
    /// If the evaluation is not one of the batch, or all plans so far diverged.
    pub fn learn<E>(
        &mut self,
        evaluation: Evaluation,
        elapsed: Duration,
    ) -> Result<Option<usize>, Error<E>> {
        let Evaluation { mut costs, gradients } = evaluation;
        let settings = &self.planner.borrow().settings;
        let shape = settings.knots * settings.dims;
        let right = gradients.iter().filter(|g| g.len() == shape).count();
        let (plans, needed) = (self.batch.len(), settings.method.needs_gradients());
        if costs.len() != plans || (needed && right != plans) {
            return Err(Error::Shape { plans, costs: costs.len(), gradients: right });
        }
        for cost in costs.iter_mut().filter(|c| c.is_nan()) {
            *cost = f64::INFINITY;
        }
        self.longest = self.longest.max(elapsed.saturating_sub(self.started));
        self.simulated += plans;
        self.diverged += costs.iter().filter(|c| c.is_infinite()).count();
        let place = self.note(&costs);
        let settings = &self.planner.borrow().settings;
        let best = self.best.as_ref().filter(|b| b.1.is_finite());
        let Some((best, best_cost, _)) = best else { return Err(Error::EveryPlanDiverged) };
        if !self.is_mean {
            self.finished += 1;
            match (&mut self.state, &settings.method) {
                (State::Descent(descent), Method::Gradient { rate }) => {
                    descent.learn(settings, rate, &costs, &gradients, best);
                }
                (State::Sampling(sampling), method) => {
                    let plans: Vec<&Knots> = std::iter::once(best).chain(&self.batch).collect();
                    let known: Vec<f64> =
                        std::iter::once(*best_cost).chain(costs.iter().copied()).collect();
                    sampling.learn(method, &plans, &known);
                }
                (State::Descent(_), _) => {}
            }
        }
        self.costs.push(costs);
        Ok(place)
    }

    /// Settings of the planner.
    pub fn settings(&self) -> &Settings {
        &self.planner.borrow().settings
    }

    /// The plans that were proposed last.
    pub fn batch(&self) -> &[Knots] {
        &self.batch
    }

    /// The best so far; none before the first batch was simulated.
    pub fn progress(&self) -> Option<Progress<'_>> {
        let (knots, cost, origin) = self.best.as_ref()?;
        Some(Progress {
            knots,
            cost: *cost,
            origin: *origin,
            nominal_cost: self.nominal_cost,
            iterations: self.finished,
            simulated: self.simulated,
            diverged: self.diverged,
        })
    }

    /// The best plan so far, which the planner keeps for the next time; none before the first batch
    /// was simulated.
    pub fn finish(mut self, elapsed: Duration) -> Option<Plan> {
        let (knots, cost, origin) = self.best?;
        let planner = self.planner.borrow_mut();
        planner.nominal.clone_from(&knots);
        Some(Plan {
            knots,
            cost,
            origin,
            nominal_cost: self.nominal_cost,
            best_sample: self.best_sample,
            costs: self.costs,
            iterations: self.finished,
            met_deadline: self.finished < planner.settings.iterations,
            time: elapsed,
        })
    }

    /// Keeps the best, whose place it returns if it is new, and the best sample.
    fn note(&mut self, costs: &[f64]) -> Option<usize> {
        let mut place = None;
        let is_first = self.costs.is_empty();
        for (i, (plan, cost)) in self.batch.iter().zip(costs).enumerate() {
            let origin = match (is_first && i == 0, self.is_mean) {
                (true, _) => Origin::Nominal,
                (false, true) => Origin::Mean,
                (false, false) => Origin::Sample,
            };
            if origin == Origin::Nominal {
                self.nominal_cost = *cost;
            }
            if self.best.as_ref().is_none_or(|b| *cost < b.1) {
                self.best = Some((plan.clone(), *cost, origin));
                place = Some(i);
            }
            let is_better = self.best_sample.as_ref().is_none_or(|b| *cost < b.1);
            if origin == Origin::Sample && is_better {
                self.best_sample = Some((plan.clone(), *cost));
            }
        }
        place
    }
}

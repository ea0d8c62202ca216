//! A plan in the making: batches to simulate one after another, and the best so far. The simulating
//! caller calls [`Search::propose`] and [`Search::learn`] in turn, so this works with any clock and
//! any way to wait.

use std::{borrow::BorrowMut, time::Duration};

use crate::{
    Knots, Planner, Settings,
    error::Error,
    method::{Batch, Descent, Method, Sampling},
};

/// Result of simulating a batch of plans.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Cost of each plan; infinite where it diverged.
    pub costs: Vec<f64>,
    /// d cost / d knots of each plan, shape [K, D]; only [`Method::Gradient`] needs them.
    pub gradients: Vec<Knots>,
    /// Excess of each plan over limits, 0 for one that keeps them: plans beyond a limit are worse than
    /// all that keep them, at any cost. Empty: all keep them.
    pub excess: Vec<f64>,
}

/// Rank of a plan: what keeps the limit first, then by how far it is beyond, then by cost.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct Rank {
    /// Infinite for a plan that diverged.
    excess: f64,
    pub(crate) cost: f64,
}

impl Rank {
    /// Rank of a plan; NaN is worst.
    fn new(cost: f64, excess: f64) -> Self {
        let cost = if cost.is_nan() { f64::INFINITY } else { cost };
        let is_known = cost.is_finite() && !excess.is_nan();
        Self { excess: if is_known { excess.max(0.0) } else { f64::INFINITY }, cost }
    }

    fn keeps_limit(self) -> bool {
        self.excess == 0.0
    }
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
    /// Knots of the plan, shape [K, D].
    pub knots: Knots,
    /// Cost of exactly these knots, as simulated.
    pub cost: f64,
    /// Source of the plan.
    pub origin: Origin,
    /// Excess over the limit: 0 unless every plan was beyond.
    pub excess: f64,
    /// Cost of the nominal plan.
    pub nominal_cost: f64,
    /// Best of the samples, with its cost; none if none was simulated.
    pub best_sample: Option<(Knots, f64)>,
    /// Costs of all that was simulated, batch by batch.
    pub costs: Vec<Vec<f64>>,
    /// Iterations that were finished.
    pub iterations: usize,
    /// True if there was no time for all iterations.
    pub stopped_by_deadline: bool,
    /// Time that it took.
    pub time: Duration,
}

/// The best so far, while a plan is being made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'s> {
    /// Knots of the plan, shape [K, D].
    pub knots: &'s Knots,
    /// Cost of exactly these knots, as simulated.
    pub cost: f64,
    /// Source of the plan.
    pub origin: Origin,
    /// Cost of the nominal plan.
    pub nominal_cost: f64,
    /// Iterations that were finished.
    pub iterations: usize,
    /// Plans that were simulated.
    pub simulated: usize,
    /// Plans among them that diverged.
    pub diverged: usize,
    /// Plans among them that did not, and were beyond the limit.
    pub beyond_limit: usize,
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
    best: Option<(Knots, Rank, Origin)>,
    best_sample: Option<(Knots, Rank)>,
    nominal_cost: f64,
    costs: Vec<Vec<f64>>,
    simulated: usize,
    diverged: usize,
    beyond_limit: usize,
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
            beyond_limit: 0,
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

    /// Takes in the results of the last batch, `elapsed` after the search began. Returns the place
    /// in the batch of the best plan so far, if it is in this batch.
    ///
    /// # Errors
    /// If the evaluation is not one of the batch, or all plans so far diverged.
    pub fn learn<E>(
        &mut self,
        evaluation: Evaluation,
        elapsed: Duration,
    ) -> Result<Option<usize>, Error<E>> {
        let Evaluation { mut costs, gradients, excess } = evaluation;
        let settings = &self.planner.borrow().settings;
        let shape = settings.knots * settings.dims;
        let right = gradients.iter().filter(|g| g.len() == shape).count();
        let (plans, needed) = (self.batch.len(), settings.method.needs_gradients());
        let is_right = costs.len() == plans && (excess.is_empty() || excess.len() == plans);
        if !is_right || (needed && right != plans) {
            return Err(Error::Shape { plans, costs: costs.len(), gradients: right });
        }
        for cost in costs.iter_mut().filter(|c| c.is_nan()) {
            *cost = f64::INFINITY;
        }
        self.longest = self.longest.max(elapsed.saturating_sub(self.started));
        self.simulated += plans;
        let beyond = excess.iter().copied().chain(std::iter::repeat(0.0));
        let ranks: Vec<Rank> = costs.iter().zip(beyond).map(|(c, e)| Rank::new(*c, e)).collect();
        let diverged = ranks.iter().filter(|rank| rank.excess.is_infinite()).count();
        self.diverged += diverged;
        self.beyond_limit += ranks.iter().filter(|rank| !rank.keeps_limit()).count() - diverged;
        let place = self.note(&ranks);
        let settings = &self.planner.borrow().settings;
        let best = self.best.as_ref().filter(|b| b.1.excess.is_finite());
        let Some((best, first, _)) = best else { return Err(Error::EveryPlanDiverged) };
        if !self.is_mean {
            self.finished += 1;
            match (&mut self.state, &settings.method) {
                (State::Descent(descent), Method::Gradient { rate }) => {
                    let batch = Batch {
                        diverged: ranks.iter().map(|rank| rank.excess.is_infinite()).collect(),
                        beyond: ranks.iter().map(|rank| !rank.keeps_limit()).collect(),
                        gradients,
                    };
                    descent.learn(settings, rate, &batch, (best, first.keeps_limit()));
                }
                (State::Sampling(sampling), method) => {
                    let plans: Vec<&Knots> = std::iter::once(best).chain(&self.batch).collect();
                    // As long as none keeps the limit, less beyond it is better.
                    let worth = |rank: &Rank| match (first.keeps_limit(), rank.keeps_limit()) {
                        (true, true) => rank.cost,
                        (true, false) => f64::INFINITY,
                        (false, _) => rank.excess,
                    };
                    let known: Vec<f64> = std::iter::once(first).chain(&ranks).map(worth).collect();
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

    /// Rank of the best so far; none before the first batch was simulated.
    pub(crate) fn rank(&self) -> Option<Rank> {
        self.best.as_ref().map(|(_, rank, _)| *rank)
    }

    /// Changes the number of samples from the next iteration on, of methods that sample.
    pub(crate) fn set_samples(&mut self, samples: usize) {
        self.planner.borrow_mut().settings.samples = samples;
    }

    /// Numbers of plans that were simulated, of the diverged ones among them, and of those that did not
    /// and were beyond a limit.
    pub(crate) fn counts(&self) -> [usize; 3] {
        [self.simulated, self.diverged, self.beyond_limit]
    }

    /// The best so far; none before the first batch was simulated.
    pub fn progress(&self) -> Option<Progress<'_>> {
        let (knots, rank, origin) = self.best.as_ref()?;
        Some(Progress {
            knots,
            cost: rank.cost,
            origin: *origin,
            nominal_cost: self.nominal_cost,
            iterations: self.finished,
            simulated: self.simulated,
            diverged: self.diverged,
            beyond_limit: self.beyond_limit,
        })
    }

    /// The best plan so far, which the planner keeps for the next time; none before the first batch
    /// was simulated.
    pub fn finish(mut self, elapsed: Duration) -> Option<Plan> {
        let (knots, rank, origin) = self.best?;
        let planner = self.planner.borrow_mut();
        planner.nominal.clone_from(&knots);
        Some(Plan {
            knots,
            cost: rank.cost,
            origin,
            excess: rank.excess,
            nominal_cost: self.nominal_cost,
            best_sample: self.best_sample.map(|(knots, rank)| (knots, rank.cost)),
            costs: self.costs,
            iterations: self.finished,
            stopped_by_deadline: self.finished < planner.settings.iterations,
            time: elapsed,
        })
    }

    /// Keeps the best, whose place it returns if it is new, and the best sample.
    fn note(&mut self, ranks: &[Rank]) -> Option<usize> {
        let mut place = None;
        let is_first = self.costs.is_empty();
        for (i, (plan, rank)) in self.batch.iter().zip(ranks).enumerate() {
            let origin = match (is_first && i == 0, self.is_mean) {
                (true, _) => Origin::Nominal,
                (false, true) => Origin::Mean,
                (false, false) => Origin::Sample,
            };
            if origin == Origin::Nominal {
                self.nominal_cost = rank.cost;
            }
            if self.best.as_ref().is_none_or(|b| *rank < b.1) {
                self.best = Some((plan.clone(), *rank, origin));
                place = Some(i);
            }
            let is_better = self.best_sample.as_ref().is_none_or(|b| *rank < b.1);
            if origin == Origin::Sample && is_better {
                self.best_sample = Some((plan.clone(), *rank));
            }
        }
        place
    }
}

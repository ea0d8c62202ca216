//! A planner with a warm start.

use std::time::Instant;

use rand::SeedableRng as _;
use rand_chacha::ChaCha12Rng;

use crate::{
    Knots,
    error::{Error, Invalid},
    search::{Evaluation, Plan, Search},
    settings::Settings,
};

/// The cost of plans.
pub trait Evaluate {
    /// Failure of a simulation.
    type Error;

    /// Simulates a batch of plans, each of shape [K, D]; with gradients if the method needs them.
    ///
    /// # Errors
    /// If there is no cost to be had, even of a plan that diverges.
    fn evaluate(&mut self, plans: &[Knots]) -> Result<Evaluation, Self::Error>;
}

/// A planner that begins each plan where the one before it ended: after executing some frames call
/// [`Planner::shift`], then plan from the new state.
#[derive(Debug)]
pub struct Planner {
    pub(crate) settings: Settings,
    pub(crate) random: ChaCha12Rng,
    pub(crate) nominal: Knots,
}

impl Planner {
    /// A planner whose first plan begins with zeros, or as near as the bounds allow.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn new(settings: Settings) -> Result<Self, Invalid> {
        settings.check()?;
        let random = ChaCha12Rng::seed_from_u64(settings.seed);
        let mut nominal = vec![0.0; settings.knots * settings.dims];
        settings.project(&mut nominal);
        Ok(Self { settings, random, nominal })
    }

    /// Settings that it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The plan that the next one begins with, shape [K, D].
    pub fn nominal(&self) -> &[f64] {
        &self.nominal
    }

    /// Begins the next plan with other knots, moved within the bounds.
    ///
    /// # Errors
    /// If they do not have the planner's shape, or are not finite.
    pub fn set_nominal(&mut self, mut nominal: Knots) -> Result<(), Invalid> {
        let Settings { knots, dims, .. } = self.settings;
        if nominal.len() != knots * dims || nominal.iter().any(|x| !x.is_finite()) {
            let problem = format!("give {knots} x {dims} finite values");
            return Err(Invalid::new("nominal", problem));
        }
        self.settings.project(&mut nominal);
        self.nominal = nominal;
        Ok(())
    }

    /// Moves the nominal plan on by frames that were executed; at its end it stands still.
    pub fn shift(&mut self, frames: f64) {
        let s = &self.settings;
        self.nominal = s.shifted(&self.nominal, s.dims, frames);
        s.project(&mut self.nominal);
    }

    /// Begins to better the nominal plan, batch by batch.
    pub fn search(&mut self) -> Search<&mut Self> {
        Search::begin(self)
    }

    /// The search that owns the planner.
    pub fn into_search(self) -> Search<Self> {
        Search::begin(self)
    }

    /// Betters the nominal plan.
    ///
    /// # Errors
    /// If a simulation fails, or every plan of the first iteration diverges.
    pub fn plan<E: Evaluate>(&mut self, cost: &mut E) -> Result<Plan, Error<E::Error>> {
        let began = Instant::now();
        let mut search = self.search();
        while let Some(plans) = search.propose(began.elapsed()) {
            let evaluation = cost.evaluate(plans).map_err(Error::Evaluate)?;
            search.learn(evaluation, began.elapsed())?;
        }
        search.finish(began.elapsed()).ok_or(Error::EveryPlanDiverged)
    }
}

#[cfg(test)]
mod tests;

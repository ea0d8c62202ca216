//! A search over places to begin at, by successive halving: each place has its own [`Search`], all
//! share the samples of an iteration, and the worse half of the places is given up after each round.
//! The batches of an iteration therefore have one size, while the places that remain get more samples.
//! A single place is searched as [`Search`] alone does.

use std::time::Duration;

use crate::{
    Knots, Method, Planner, Settings,
    error::{Error, Invalid},
    search::{Evaluation, Progress, Rank, Search},
};

/// Halvings after which one of `places` is left, and one more round, for that place alone.
pub fn rounds(places: usize) -> usize {
    let halvings = places.max(1).next_power_of_two().trailing_zeros();
    1 + halvings as usize
}

/// Fewest samples that a place can be searched with: with methods that sample the nominal plan, the one
/// that stays still, and a sample.
fn least_samples(method: &Method) -> usize {
    if method.needs_gradients() { 1 } else { 3 }
}

/// A plan being made, of several places of which the best is taken.
#[derive(Debug)]
pub struct PlaceSearch {
    settings: Settings,
    searches: Vec<Search<Planner>>,
    /// Places that are still searched, ascending.
    left: Vec<usize>,
    /// Place of each plan of the batch.
    place_of: Vec<usize>,
    /// Iterations of this round that are still to be made, and places that are left after it.
    round: usize,
    goal: usize,
    best: Option<(usize, Rank)>,
}

impl PlaceSearch {
    /// A search of as many places as there are nominal plans, shape [K, D], counted from each. All of them
    /// begin with the same random numbers, so that differences between places are not those of luck.
    ///
    /// # Errors
    /// If there is no place, a nominal plan or a setting is wrong, or there are too few samples or
    /// iterations for the places.
    pub fn new(settings: Settings, nominals: Vec<Knots>) -> Result<Self, Invalid> {
        check_places(&settings, nominals.len())?;
        let count = nominals.len();
        let own = Settings { samples: settings.samples / count, ..settings.clone() };
        let begun = |nominal| {
            let mut planner = Planner::new(own.clone())?;
            planner.set_nominal(nominal)?;
            Ok(planner.into_search())
        };
        let searches = nominals.into_iter().map(begun).collect::<Result<_, Invalid>>()?;
        Ok(Self {
            searches,
            left: (0..count).collect(),
            place_of: Vec::new(),
            round: settings.iterations / rounds(count),
            goal: count.div_ceil(2),
            best: None,
            settings,
        })
    }

    /// Proposes the next batch, `elapsed` after the search began; false if the search has ended, or if
    /// there is no time for another batch.
    pub fn propose(&mut self, elapsed: Duration) -> bool {
        self.place_of.clear();
        let (each, more) =
            (self.settings.samples / self.left.len(), self.settings.samples % self.left.len());
        for (i, place) in self.left.iter().enumerate() {
            let search = &mut self.searches[*place];
            if !self.settings.method.needs_gradients() {
                search.set_samples(each + usize::from(i < more));
            }
            // All of them have run for as long, so the deadline ends all or none.
            let Some(plans) = search.propose(elapsed) else {
                self.place_of.clear();
                return false;
            };
            self.place_of.resize(self.place_of.len() + plans.len(), *place);
        }
        true
    }

    /// The plans that were proposed last, shape [K, D] each, with their places.
    pub fn batch(&self) -> impl Iterator<Item = (usize, &Knots)> {
        let plans = self.left.iter().flat_map(|place| self.searches[*place].batch());
        self.place_of.iter().copied().zip(plans)
    }

    /// Takes in the results of the last batch, `elapsed` after the search began. Returns the index in the
    /// batch of the best plan so far, if it is in this batch.
    ///
    /// # Errors
    /// If the evaluation is not one of the batch, or all plans of all places so far diverged.
    pub fn learn<E>(
        &mut self,
        evaluation: Evaluation,
        elapsed: Duration,
    ) -> Result<Option<usize>, Error<E>> {
        let plans = self.place_of.len();
        let Evaluation { costs, gradients, excess } = evaluation;
        let has_all = |len: usize| len == 0 || len == plans;
        if costs.len() != plans || !has_all(gradients.len()) || !has_all(excess.len()) {
            return Err(Error::Shape { plans, costs: costs.len(), gradients: gradients.len() });
        }
        let mut gradients = gradients.into_iter();
        let (mut first, mut new) = (0, None);
        let mut lost = Vec::new();
        for place in &self.left {
            let search = &mut self.searches[*place];
            let of = first..first + search.batch().len();
            let part = Evaluation {
                costs: costs[of.clone()].to_vec(),
                gradients: gradients.by_ref().take(of.len()).collect(),
                excess: excess.get(of.clone()).unwrap_or_default().to_vec(),
            };
            match search.learn::<E>(part, elapsed) {
                Ok(found) => {
                    let found = found.and_then(|i| Some((of.start + i, search.rank()?)));
                    if let Some((i, rank)) = found
                        && self.best.is_none_or(|(_, best)| rank < best)
                    {
                        (self.best, new) = (Some((*place, rank)), Some(i));
                    }
                }
                Err(Error::EveryPlanDiverged) => lost.push(*place),
                Err(other) => return Err(other),
            }
            first = of.end;
        }
        self.left.retain(|place| !lost.contains(place));
        if self.left.is_empty() {
            return Err(Error::EveryPlanDiverged);
        }
        self.end_iteration();
        Ok(new)
    }

    /// Settings of all places together.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The best so far, of any place, and its place; none before the first batch was simulated. Counts
    /// of plans are of all places.
    pub fn progress(&self) -> Option<(usize, Progress<'_>)> {
        let (place, _) = self.best?;
        let best = self.searches[place].progress()?;
        let counts = self.searches.iter().map(Search::counts);
        let [simulated, diverged, beyond_limit] =
            counts.fold([0; 3], |sums, own| std::array::from_fn(|i| sums[i] + own[i]));
        Some((place, Progress { simulated, diverged, beyond_limit, ..best }))
    }

    /// Cost of the best plan of each place so far, also of those that were given up; infinite where every
    /// plan diverged.
    pub fn costs(&self) -> Vec<f64> {
        let cost = |search: &Search<Planner>| search.rank().map_or(f64::INFINITY, |rank| rank.cost);
        self.searches.iter().map(cost).collect()
    }

    /// Gives up the worse places at the end of a round; of equal ones the first are kept. The last place
    /// has all further iterations.
    fn end_iteration(&mut self) {
        self.round = self.round.saturating_sub(1);
        if self.round > 0 || self.left.len() == 1 {
            return;
        }
        let searches = &self.searches;
        self.left.sort_by(|a, b| {
            let ranks = [a, b].map(|place| searches[*place].rank());
            ranks[0].partial_cmp(&ranks[1]).unwrap_or(std::cmp::Ordering::Equal).then(a.cmp(b))
        });
        self.left.truncate(self.goal);
        self.left.sort_unstable();
        self.goal = self.left.len().div_ceil(2);
        self.round = self.settings.iterations / rounds(self.searches.len());
    }
}

/// Checks that a number of places can be searched with these settings.
///
/// # Errors
/// If it is 0, or there are too few samples or iterations for it.
pub fn check_places(settings: &Settings, places: usize) -> Result<(), Invalid> {
    if places == 0 {
        return Err(Invalid::new("places", "give one or more"));
    }
    if places == 1 {
        return Ok(());
    }
    let least = least_samples(&settings.method);
    if settings.samples < least.saturating_mul(places) {
        let (is, needed) = (settings.samples, least.saturating_mul(places));
        let problem = format!("is {is}: {places} places share {needed} or more, {least} for each");
        return Err(Invalid::new("samples", problem));
    }
    let rounds = rounds(places);
    if settings.iterations < rounds {
        let is = settings.iterations;
        let problem = format!(
            "is {is}: {places} places need {rounds} or more, one until each halving and one for the last place"
        );
        return Err(Invalid::new("iterations", problem));
    }
    Ok(())
}

#[cfg(test)]
mod tests;

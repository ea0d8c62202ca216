//! The time that a user gives a fit: how many generations and passes fit into it, from the time that
//! the first of them took.

use std::time::{Duration, Instant};

/// Share of the time until the search ends.
const SEARCH_SHARE: f64 = 0.3;
/// Share of the time until the refinement ends; the evaluation has the rest.
const REFINE_SHARE: f64 = 0.92;

/// The clock of a fit with a time limit. A resumed fit continues with the time that it has spent
/// before.
pub(crate) struct TimeLimit {
    limit_s: f64,
    spent_before_s: f64,
    began: Instant,
}

impl TimeLimit {
    pub(crate) fn new(limit_s: f64) -> Self {
        Self { limit_s, spent_before_s: 0.0, began: Instant::now() }
    }

    /// Takes over the time that was spent before.
    pub(crate) fn resume(&mut self, spent_s: f64) {
        self.spent_before_s = spent_s;
    }

    /// Time spent so far [s].
    pub(crate) fn spent_s(&self) -> f64 {
        self.spent_before_s + self.began.elapsed().as_secs_f64()
    }

    /// Generations that fit, at most `most`, after `done` that took `each_s` each.
    pub(crate) fn generations(&self, most: u32, done: u32, each_s: f64) -> u32 {
        fitting(SEARCH_SHARE * self.limit_s - self.spent_s(), most, done, each_s)
    }

    /// Passes that fit, at most `most`, after `done` that took `each_s` each.
    pub(crate) fn passes(&self, most: u32, done: u32, each_s: f64) -> u32 {
        fitting(REFINE_SHARE * self.limit_s - self.spent_s(), most, done, each_s)
    }

    /// The moment at which the time is over.
    pub(crate) fn end(&self) -> Instant {
        let left_s = (self.limit_s - self.spent_s()).max(0.0);
        Instant::now() + Duration::from_secs_f64(left_s)
    }

    /// True if no further pass should begin that takes so long.
    pub(crate) fn is_over(&self, each_s: f64) -> bool {
        self.spent_s() + each_s > REFINE_SHARE * self.limit_s
    }
}

/// Iterations in all, when `left_s` are left after `done` of them.
fn fitting(left_s: f64, most: u32, done: u32, each_s: f64) -> u32 {
    let more = if each_s > 0.0 { (left_s / each_s).floor().max(0.0) } else { f64::from(most) };
    // Beyond u32 it saturates.
    done.saturating_add(more as u32).min(most).max(done)
}

#[cfg(test)]
mod tests;

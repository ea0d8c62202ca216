//! Step length and gradient reach of an optimizer run: both shrink after passes without a gain.

use serde::{Deserialize, Serialize};

/// Share of the learning rate that is left in the last pass, where it falls.
const FINAL_RATE: f64 = 0.1;
/// Share of the first rate below which a run that keeps failing stays at its best parameters.
const MIN_RATE: f64 = 1e-3;
/// Steps over which the rate grows to its full value: Adam's first steps are equally long along
/// every coordinate, however little it matters.
const WARM_UP: u64 = 8;
/// Largest ratio of a gradient's norm to the median of recent ones; longer gradients are clipped.
const MAX_NORM_RATIO: f64 = 3.0;
/// Number of recent gradients in the median.
const NORM_HISTORY: usize = 15;
/// Passes without a better loss after which a run whose passes are single steps rolls back.
const PATIENCE: u32 = 12;
/// The same where a pass has several steps, as a share of all passes,
const PATIENCE_SHARE: f64 = 1.0 / 12.0;
/// and at least.
const MIN_PATIENCE: u32 = 6;
/// A run has ended when this many passes
const IDLE_PASSES: usize = 40;
/// lower its best loss by less than this share.
const LEAST_GAIN: f64 = 0.01;
/// Largest reach of gradients [frames] after the first cut; each further cut leaves a quarter.
const FIRST_CUT_REACH: u32 = 16;

/// Schedule of the steps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Schedule {
    /// A pass is one step along the gradient of the whole loss. Neither the rate nor when it ends
    /// depends on how many passes there may be, so that more passes never end at a larger loss.
    Whole,
    /// A pass has several steps, each along the gradient of a part of the loss, which would never
    /// settle without a rate that falls over all passes.
    Parts {
        /// Number of all passes.
        passes: u32,
    },
}

/// Length and reach of the steps of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepControl {
    /// Share of the learning rate, halved by rollbacks.
    rate: f64,
    /// Reach of gradients [frames]; 0 is the whole window.
    reach: u32,
    /// Passes since the best one, or since the last rollback.
    stale: u32,
    /// Number of rollbacks since the best pass.
    failures: u32,
    /// Norms of the last gradients.
    norms: Vec<f64>,
    /// Best losses after the last passes.
    best_losses: Vec<f64>,
}

impl StepControl {
    /// The initial state, with the reach from the settings [frames].
    pub(crate) fn new(reach: u32) -> Self {
        Self { rate: 1.0, reach, stale: 0, failures: 0, norms: Vec::new(), best_losses: Vec::new() }
    }

    /// Reach of gradients [frames]; 0 is the whole window.
    pub(crate) fn reach(&self) -> usize {
        self.reach as usize
    }

    /// True if steps are still long enough to matter.
    pub(crate) fn can_continue(&self) -> bool {
        self.rate >= MIN_RATE
    }

    /// Share of the learning rate in a pass, after `steps` steps of Adam.
    pub(crate) fn rate(&self, schedule: Schedule, pass: u32, steps: u64) -> f64 {
        let done = match schedule {
            Schedule::Whole => 0.0,
            Schedule::Parts { passes } => f64::from(pass) / f64::from(passes.max(1)),
        };
        let warm = (steps + 1).min(WARM_UP) as f64 / WARM_UP as f64;
        self.rate * warm * (1.0 - (1.0 - FINAL_RATE) * done)
    }

    /// Records the best loss at the end of a pass; true if the run has ended, since the last passes
    /// gained next to nothing.
    pub(crate) fn has_ended(&mut self, best_loss: f64) -> bool {
        self.best_losses.push(best_loss);
        if self.best_losses.len() <= IDLE_PASSES {
            return false;
        }
        let before = self.best_losses.remove(0);
        best_loss > (1.0 - LEAST_GAIN) * before
    }

    /// Factor that clips a gradient of this norm, at most 1. Near a bifurcation of the motion the
    /// gradient is larger by orders of magnitude for a pass, and without clipping Adam would take
    /// tiny steps for a hundred passes after.
    pub(crate) fn clip_factor(&mut self, norm: f64) -> f64 {
        self.norms.push(norm);
        if self.norms.len() > NORM_HISTORY {
            self.norms.remove(0);
        }
        let mut sorted = self.norms.clone();
        sorted.sort_by(f64::total_cmp);
        let longest = MAX_NORM_RATIO * sorted[sorted.len() / 2];
        if norm > longest && longest > 0.0 { longest / norm } else { 1.0 }
    }

    /// Records a pass that was the best so far.
    pub(crate) fn record_gain(&mut self) {
        (self.stale, self.failures) = (0, 0);
    }

    /// Records a pass without a gain; `Some` with the number of such passes if it is time to roll
    /// back.
    pub(crate) fn record_no_gain(&mut self, schedule: Schedule) -> Option<u32> {
        self.stale += 1;
        let patience = match schedule {
            Schedule::Whole => PATIENCE,
            Schedule::Parts { passes } => {
                ((f64::from(passes) * PATIENCE_SHARE) as u32).max(MIN_PATIENCE)
            }
        };
        (self.stale >= patience).then_some(patience)
    }

    /// Adapts to a rollback after passes without a gain: halves the rate, and every second time
    /// cuts the reach, since gradients through many frames may have become meaningless. Returns a
    /// description of the change.
    pub(crate) fn back_off(&mut self) -> String {
        self.stale = 0;
        self.failures += 1;
        if self.failures.is_multiple_of(2) { self.cut_reach() } else { self.halve_rate() }
    }

    /// Adapts to a rollback after a gradient that is not finite. Returns a description of the
    /// change.
    pub(crate) fn shorten_reach(&mut self) -> String {
        self.stale = 0;
        self.cut_reach()
    }

    /// Adapts to a rollback after parameters that cannot be simulated. Returns a description of the
    /// change.
    pub(crate) fn halve_rate(&mut self) -> String {
        self.stale = 0;
        self.rate *= 0.5;
        "halved the rate".into()
    }

    fn cut_reach(&mut self) -> String {
        let Some(shorter) = shorter_reach(self.reach) else { return self.halve_rate() };
        self.reach = shorter;
        format!("gradients now reach {shorter} frames")
    }
}

/// The next shorter reach, if there is one.
fn shorter_reach(reach: u32) -> Option<u32> {
    match reach {
        0 => Some(FIRST_CUT_REACH),
        1 => None,
        far => Some((far / 4).clamp(1, FIRST_CUT_REACH)),
    }
}

#[cfg(test)]
mod tests;

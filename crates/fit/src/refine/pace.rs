//! How long the steps of a walk are and how far its gradients reach: both shrink where they lead nowhere.

use serde::{Deserialize, Serialize};

/// Share of the learning rate that is left in the last pass.
const FINAL_RATE: f64 = 0.1;
/// Below this share of its first rate a walk that keeps failing stays where it was best.
const SMALLEST_RATE: f64 = 1e-3;
/// Steps over which the rate grows to its full length: the first of Adam go equally far along every coordinate,
/// however little it matters.
const WARM_UP: u64 = 8;
/// A gradient longer than so many times the usual one counts with that length.
const LONGEST: f64 = 3.0;
/// Gradients that tell what is usual.
const REMEMBERED: usize = 15;
/// Passes without a better loss after which a walk goes back, as a share of all passes, and at least.
const PATIENCE: f64 = 1.0 / 12.0;
const LEAST_PATIENCE: u32 = 6;
/// Frames that gradients reach back at most once they had to be cut; a quarter after each further time.
const FIRST_REACH: u32 = 16;

/// The pace of a walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pace {
    /// Share of the learning rate, halved again and again.
    rate: f64,
    /// Frames that gradients reach back; 0 is as far as the window goes.
    reach: u32,
    /// Passes since the best one, or since the walk went back.
    stale: u32,
    /// How often it went back since the best pass.
    failures: u32,
    /// Lengths of the last gradients.
    lengths: Vec<f64>,
}

impl Pace {
    /// At the start, with gradients that reach as far as the settings say.
    pub(crate) fn new(reach: u32) -> Self {
        Self { rate: 1.0, reach, stale: 0, failures: 0, lengths: Vec::new() }
    }

    /// How many frames gradients reach back; 0 is as far as the window goes.
    pub(crate) fn reach(&self) -> usize {
        self.reach as usize
    }

    /// Whether steps are still long enough to matter.
    pub(crate) fn goes_on(&self) -> bool {
        self.rate >= SMALLEST_RATE
    }

    /// Share of the learning rate in this pass, all of it, where so many steps of Adam were done before: it falls linearly,
    /// so that the walk comes to rest.
    pub(crate) fn rate(&self, pass: u32, passes: u32, steps: u64) -> f64 {
        let done = f64::from(pass) / f64::from(passes.max(1));
        let warm = (steps + 1).min(WARM_UP) as f64 / WARM_UP as f64;
        self.rate * warm * (1.0 - (1.0 - FINAL_RATE) * done)
    }

    /// By how much to shorten a gradient of this length. Where motion comes near a branching point the gradient is
    /// longer by orders of magnitude for a pass, and Adam would take tiny steps for a hundred passes after.
    pub(crate) fn shorten(&mut self, length: f64) -> f64 {
        self.lengths.push(length);
        if self.lengths.len() > REMEMBERED {
            self.lengths.remove(0);
        }
        let mut sorted = self.lengths.clone();
        sorted.sort_by(f64::total_cmp);
        let longest = LONGEST * sorted[sorted.len() / 2];
        if length > longest && longest > 0.0 { longest / length } else { 1.0 }
    }

    /// A pass was the best so far.
    pub(crate) fn gain(&mut self) {
        (self.stale, self.failures) = (0, 0);
    }

    /// A pass was not; `Some` with how many were not if it is time to go back.
    pub(crate) fn no_gain(&mut self, passes: u32) -> Option<u32> {
        self.stale += 1;
        let patience = ((f64::from(passes) * PATIENCE) as u32).max(LEAST_PATIENCE);
        (self.stale >= patience).then_some(patience)
    }

    /// The walk goes back because steps led nowhere: they are too long, or, the second time, their gradients have
    /// lost their way through many frames. Says what changes.
    pub(crate) fn fail(&mut self) -> String {
        self.stale = 0;
        self.failures += 1;
        if self.failures.is_multiple_of(2) { self.reach_less() } else { self.slow_down() }
    }

    /// The walk goes back because a gradient has left the finite numbers. Says what changes.
    pub(crate) fn overflow(&mut self) -> String {
        self.stale = 0;
        self.reach_less()
    }

    /// The walk goes back because its parameters cannot be simulated. Says what changes.
    pub(crate) fn slow_down(&mut self) -> String {
        self.stale = 0;
        self.rate *= 0.5;
        "halved the rate".into()
    }

    fn reach_less(&mut self) -> String {
        let Some(shorter) = shorter(self.reach) else { return self.slow_down() };
        self.reach = shorter;
        format!("gradients now reach {shorter} frames")
    }
}

/// The next shorter reach, if there is one.
fn shorter(reach: u32) -> Option<u32> {
    match reach {
        0 => Some(FIRST_REACH),
        1 => None,
        far => Some((far / 4).clamp(1, FIRST_REACH)),
    }
}

#[cfg(test)]
mod tests;

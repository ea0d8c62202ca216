//! Alternation of fits and rollouts on a device that has a queue for each. Rollouts go first: while
//! any runs or waits, a fit pauses at the end of its frame. The time for which it waits is counted,
//! and once enough of it is owed to the fit, the rollouts pause at the end of theirs: so a fit has
//! its share of every tenth of a second or so, and a lone rollout never waits for a batch of the
//! fit.
//!
//! Both sides wait inside a [`CancelToken`](bendtwin_core::CancelToken), which backends check from
//! frame to frame. Pauses decide when a frame is computed, never what is in it: results do not
//! depend on them.

use std::{
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use bendtwin_core::{CancelToken, cancel::Pause};

use super::Priority;
use crate::priority;

/// Device time that is owed to a fit when its turn comes [s]: the shortest turn, for which a rollout
/// may have to wait.
const TURN_S: f64 = 0.004;
/// Most time that a fit may be owed, and be ahead by [s]: a frame may take long, and neither side
/// should have the device for itself for long because of that.
const MOST_S: f64 = 0.25;
/// Longest time between checks of the token while a fit waits.
const LOOK: Duration = Duration::from_millis(100);

/// Turns of fits and rollouts. Clones share them.
#[derive(Clone)]
pub(super) struct Alternation(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    /// True while there are rollouts: fits then have to check the state.
    has_rollouts: AtomicBool,
}

/// A rollout's task that waits or runs. It ends when this is dropped.
pub(super) struct UnderWay(Alternation);

impl Alternation {
    /// Fits get this share of the time, 0 to below 1, while rollouts want all of it.
    pub(super) fn new(fit_share: f64) -> Self {
        Self(Arc::new(Shared {
            state: Mutex::new(State::new(fit_share, Instant::now())),
            changed: Condvar::new(),
            has_rollouts: AtomicBool::new(false),
        }))
    }

    /// Counts a rollout's task.
    pub(super) fn begin(&self) -> UnderWay {
        let mut state = self.0.lock();
        state.advance(Instant::now());
        state.rollouts += 1;
        self.0.has_rollouts.store(true, Ordering::SeqCst);
        UnderWay(self.clone())
    }

    /// The token with this side's pauses in it.
    pub(super) fn token(&self, priority: Priority, cancel: &CancelToken) -> CancelToken {
        match priority {
            Priority::Background => cancel.with_pause(Arc::new(Fit(Arc::clone(&self.0)))),
            Priority::Interactive => cancel.with_pause(Arc::new(Rollout(Arc::clone(&self.0)))),
        }
    }
}

impl Drop for UnderWay {
    fn drop(&mut self) {
        let shared = &self.0.0;
        let mut state = shared.lock();
        state.advance(Instant::now());
        state.rollouts = state.rollouts.saturating_sub(1);
        if state.rollouts == 0 {
            shared.has_rollouts.store(false, Ordering::SeqCst);
            shared.changed.notify_all();
        }
    }
}

impl Shared {
    /// Locks the state; code inside the lock cannot panic half way.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a while, or until the last rollout has ended.
    fn wait<'s>(&self, state: MutexGuard<'s, State>, time: Duration) -> MutexGuard<'s, State> {
        self.changed.wait_timeout(state, time).unwrap_or_else(PoisonError::into_inner).0
    }
}

/// The pauses of a fit.
struct Fit(Arc<Shared>);

impl Pause for Fit {
    fn pass(&self, is_cancelled: &dyn Fn() -> bool) {
        // Only threads of fits come here.
        priority::as_fit();
        if !self.0.has_rollouts.load(Ordering::SeqCst) {
            return;
        }
        let mut state = self.0.lock();
        state.advance(Instant::now());
        state.fits_waiting += 1;
        while !state.fit_may_run() && !is_cancelled() {
            let time = state.time_to_fit().min(LOOK);
            state = self.0.wait(state, time);
            state.advance(Instant::now());
        }
        state.fits_waiting -= 1;
    }
}

/// The pauses of a rollout.
struct Rollout(Arc<Shared>);

impl Pause for Rollout {
    fn pass(&self, is_cancelled: &dyn Fn() -> bool) {
        let mut state = self.0.lock();
        state.advance(Instant::now());
        while state.is_turn_of_fit && !is_cancelled() {
            let time = state.time_to_rollouts().min(LOOK);
            state = self.0.wait(state, time);
            state.advance(Instant::now());
        }
    }
}

/// The account of both sides.
#[derive(Debug)]
struct State {
    fit_share: f64,
    /// Tasks of rollouts that wait or run.
    rollouts: usize,
    /// Threads of fits that wait.
    fits_waiting: usize,
    is_turn_of_fit: bool,
    /// Time that fits are short of their share [s]; negative if they are ahead.
    owed_s: f64,
    /// Time up to which this account goes.
    at: Instant,
}

impl State {
    fn new(fit_share: f64, now: Instant) -> Self {
        Self {
            fit_share,
            rollouts: 0,
            fits_waiting: 0,
            is_turn_of_fit: false,
            owed_s: 0.0,
            at: now,
        }
    }

    fn fit_may_run(&self) -> bool {
        self.rollouts == 0 || self.is_turn_of_fit
    }

    /// Brings the account up to date and decides whose turn it is.
    fn advance(&mut self, now: Instant) {
        let passed_s = now.saturating_duration_since(self.at).as_secs_f64();
        self.at = now;
        self.owed_s = if self.rollouts == 0 {
            // A fit that has the device for itself is paid what it is owed, and no debtor.
            (self.owed_s - passed_s).max(0.0)
        } else if self.is_turn_of_fit {
            self.owed_s - passed_s * (1.0 - self.fit_share)
        } else if self.fits_waiting > 0 {
            self.owed_s + passed_s * self.fit_share
        } else {
            self.owed_s
        };
        self.owed_s = self.owed_s.clamp(-MOST_S, MOST_S);
        self.is_turn_of_fit = self.rollouts > 0
            && if self.is_turn_of_fit { self.owed_s > 0.0 } else { self.owed_s >= TURN_S };
    }

    /// Time after which it is a fit's turn, if nothing changes.
    fn time_to_fit(&self) -> Duration {
        seconds((TURN_S - self.owed_s) / self.fit_share)
    }

    /// Time after which it is the rollouts' turn, if nothing changes.
    fn time_to_rollouts(&self) -> Duration {
        seconds(self.owed_s / (1.0 - self.fit_share))
    }
}

/// Converts a time, at least to a moment, so that a wait of it changes something.
fn seconds(time_s: f64) -> Duration {
    const LEAST: Duration = Duration::from_micros(50);
    Duration::try_from_secs_f64(time_s).unwrap_or(LOOK).max(LEAST)
}

#[cfg(test)]
mod tests;

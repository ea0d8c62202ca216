//! Turns at a device. Three rules decide which slice is next:
//!
//! - Fits have a least share of the time of a device with one queue while rollouts want all of it.
//!   Time that they are short of it is owed to them; otherwise rollouts go first. With two queues
//!   [`alternation`](super::alternation) sees to that.
//! - Accounts of one priority get equal parts of its time, regardless of the number and the sizes of
//!   their requests: next is the one that was served least. For its first slice an account goes
//!   ahead of those already served, so a small request runs between two slices of large ones.
//! - Requests of one account share its part in the same way.
//!
//! Turns decide when a slice runs, never what is in it: results do not depend on them.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use super::Priority;

/// Device time, about a slice, of the head start of a new request.
const HEAD_START: Duration = Duration::from_millis(30);
/// Most device time by which a request that was away may be behind the others: longer absences are
/// not made up for.
const MOST_BEHIND: Duration = Duration::from_millis(100);
/// Most device time that fits may be short of, and ahead by [s]: after a slice that could not be
/// cut, neither side should have the device for itself for long.
const MOST_OWED_S: f64 = 0.25;
const MOST_AHEAD_S: f64 = 1.0;

/// A request or a fit, as its slices queue for the device.
#[derive(Debug)]
pub(super) struct Flow {
    pub(super) priority: Priority,
    /// Account with whose other flows it shares its turns.
    account: Arc<Standing>,
    clock: Mutex<Clock>,
}

/// The turns of an account: those of all its flows together.
#[derive(Debug, Default)]
pub(super) struct Standing {
    clock: Mutex<Clock>,
    /// Mean clock of its flows.
    mean: Mutex<Mean>,
}

/// Device time that was served, from a start that is common to all rivals.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    at: Duration,
    served: Duration,
}

/// Mean clock of rivals, at which a new one starts.
#[derive(Clone, Copy, Debug)]
struct Mean(Duration);

impl Default for Mean {
    fn default() -> Self {
        Self(HEAD_START)
    }
}

impl Mean {
    /// The clock of one that joins the others.
    fn joined(self, clock: Clock) -> Clock {
        let behind = if clock.served.is_zero() { Duration::ZERO } else { MOST_BEHIND };
        Clock { at: clock.at.max(self.0.saturating_sub(behind)), ..clock }
    }

    /// Advances by the time that one of some rivals was served.
    fn advance(&mut self, took: Duration, rivals: usize) {
        self.0 = self.0.saturating_add(took / u32::try_from(rivals.max(1)).unwrap_or(u32::MAX));
    }
}

impl Clock {
    /// The order of turns, least first.
    fn rank(self) -> Duration {
        let is_new = self.served < HEAD_START;
        self.at.saturating_sub(if is_new { HEAD_START } else { Duration::ZERO })
    }

    fn advanced(self, took: Duration) -> Self {
        Self { at: self.at.saturating_add(took), served: self.served.saturating_add(took) }
    }
}

impl Flow {
    /// A flow with turns of an account that nothing else has.
    pub(super) fn new(priority: Priority) -> Arc<Self> {
        Self::of(priority, Arc::default())
    }

    /// A flow that shares the turns of an account.
    pub(super) fn of(priority: Priority, account: Arc<Standing>) -> Arc<Self> {
        Arc::new(Self { priority, account, clock: Mutex::default() })
    }

    /// The order of turns, least first: that of the account, then that among its flows.
    fn rank(&self) -> (Duration, Duration) {
        (get(&self.account.clock).rank(), get(&self.clock).rank())
    }
}

fn get<T: Copy>(value: &Mutex<T>) -> T {
    *value.lock().unwrap_or_else(PoisonError::into_inner)
}

fn change<T: Copy>(value: &Mutex<T>, to: impl FnOnce(T) -> T) {
    let mut value = value.lock().unwrap_or_else(PoisonError::into_inner);
    *value = to(*value);
}

/// Work that waits for its turn.
pub(super) struct Turns<T> {
    /// In order of arrival.
    waiting: Vec<(Arc<Flow>, T)>,
    /// Mean clock of the accounts of each priority.
    means: [Mean; 2],
    fit_share: f64,
    /// Device time that fits are short of their share [s]; negative if they are ahead.
    owed_s: f64,
    /// True if rollouts waited when a fit had the last turn.
    rollouts_waited: bool,
}

impl<T> Turns<T> {
    /// Fits get this share of the time, 0 to below 1, while they and rollouts have work.
    pub(super) fn new(fit_share: f64) -> Self {
        Self {
            waiting: Vec::new(),
            means: [Mean::default(); 2],
            fit_share,
            owed_s: 0.0,
            rollouts_waited: false,
        }
    }

    /// Adds work of a flow.
    pub(super) fn push(&mut self, flow: &Arc<Flow>, work: T) {
        change(&flow.account.clock, |clock| self.means[flow.priority as usize].joined(clock));
        change(&flow.clock, |clock| get(&flow.account.mean).joined(clock));
        self.waiting.push((Arc::clone(flow), work));
    }

    /// The next work.
    pub(super) fn take(&mut self) -> Option<(Arc<Flow>, T)> {
        let has = |priority| self.waiting.iter().any(|(f, _)| f.priority == priority);
        let rollouts_wait = has(Priority::Interactive);
        let fits_first = self.owed_s > 0.0 || !rollouts_wait;
        let turn = if has(Priority::Background) && fits_first {
            Priority::Background
        } else {
            Priority::Interactive
        };
        let candidates = self.waiting.iter().enumerate();
        let own = candidates.filter(|(_, (f, _))| f.priority == turn);
        // The first of equals: work of one flow keeps its order.
        let (index, _) = own.min_by_key(|(_, (flow, _))| flow.rank())?;
        self.rollouts_waited = rollouts_wait;
        Some(self.waiting.remove(index))
    }

    /// Notes the device time that work of a flow took.
    pub(super) fn served(&mut self, flow: &Arc<Flow>, took: Duration) {
        change(&flow.account.clock, |clock| clock.advanced(took));
        change(&flow.clock, |clock| clock.advanced(took));
        let rivals = || self.waiting.iter().map(|(f, _)| f).filter(|f| f.priority == flow.priority);
        let accounts = distinct(rivals().chain([flow]).map(|f| Arc::as_ptr(&f.account)));
        let own = rivals().filter(|f| Arc::ptr_eq(&f.account, &flow.account));
        let flows = distinct(own.chain([flow]).map(Arc::as_ptr));
        change(&flow.account.mean, |mut mean| {
            mean.advance(took, flows);
            mean
        });
        self.means[flow.priority as usize].advance(took, accounts);
        self.settle(flow.priority, took.as_secs_f64());
    }

    /// Shares are counted while both priorities have work; otherwise a lead is worked off. Between
    /// two slices a fit or a rollout is away for a moment: a fit that returns during a rollout's
    /// slice has waited for it, a slice of a fit that nothing waited for is no debt.
    fn settle(&mut self, served: Priority, took_s: f64) {
        let is_shared = match served {
            Priority::Interactive => {
                self.waiting.iter().any(|(f, _)| f.priority == Priority::Background)
            }
            Priority::Background => self.rollouts_waited,
        };
        let owed_s = match (served, is_shared) {
            (Priority::Interactive, true) => self.owed_s + took_s * self.fit_share,
            (Priority::Background, true) => self.owed_s - took_s * (1.0 - self.fit_share),
            (Priority::Interactive, false) => (self.owed_s + took_s).min(self.owed_s.max(0.0)),
            (Priority::Background, false) => (self.owed_s - took_s).max(self.owed_s.min(0.0)),
        };
        self.owed_s = owed_s.clamp(-MOST_AHEAD_S, MOST_OWED_S);
    }

    /// Everything that waits.
    pub(super) fn drain(&mut self) -> Vec<(Arc<Flow>, T)> {
        std::mem::take(&mut self.waiting)
    }
}

/// Number of different pointers.
fn distinct<T>(pointers: impl Iterator<Item = *const T>) -> usize {
    let mut pointers: Vec<_> = pointers.collect();
    pointers.sort_unstable();
    pointers.dedup();
    pointers.len()
}

#[cfg(test)]
mod tests;

//! The line of rollouts in front of a worker. A rollout is small, medium or large by the time that
//! the worker should need for it. Slots are kept for small ones, few large ones are under way at a
//! time, and within a size the owners take turns, and the clients of each: a small rollout never
//! waits for a large one, and no owner's rollout for all of another owner's.

mod order;
mod rate;
mod size;

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use tokio::sync::oneshot;

use crate::context::Context;

pub(crate) use self::size::Size;
use self::{order::Order, rate::Rate};
use size::Bounds;

/// Least and most that a client is asked to wait before another attempt.
const RETRY_AFTER: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(600)];
/// The share of a worker's time that its fit is assumed to take.
const FIT_SHARE: f64 = 0.25;
/// Starts after which the next rollout of a size that has none under way goes first, where there is
/// only one slot.
const MOST_PASSED: u64 = 4;

/// A rollout, as the line sees it.
#[derive(Clone, Debug)]
pub(super) struct Ask {
    /// The owner of the key that it was sent with.
    pub(super) owner: Arc<str>,
    /// The client that sent it.
    pub(super) client: Arc<str>,
    /// Work of the rollout, in element substeps.
    pub(super) work: f64,
}

impl Ask {
    /// A rollout of the caller of the current request.
    pub(super) fn of_caller(work: f64) -> Self {
        let Context { client, caller, .. } = Context::current();
        Self { owner: caller.owner, client, work }
    }
}

/// A line that has no place left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Full {
    /// Time after which another attempt makes sense.
    pub(super) retry_after: Duration,
}

/// The line of one worker. Clones share it.
#[derive(Clone, Debug)]
pub(super) struct Line(Arc<Mutex<State>>);

#[derive(Debug)]
struct State {
    bounds: Bounds,
    /// Waiting rollouts by [`Size`].
    waiting: [Order; 3],
    running: HashMap<u64, ActiveRollout>,
    rate: Rate,
    has_fit: bool,
    next_id: u64,
    starts: u64,
    /// The start, counted from the first, at which a rollout of each size started last.
    last_start: [u64; 3],
}

#[derive(Clone, Debug)]
struct ActiveRollout {
    owner: Arc<str>,
    size: Size,
    work: f64,
}

/// A place in a line: waiting at first, then with a slot. Given back when it is dropped.
#[derive(Debug)]
pub(super) struct Place {
    line: Line,
    id: u64,
    work: f64,
    turn: Option<oneshot::Receiver<()>>,
}

impl Place {
    /// Waits for a slot.
    pub(super) async fn turn(&mut self) {
        if let Some(turn) = self.turn.take() {
            // The sender is kept until it has sent.
            let _ = turn.await;
        }
    }

    /// Notes that the worker computed this rollout in `seconds`.
    pub(super) fn computed(&self, seconds: f64) {
        self.line.lock().rate.measured(self.work, seconds);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut state = self.line.lock();
        if state.running.remove(&self.id).is_none() {
            state.waiting.iter_mut().for_each(|order| order.remove(self.id));
        }
        state.advance();
    }
}

impl Line {
    /// A line with the given numbers of slots and of places to wait.
    pub(super) fn new(slots: usize, places: usize) -> Self {
        Self(Arc::new(Mutex::new(State {
            bounds: Bounds { slots: slots.max(1), places },
            waiting: Default::default(),
            running: HashMap::new(),
            rate: Rate::default(),
            has_fit: false,
            next_id: 0,
            starts: 0,
            last_start: [0; 3],
        })))
    }

    /// Joins the line.
    ///
    /// # Errors
    /// [`Full`].
    pub(super) fn join(&self, ask: &Ask) -> Result<Place, Full> {
        let mut state = self.lock();
        let size = state.size(ask);
        if !state.has_room(size, ask) {
            return Err(Full { retry_after: state.retry_after(size) });
        }
        let id = state.next_id;
        state.next_id += 1;
        let (wake, turn) = oneshot::channel();
        let waiting = order::Waiting { id, work: ask.work, wake };
        state.waiting[size as usize].push(&ask.owner, &ask.client, waiting);
        state.advance();
        Ok(Place { line: self.clone(), id, work: ask.work, turn: Some(turn) })
    }

    /// True if a rollout can join.
    pub(super) fn has_room(&self, ask: &Ask) -> bool {
        let state = self.lock();
        state.has_room(state.size(ask), ask)
    }

    /// Time after which another attempt makes sense, for a rollout that has no place now.
    pub(super) fn retry_after(&self, ask: &Ask) -> Duration {
        let state = self.lock();
        state.retry_after(state.size(ask))
    }

    /// Time in which the worker should have done all that is under way or waits [s].
    pub(super) fn ahead_s(&self) -> f64 {
        let state = self.lock();
        state.work_up_to(Size::Large) / state.rate.per_second()
    }

    /// Speed of the worker [element substeps / s].
    pub(super) fn per_second(&self) -> f64 {
        self.lock().rate.per_second()
    }

    /// Rollouts that are under way or wait.
    pub(super) fn len(&self) -> usize {
        let state = self.lock();
        state.running.len() + state.waiting.iter().map(Order::len).sum::<usize>()
    }

    /// Rollouts that wait, by [`Size`].
    pub(super) fn waiting(&self) -> [usize; 3] {
        let state = self.lock();
        [0, 1, 2].map(|size| state.waiting[size].len())
    }

    /// Notes if the worker is at a fit, which takes its share.
    pub(super) fn set_fit(&self, has_fit: bool) {
        self.lock().has_fit = has_fit;
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn size(&self, ask: &Ask) -> Size {
        Size::of(ask.work / self.rate.per_second())
    }

    fn running_of(&self, size: Size) -> usize {
        self.running.values().filter(|r| r.size == size).count()
    }

    /// True if a slot is free that this size of an owner may take.
    fn has_slot(&self, size: Size, owner: &str) -> bool {
        let under_way = Size::ALL.map(|s| self.running_of(s));
        let own = |s| self.running.values().filter(|r| r.size == s && *r.owner == *owner).count();
        self.bounds.has_slot(size, under_way, Size::ALL.map(own))
    }

    fn has_room(&self, size: Size, ask: &Ask) -> bool {
        let waiting = Size::ALL.map(|s| self.waiting[s as usize].len());
        let line = &self.waiting[size as usize];
        let own = (line.of_owner(&ask.owner), line.of_client(&ask.owner, &ask.client));
        self.has_slot(size, &ask.owner) || self.bounds.has_place(size, waiting, own)
    }

    /// Starts what may start.
    fn advance(&mut self) {
        while let Some(size) = self.next_size() {
            let mut line = std::mem::take(&mut self.waiting[size as usize]);
            let next = line.pop(|owner| self.has_slot(size, owner));
            self.waiting[size as usize] = line;
            let Some((owner, next)) = next else { return };
            self.running.insert(next.id, ActiveRollout { owner, size, work: next.work });
            self.starts += 1;
            self.last_start[size as usize] = self.starts;
            // A caller that has gone gives the place back.
            let _ = next.wake.send(());
        }
    }

    /// The size whose turn it is: small ones first, but one slot at least goes to each larger size.
    fn next_size(&self) -> Option<Size> {
        let may_start = |size: &Size| {
            self.waiting[*size as usize].has_ready(|owner| self.has_slot(*size, owner))
        };
        let passed_over = |size: &Size| {
            *size != Size::Small
                && self.running_of(*size) == 0
                && (self.bounds.slots > 1
                    || self.starts - self.last_start[*size as usize] >= MOST_PASSED)
        };
        let ready = || Size::ALL.into_iter().filter(may_start);
        let longest_ago = ready().filter(passed_over).min_by_key(|s| self.last_start[*s as usize]);
        longest_ago.or_else(|| ready().next())
    }

    /// Work of this size and smaller that is under way or waits.
    fn work_up_to(&self, size: Size) -> f64 {
        let running = self.running.values().filter(|r| r.size <= size).map(|r| r.work);
        let waiting = Size::ALL.into_iter().filter(|s| *s <= size);
        running.sum::<f64>() + waiting.map(|s| self.waiting[s as usize].work()).sum::<f64>()
    }

    /// The time until what is ahead of a rollout of this size is done. Rollouts under way share the
    /// worker, and a fit has its part.
    fn retry_after(&self, size: Size) -> Duration {
        let under_way = self.running.len().max(1) as f64;
        let own = self.running.values().filter(|r| r.size <= size).count().max(1) as f64;
        let rate = self.rate.per_second() * if self.has_fit { 1.0 - FIT_SHARE } else { 1.0 };
        let shared = self.work_up_to(size) * (under_way / own).max(1.0);
        let seconds = shared.min(self.work_up_to(Size::Large)) / rate;
        let [least, most] = RETRY_AFTER;
        Duration::try_from_secs_f64(seconds).unwrap_or(most).clamp(least, most)
    }
}

#[cfg(test)]
mod tests;

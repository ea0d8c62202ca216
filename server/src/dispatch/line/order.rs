//! The order of the rollouts of one size that wait: deficit round robin over the owners, and over the
//! clients of each. In every round an owner may start as much work as every other, and so may a client
//! among those of its owner; an unused share is kept while it waits.

use std::{collections::VecDeque, sync::Arc};

use tokio::sync::oneshot;

/// A rollout that waits.
#[derive(Debug)]
pub(super) struct Waiting {
    pub(super) id: u64,
    pub(super) work: f64,
    /// Signalled at its turn.
    pub(super) wake: oneshot::Sender<()>,
}

/// The rollouts that wait, by owner and client.
#[derive(Debug, Default)]
pub(super) struct Order(Rounds<Rounds<VecDeque<Waiting>>>);

impl Order {
    pub(super) fn push(&mut self, owner: &Arc<str>, client: &Arc<str>, rollout: Waiting) {
        self.0.entry(owner).entry(client).push_back(rollout);
    }

    /// The next rollout of the owners that may start one, and its owner.
    pub(super) fn pop(&mut self, may_start: impl Fn(&str) -> bool) -> Option<(Arc<str>, Waiting)> {
        self.0.pop_of(may_start)
    }

    /// True if an owner waits that may start a rollout.
    pub(super) fn has_ready(&self, may_start: impl Fn(&str) -> bool) -> bool {
        self.0.0.iter().any(|owner| may_start(&owner.name))
    }

    /// Takes a rollout out.
    pub(super) fn remove(&mut self, id: u64) {
        self.0.remove(id);
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Rollouts of an owner.
    pub(super) fn of_owner(&self, owner: &str) -> usize {
        self.0.find(owner).map_or(0, Queue::len)
    }

    /// Rollouts of a client of an owner.
    pub(super) fn of_client(&self, owner: &str, client: &str) -> usize {
        self.0.find(owner).and_then(|clients| clients.find(client)).map_or(0, Queue::len)
    }

    /// Work of all of them, in element substeps.
    pub(super) fn work(&self) -> f64 {
        self.0.work()
    }
}

/// Rollouts in some order.
trait Queue: Default {
    /// Work of the rollout that [`Queue::pop`] would return; zero without one.
    fn next_work(&self) -> f64;
    fn pop(&mut self) -> Option<Waiting>;
    fn remove(&mut self, id: u64);
    fn len(&self) -> usize;
    fn is_empty(&self) -> bool;
    fn work(&self) -> f64;
}

/// In order of arrival.
impl Queue for VecDeque<Waiting> {
    fn next_work(&self) -> f64 {
        self.front().map_or(0.0, |rollout| rollout.work)
    }

    fn pop(&mut self) -> Option<Waiting> {
        self.pop_front()
    }

    fn remove(&mut self, id: u64) {
        self.retain(|rollout| rollout.id != id);
    }

    fn len(&self) -> usize {
        self.len()
    }

    fn is_empty(&self) -> bool {
        self.is_empty()
    }

    fn work(&self) -> f64 {
        self.iter().map(|rollout| rollout.work).sum()
    }
}

/// Deficit round robin over named queues, in the order of their turns.
#[derive(Debug)]
struct Rounds<Q>(VecDeque<Sharer<Q>>);

#[derive(Debug)]
struct Sharer<Q> {
    name: Arc<str>,
    /// Work that it may start in this round.
    credit: f64,
    /// Never empty, but right before a push.
    queue: Q,
}

impl<Q> Default for Rounds<Q> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<Q: Queue> Rounds<Q> {
    /// The queue of a name, to push to; made if missing.
    fn entry(&mut self, name: &Arc<str>) -> &mut Q {
        let index = self.0.iter().position(|s| s.name == *name).unwrap_or_else(|| {
            self.0.push_back(Sharer { name: name.clone(), credit: 0.0, queue: Q::default() });
            self.0.len() - 1
        });
        &mut self.0[index].queue
    }

    fn find(&self, name: &str) -> Option<&Q> {
        self.0.iter().find(|s| *s.name == *name).map(|s| &s.queue)
    }

    /// The next rollout of the sharers that may start one.
    fn pop_of(&mut self, may_start: impl Fn(&str) -> bool) -> Option<(Arc<str>, Waiting)> {
        let ready = self.0.iter().filter(|s| may_start(&s.name));
        let share = ready.map(|s| s.queue.next_work()).fold(0.0, f64::max);
        // After one round everyone has enough for a start.
        for _ in 0..2 * self.0.len() {
            let sharer = self.0.front_mut()?;
            if may_start(&sharer.name) {
                if sharer.queue.next_work() <= sharer.credit {
                    let next = sharer.queue.pop()?;
                    sharer.credit -= next.work;
                    let name = sharer.name.clone();
                    if sharer.queue.is_empty() {
                        self.0.pop_front();
                    }
                    return Some((name, next));
                }
                sharer.credit += share;
            }
            self.0.rotate_left(1);
        }
        None
    }
}

impl<Q: Queue> Queue for Rounds<Q> {
    fn next_work(&self) -> f64 {
        let share = self.0.iter().map(|s| s.queue.next_work()).fold(0.0, f64::max);
        let credits =
            [0.0, share].into_iter().flat_map(|more| self.0.iter().map(move |s| (s, more)));
        let affordable = |(sharer, more): (&Sharer<Q>, f64)| {
            let work = sharer.queue.next_work();
            (work <= sharer.credit + more).then_some(work)
        };
        credits.filter_map(affordable).next().unwrap_or_default()
    }

    fn pop(&mut self) -> Option<Waiting> {
        self.pop_of(|_| true).map(|(_, next)| next)
    }

    fn remove(&mut self, id: u64) {
        self.0.iter_mut().for_each(|s| s.queue.remove(id));
        self.0.retain(|s| !s.queue.is_empty());
    }

    fn len(&self) -> usize {
        self.0.iter().map(|s| s.queue.len()).sum()
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn work(&self) -> f64 {
        self.0.iter().map(|s| s.queue.work()).sum()
    }
}

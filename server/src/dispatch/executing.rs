//! The calls that a worker has taken and not answered. If the worker ends meanwhile, they are as
//! likely the cause as the job that it was at.

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

/// The calls at one worker. Clones share it.
#[derive(Clone, Debug, Default)]
pub(super) struct Executing {
    under_way: Arc<AtomicUsize>,
    /// True if one was cut off, and the worker has not said since that it is at none.
    cut_off: Arc<AtomicBool>,
}

/// A call that was sent to the worker; cut off if it is dropped without an answer.
#[derive(Debug)]
pub(super) struct SentCall {
    executing: Executing,
    answered: bool,
}

impl Executing {
    /// Counts a call that is about to be sent.
    pub(super) fn send(&self) -> SentCall {
        self.under_way.fetch_add(1, Ordering::SeqCst);
        SentCall { executing: self.clone(), answered: false }
    }

    /// The worker is alive, and says how many calls it is at.
    pub(super) fn is_alive(&self, in_flight: u32) {
        if in_flight == 0 {
            self.cut_off.store(false, Ordering::SeqCst);
        }
    }

    /// True if the worker was at a call when it was last heard of.
    pub(super) fn was_under_way(&self) -> bool {
        self.under_way.load(Ordering::SeqCst) > 0 || self.cut_off.load(Ordering::SeqCst)
    }
}

impl SentCall {
    /// The worker has answered, or never took it.
    pub(super) fn answered(&mut self) {
        self.answered = true;
    }
}

impl Drop for SentCall {
    fn drop(&mut self) {
        if !self.answered {
            self.executing.cut_off.store(true, Ordering::SeqCst);
        }
        self.executing.under_way.fetch_sub(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_cut_off_counts_until_the_worker_is_at_none() {
        let executing = Executing::default();
        assert!(!executing.was_under_way());
        let mut answered = executing.send();
        assert!(executing.was_under_way());
        answered.answered();
        drop(answered);
        assert!(!executing.was_under_way());
        drop(executing.send());
        assert!(executing.was_under_way());
        executing.is_alive(1);
        assert!(executing.was_under_way());
        executing.is_alive(0);
        assert!(!executing.was_under_way());
    }
}

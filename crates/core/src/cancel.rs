//! Cancellation of long work, and pauses in it.

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

/// Flag that stops long work early; checked between its units, a simulated frame for instance.
/// Clones share the flag.
#[derive(Clone, Default)]
pub struct CancelToken {
    flag: Arc<AtomicBool>,
    pause: Option<Arc<dyn Pause>>,
}

/// Reason for which long work waits between two of its units, because other work goes first.
pub trait Pause: Send + Sync {
    /// Returns once the work may go on, or within a second of `is_cancelled` being `true`.
    fn pass(&self, is_cancelled: &dyn Fn() -> bool);
}

impl CancelToken {
    /// The same flag; whoever checks this token or a clone of it waits there for as long as `pause`
    /// says.
    #[must_use]
    pub fn with_pause(&self, pause: Arc<dyn Pause>) -> Self {
        Self { flag: Arc::clone(&self.flag), pause: Some(pause) }
    }

    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// `true` once [`Self::cancel`] was called on this token or a clone of it. The work that asks
    /// may be held here for a while, by [`Self::with_pause`].
    pub fn is_cancelled(&self) -> bool {
        if let Some(pause) = &self.pause {
            pause.pass(&|| self.flag.load(Ordering::Relaxed));
        }
        self.flag.load(Ordering::Relaxed)
    }
}

impl fmt::Debug for CancelToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("CancelToken");
        shown.field("flag", &self.flag).field("has_pause", &self.pause.is_some()).finish()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[derive(Default)]
    struct Counted(AtomicUsize);

    impl Pause for Counted {
        fn pass(&self, _: &dyn Fn() -> bool) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn a_token_with_a_pause_shares_the_flag_and_passes_the_pause_at_each_check() {
        let (plain, counted) = (CancelToken::default(), Arc::new(Counted::default()));
        let pausing = plain.with_pause(counted.clone());
        assert!(!pausing.is_cancelled() && !plain.is_cancelled());
        plain.cancel();
        assert!(pausing.is_cancelled());
        assert_eq!(counted.0.load(Ordering::Relaxed), 2);
    }
}

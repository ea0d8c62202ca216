//! Cancellation of long work, and pauses in it.

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

/// Flag that stops long work early; checked between its units, a simulated frame for instance.
/// Clones share the flag.
#[derive(Clone, Default)]
pub struct CancelToken {
    flag: Arc<AtomicBool>,
    pause: Option<Arc<dyn Pause>>,
    until: Option<Instant>,
}

/// Reason for which long work waits between two of its units, because other work goes first.
pub trait Pause: Send + Sync {
    /// Blocks until work may resume; returns within a second of `is_cancelled` becoming `true`.
    fn pass(&self, is_cancelled: &dyn Fn() -> bool);
}

impl CancelToken {
    /// The same flag, with a pause: callers that check this token or a clone of it block for as
    /// long as `pause` requires.
    #[must_use]
    pub fn with_pause(&self, pause: Arc<dyn Pause>) -> Self {
        Self { pause: Some(pause), ..self.clone() }
    }

    /// The same flag, which this token and its clones also report as set from the given time on.
    #[must_use]
    pub fn until(&self, time: Instant) -> Self {
        Self { until: Some(time), ..self.clone() }
    }

    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// `true` once the time of [`Self::until`] is over.
    pub fn is_late(&self) -> bool {
        self.until.is_some_and(|time| Instant::now() >= time)
    }

    /// `true` once [`Self::cancel`] was called on this token or a clone of it, or its time is over. The work that asks
    /// may be held here for a while, by [`Self::with_pause`].
    pub fn is_cancelled(&self) -> bool {
        if let Some(pause) = &self.pause {
            pause.pass(&|| self.flag.load(Ordering::Relaxed));
        }
        self.flag.load(Ordering::Relaxed) || self.is_late()
    }
}

impl fmt::Debug for CancelToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("CancelToken");
        shown.field("flag", &self.flag).field("has_pause", &self.pause.is_some());
        shown.field("until", &self.until).finish()
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
    fn a_token_with_a_time_is_cancelled_from_then_on_and_the_others_are_not() {
        let plain = CancelToken::default();
        let now = Instant::now();
        let late = plain.until(now);
        assert!(late.is_cancelled() && late.is_late());
        assert!(!plain.is_cancelled() && !plain.is_late());
        let later = plain.until(now + std::time::Duration::from_secs(3600));
        assert!(!later.is_cancelled());
        later.cancel();
        assert!(later.is_cancelled() && plain.is_cancelled());
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

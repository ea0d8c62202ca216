//! Time as a value, so that tests control it.

use std::{
    fmt,
    sync::{
        LazyLock,
        atomic::{AtomicI64, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use jiff::Timestamp;

/// The clocks of a store.
pub trait Clock: fmt::Debug + Send + Sync + 'static {
    /// The time of day, as rows have it. It may be set back or forward.
    fn now(&self) -> Timestamp;

    /// The time since some moment in the life of this process. It never goes back.
    fn monotonic(&self) -> Duration;

    /// True if a test moves these clocks: then they stand in for that of the database, too.
    fn is_simulated(&self) -> bool {
        false
    }
}

/// The operating system's clocks.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemClock;

impl Clock for SystemClock {
    fn now(&self) -> Timestamp {
        Timestamp::now()
    }

    fn monotonic(&self) -> Duration {
        static START: LazyLock<Instant> = LazyLock::new(Instant::now);
        START.elapsed()
    }
}

/// A clock that moves only on request.
#[derive(Debug, Default)]
pub struct ManualClock {
    micros: AtomicI64,
    monotonic_micros: AtomicU64,
}

impl ManualClock {
    /// Lets time pass.
    pub fn advance(&self, by: Duration) {
        let micros = i64::try_from(by.as_micros()).unwrap_or(i64::MAX);
        self.set(micros);
        self.monotonic_micros.fetch_add(micros.unsigned_abs(), Ordering::SeqCst);
    }

    /// Sets the time of day forward, or back if negative; no time passes [us].
    pub fn set(&self, by_micros: i64) {
        self.micros.fetch_add(by_micros, Ordering::SeqCst);
    }
}

impl Clock for ManualClock {
    fn now(&self) -> Timestamp {
        from_micros(self.micros.load(Ordering::SeqCst))
    }

    fn monotonic(&self) -> Duration {
        Duration::from_micros(self.monotonic_micros.load(Ordering::SeqCst))
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// The time as stored: microseconds since the Unix epoch.
pub(crate) fn micros(time: Timestamp) -> i64 {
    time.as_microsecond()
}

/// The stored time, clamped to what can be represented.
pub(crate) fn from_micros(micros: i64) -> Timestamp {
    Timestamp::from_microsecond(micros).unwrap_or(if micros < 0 {
        Timestamp::MIN
    } else {
        Timestamp::MAX
    })
}

/// `time + span`, stored form, without overflow.
pub(crate) fn micros_after(time: Timestamp, span: Duration) -> i64 {
    micros(time).saturating_add(i64::try_from(span.as_micros()).unwrap_or(i64::MAX))
}

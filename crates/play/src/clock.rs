//! The time of a play: a frame of the twin for each frame of real time, over the speed. A frame may
//! begin up to half a frame early if there is input for it, so that a hand is followed immediately;
//! the mean rate stays. Frames that cannot be made up for are skipped and counted.

use std::time::Duration;

use tokio::time::Instant;

/// Frames by which a play may be late before it gives them up.
const LATEST: u32 = 2;
/// Gap between inputs, in frames, up to which they are a stream, and gaps that one waits for the next.
const STREAM: f64 = 0.6;
const PATIENCE: f64 = 1.25;
/// Bounds of the speed.
pub(super) const SPEEDS: std::ops::RangeInclusive<f64> = 0.05..=4.0;

/// The time of a play.
#[derive(Debug)]
pub(super) struct Clock {
    frame: Duration,
    speed: f64,
    /// Time at which the next frame is due.
    due: Instant,
    skipped: u64,
    /// The last input, and one that no frame has yet.
    last: Option<Instant>,
    waiting: Option<Arrival>,
}

/// An input and the time since the one before.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    at: Instant,
    gap: Duration,
}

impl Clock {
    pub(super) fn new(frame_s: f64, now: Instant) -> Self {
        let frame = Duration::from_secs_f64(frame_s.clamp(0.001, 10.0));
        Self { frame, speed: 1.0, due: now, skipped: 0, last: None, waiting: None }
    }

    /// Time at which the next frame begins.
    pub(super) fn begins(&self) -> Instant {
        let Some(Arrival { at, gap }) = self.waiting else { return self.due };
        let interval = self.interval();
        let earliest = self.due.checked_sub(interval / 2).unwrap_or(self.due);
        let is_stream = gap <= interval.mul_f64(STREAM);
        if at >= earliest || !is_stream {
            return earliest;
        }
        // The next of a stream of inputs is about to come: with it the frame is newer.
        (at + gap.mul_f64(PATIENCE)).clamp(earliest, self.due)
    }

    /// Input has arrived.
    pub(super) fn input(&mut self, now: Instant) {
        let gap = self.last.map_or(Duration::MAX, |last| now.saturating_duration_since(last));
        (self.last, self.waiting) = (Some(now), Some(Arrival { at: now, gap }));
    }

    /// A frame with all input begins.
    pub(super) fn begun(&mut self) {
        self.waiting = None;
    }

    /// A frame has ended.
    pub(super) fn stepped(&mut self, now: Instant) {
        let interval = self.interval();
        self.due += interval;
        let late = now.saturating_duration_since(self.due);
        if late > interval * LATEST {
            self.skipped += (late.as_secs_f64() / interval.as_secs_f64()) as u64;
            self.due = now;
        }
    }

    /// Restarts from now, as after a pause.
    pub(super) fn restart(&mut self, now: Instant) {
        self.due = now;
    }

    pub(super) fn set_speed(&mut self, speed: f64) {
        self.speed = speed.clamp(*SPEEDS.start(), *SPEEDS.end());
    }

    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Frames that were given up since the start.
    pub(super) fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Frames that are due and not simulated yet.
    pub(super) fn behind(&self, now: Instant) -> f64 {
        now.saturating_duration_since(self.due).as_secs_f64() / self.interval().as_secs_f64()
    }

    fn interval(&self) -> Duration {
        self.frame.div_f64(self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn input_begins_a_frame_early_and_the_mean_rate_stays() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let mut clock = Clock::new(0.1, start);
        assert_eq!(clock.begins(), start);
        clock.stepped(at(5));
        assert_eq!(clock.begins(), at(100));
        clock.input(at(30));
        assert_eq!(clock.begins(), at(50));
        clock.begun();
        // Half a frame early, and still due at its own time afterwards.
        clock.stepped(at(52));
        assert_eq!(clock.begins(), at(200));
        clock.set_speed(0.5);
        clock.stepped(at(200));
        assert_eq!((clock.begins(), clock.skipped()), (at(400), 0));
    }

    #[test]
    fn frames_wait_a_little_for_the_next_of_a_stream_of_inputs() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let mut clock = Clock::new(0.1, start);
        clock.stepped(at(1));
        clock.input(at(0));
        clock.input(at(40));
        // An input arrives at about 80, and takes this one along.
        assert_eq!(clock.begins(), at(90));
        clock.input(at(80));
        assert!(clock.begins() <= at(80));
        clock.begun();
        clock.stepped(at(85));
        // If none comes it begins in time all the same.
        clock.input(at(100));
        clock.input(at(149));
        assert_eq!(clock.begins(), at(200));
    }

    #[test]
    fn what_is_too_late_is_skipped_and_counted() {
        let start = Instant::now();
        let mut clock = Clock::new(0.1, start);
        clock.stepped(start + Duration::from_millis(250));
        assert_eq!(clock.skipped(), 0, "that can be made up for");
        let late = start + Duration::from_millis(1050);
        assert!((clock.behind(late) - 9.5).abs() < 1e-6);
        clock.stepped(late);
        assert_eq!((clock.skipped(), clock.begins()), (8, late));
    }
}

//! Waiting between attempts: doubling from 0.2 s to 5 s, spread so that many
//! workers do not return to a restarted server in the same instant.

use std::time::Duration;

const FIRST_WAIT: Duration = Duration::from_millis(200);
const LONGEST_WAIT: Duration = Duration::from_secs(5);

/// The waits between attempts of one call.
#[derive(Debug, Default)]
pub(crate) struct Backoff {
    attempts: u32,
}

impl Backoff {
    /// Waits before the next attempt.
    pub(crate) async fn wait(&mut self) {
        tokio::time::sleep(self.next()).await;
    }

    /// The length of the next wait.
    fn next(&mut self) -> Duration {
        let full = FIRST_WAIT.saturating_mul(1 << self.attempts.min(10)).min(LONGEST_WAIT);
        self.attempts = self.attempts.saturating_add(1);
        // The random bits of a fresh UUID spare this crate a generator.
        let share = f64::from(uuid::Uuid::new_v4().as_fields().0) / f64::from(u32::MAX);
        full.mul_f64(0.5 + 0.5 * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_grow_and_stay_bounded() {
        let mut backoff = Backoff::default();
        let waits: Vec<_> = (0..40).map(|_| backoff.next()).collect();
        assert!(waits[0] <= FIRST_WAIT);
        assert!(waits.iter().all(|w| *w >= FIRST_WAIT / 2 && *w <= LONGEST_WAIT));
        assert!(waits[39] >= LONGEST_WAIT / 2);
    }
}

//! A batch that idle workers share, beside the same that one of them answers: in turns, so that both
//! see the same machine.

use std::time::{Duration, Instant};

use bendtwin_client::Client;
use bendtwin_terminal::measurement::Size;
use serde::Serialize;

use super::{Still, percentile};

/// Fewest runs of either.
const LEAST_RUNS: usize = 3;

/// Times of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Spread {
    size: Size,
    /// Workers of the server.
    workers: usize,
    /// Runs of either.
    runs: usize,
    /// Median of those that one worker answered, and of those that all could share [s].
    one_s: f64,
    shared_s: f64,
}

impl Spread {
    /// Runs both in turns for so long.
    pub(super) async fn measure(
        client: &Client,
        still: &Still,
        size: Size,
        time: Duration,
    ) -> anyhow::Result<Self> {
        let workers = client.workers().all().await?.len();
        // A batch that is refused for what one instance does stays whole; nothing is, here.
        let whole = || still.rollout(size).refuse_implausible().allow_any_motion();
        // Every worker loads the twin before the clock runs.
        for _ in 0..=workers {
            client.rollouts().run(still.rollout(size)).await?;
        }
        let started = Instant::now();
        let (mut one, mut shared) = (Vec::new(), Vec::new());
        while one.len() < LEAST_RUNS || started.elapsed() < time {
            for (rollout, took) in [(whole(), &mut one), (still.rollout(size), &mut shared)] {
                let begun = Instant::now();
                client.rollouts().run(rollout).await?;
                took.push(begun.elapsed().as_secs_f64());
            }
        }
        one.sort_by(f64::total_cmp);
        shared.sort_by(f64::total_cmp);
        let (one_s, shared_s) = (percentile(&one, 0.5), percentile(&shared, 0.5));
        Ok(Self { size, workers, runs: one.len(), one_s, shared_s })
    }

    /// A line of the report.
    pub(super) fn text(&self) -> String {
        let Self { size, workers, runs, one_s, shared_s } = self;
        format!(
            "\na batch of {size}, median of {runs}: {:.0} ms at one worker, {:.0} ms shared by {workers} ({:.2} x as fast)",
            1e3 * one_s,
            1e3 * shared_s,
            one_s / shared_s
        )
    }
}

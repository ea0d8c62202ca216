//! Renews a job's lease, reports progress and losses, and learns of cancellation and that the job is to
//! make way, in a separate task and often enough that a cancelled job ends within a second.

use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_core::{ModelLoss, Preview, Progress};
use tokio::{task::JoinHandle, time::MissedTickBehavior};
use tracing::Instrument as _;

use super::{
    LeasedJob,
    stages::StageSpans,
    stop::{Reason, Stop},
};
use crate::server_client::CallError;

/// Time between two reports. A lease lasts tens of seconds, so several may be missed.
const REPORT_INTERVAL: Duration = Duration::from_millis(500);
/// Longest time for the last losses of a fit.
const FLUSH_TIMEOUT: Duration = Duration::from_secs(5);

/// Most losses of one report.
const MOST_LOSSES: usize = 1024;
/// Losses that wait for a server that cannot be reached, before every second iteration is dropped.
const MOST_WAITING: usize = 16 * MOST_LOSSES;

/// The latest progress and the losses since the last report, set by the work and read by the
/// reporting task.
#[derive(Clone, Default)]
pub(crate) struct LatestProgress(Arc<Mutex<PendingReport>>);

#[derive(Default)]
struct PendingReport {
    progress: Option<Progress>,
    /// In the order in which they were computed.
    losses: Vec<ModelLoss>,
    /// The newest preview that was not reported yet.
    preview: Option<Arc<Preview>>,
    /// Iterations that are no multiples of this have been dropped.
    stride: u32,
    stages: StageSpans,
}

/// The content of a report.
#[derive(Clone, Debug, Default)]
pub(crate) struct News {
    pub(crate) progress: Option<Progress>,
    pub(crate) losses: Vec<ModelLoss>,
    pub(crate) preview: Option<Arc<Preview>>,
}

impl LatestProgress {
    /// Takes over progress, which names the last loss of every model that is fitted side by side.
    pub(crate) fn set(&self, mut progress: Progress) {
        let mut waiting = self.lock();
        waiting.stages.follow(&progress);
        if let Some(loss) = progress.model_loss() {
            let before = waiting.progress.take().map(|p| p.models).unwrap_or_default();
            progress.models = beside(before, &loss);
            waiting.losses.push(loss);
            waiting.thin_out();
        }
        if let Some(preview) = progress.preview.take() {
            waiting.preview = Some(preview);
        }
        waiting.progress = Some(progress);
    }

    /// Progress, losses and preview to report.
    fn news(&self) -> News {
        let waiting = self.lock();
        let losses = waiting.losses.iter().take(MOST_LOSSES).cloned().collect();
        News { progress: waiting.progress.clone(), losses, preview: waiting.preview.clone() }
    }

    /// Drops what has been reported: losses, which were the first, and the preview. Where others are
    /// the first losses by now, they are reported twice, which is safe.
    fn acknowledge(&self, reported: &News) {
        let mut waiting = self.lock();
        let losses = waiting.losses.iter().zip(&reported.losses);
        let same = losses.take_while(|(a, b)| a == b).count();
        waiting.losses.drain(..same);
        waiting
            .preview
            .take_if(|own| reported.preview.as_ref().is_some_and(|p| Arc::ptr_eq(p, own)));
    }

    fn lock(&self) -> MutexGuard<'_, PendingReport> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PendingReport {
    fn thin_out(&mut self) {
        while self.losses.len() > MOST_WAITING {
            self.stride = self.stride.max(1).saturating_mul(2);
            let before = self.losses.len();
            self.losses.retain(|loss| loss.iteration % self.stride == 0);
            if self.losses.len() == before {
                // Many models, all at multiples.
                self.losses.drain(..before / 2);
            }
        }
    }
}

/// The last losses of models with one more. Those of another stage are over.
fn beside(mut models: Vec<ModelLoss>, loss: &ModelLoss) -> Vec<ModelLoss> {
    models.retain(|model| model.stage == loss.stage);
    match models.iter_mut().find(|model| model.variant == loss.variant) {
        Some(model) => model.clone_from(loss),
        None => models.push(loss.clone()),
    }
    // A start that was not chosen makes no more passes.
    let last = loss.iteration;
    models.retain(|model| last.saturating_sub(model.iteration) <= 1);
    models
}

/// Reports the losses that still wait, so that they are kept with the fit that ends.
pub(crate) async fn flush(job: &LeasedJob, latest: &LatestProgress) {
    let reports = async {
        loop {
            let news = latest.news();
            if news.losses.is_empty() || job.report(&news).await.is_err() {
                return;
            }
            latest.acknowledge(&news);
        }
    };
    // They are worth no wait for a server that cannot be reached.
    let _ = tokio::time::timeout(FLUSH_TIMEOUT, reports).await;
}

/// Starts reporting, which continues until the task is aborted.
pub(super) fn start(job: LeasedJob, stop: Stop) -> (LatestProgress, JoinHandle<()>) {
    let latest = LatestProgress::default();
    let task = tokio::spawn(run(job, stop, latest.clone()).in_current_span());
    (latest, task)
}

async fn run(job: LeasedJob, stop: Stop, latest: LatestProgress) {
    let mut ticks = tokio::time::interval(REPORT_INTERVAL);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut reachable = true;
    loop {
        ticks.tick().await;
        let news = latest.news();
        match job.report(&news).await {
            Ok(answer) => {
                latest.acknowledge(&news);
                reachable = true;
                if answer.cancel_requested {
                    stop.stop(Reason::Cancelled);
                }
                match answer.make_way_within_s {
                    Some(left_s) if left_s > 0.0 => stop.make_way(true),
                    Some(_) => stop.stop(Reason::MakesWay),
                    None => stop.make_way(false),
                }
            }
            Err(CallError::Stale) => return stop.stop(Reason::Stale),
            // Deleted, or never known to this server: the result is not needed.
            Err(CallError::Refused(fault)) => {
                tracing::warn!(reason = fault.reason, "the server refuses this job: {fault}");
                return stop.stop(Reason::Stale);
            }
            Err(CallError::Unavailable(fault)) => {
                if std::mem::replace(&mut reachable, false) {
                    tracing::warn!("cannot report ({fault}); the work continues");
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;

//! A fit job from lease to twin: fetches the observation and computes in a separate thread.

mod compute;
mod twin;

use std::{path::PathBuf, time::Duration};

use bendtwin_core::{Category, Fault, FitSettings, Problem as _, Twin};
use bendtwin_fit::OpenRasteriser;
use bendtwin_proto::worker::v1::lease_job_request::Kind;
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;

use self::compute::{Compute, Finished, Inputs};
use crate::{
    Error, Limits,
    device::{Device, Priority},
    job::{
        Attempt, LeasedJob, deliver, report,
        stop::{Reason, Stop},
    },
    leasing::Execute,
    priority,
};

/// Executor of fit jobs.
#[derive(Clone)]
pub(crate) struct Fits {
    pub(crate) device: Device,
    /// Folder for observations while they are read.
    pub(crate) dir: PathBuf,
    pub(crate) limits: Limits,
    /// Opens the rasteriser that draws the views of a recording.
    pub(crate) rasteriser: OpenRasteriser,
    /// Time for which a result is kept while the server cannot be reached.
    pub(crate) delivery_timeout: Duration,
    /// Channel for errors after which the process must restart.
    pub(crate) fatal: mpsc::UnboundedSender<Error>,
}

/// Time that a stopped fit may still take before it is abandoned. Reading a capture does not check
/// for cancellation.
const CANCEL_GRACE: Duration = Duration::from_millis(500);

/// The outcome that the fit's thread will send.
type Thread = oneshot::Receiver<Outcome>;

/// Outcome of the work on a job.
enum Outcome {
    Finished(Box<Finished>),
    Failed(Fault),
    /// The fit panicked.
    Panicked(String),
}

impl Execute for Fits {
    const KIND: Kind = Kind::Fit;

    async fn execute(&self, job: LeasedJob, drain: &CancellationToken) {
        tracing::info!(resumed = job.has_checkpoint(), "fit leased");
        let mut attempt = Attempt::begin(job, drain, self.delivery_timeout);
        let (outcome, straggler) = match self.begin(&attempt).await {
            Err(fault) => (Outcome::Failed(fault), None),
            Ok(thread) => finish(thread, &attempt.stop).await,
        };
        // A fit that makes way does not compute them again.
        if matches!(attempt.stop.reason(), None | Some(Reason::MakesWay)) {
            report::flush(&attempt.job, &attempt.progress).await;
        }
        self.conclude(&mut attempt, outcome).await;
        // The lease is renewed until the end is written: only then may its renewal cease.
        drop(attempt);
        if let Some(straggler) = straggler {
            // Before the next job: two captures in memory may be one too many.
            tokio::select! {
                _ = straggler => {}
                () = drain.cancelled() => {}
            }
        }
    }
}

impl Fits {
    /// Fetches the inputs and starts the thread that computes.
    async fn begin(&self, attempt: &Attempt<'_>) -> Result<Thread, Fault> {
        let inputs = tokio::select! {
            fetched = self.fetch(&attempt.job) => fetched?,
            () = attempt.stop.stopped() => return Err(cancelled()),
        };
        let compute = Compute {
            progress: attempt.progress.clone(),
            checkpoints: attempt.checkpoints.clone(),
            stop: attempt.stop.clone(),
        };
        let (device, limits) = (self.device.clone(), self.limits);
        let rasteriser = self.rasteriser.clone();
        let fit = std::thread::Builder::new().name("fit".to_owned());
        let (done, result) = oneshot::channel();
        let spawned = fit.spawn(move || {
            priority::as_fit();
            let run = || compute.run(inputs, &device, rasteriser, &limits);
            let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
            let outcome = match caught {
                Ok(Ok(finished)) => Outcome::Finished(Box::new(finished)),
                Ok(Err(fault)) => Outcome::Failed(fault),
                Err(panic) => {
                    Outcome::Panicked(bendtwin_core::error::panic_text(&*panic).to_owned())
                }
            };
            let _ = done.send(outcome);
        });
        match spawned {
            Ok(_) => Ok(result),
            Err(e) => Err(Fault {
                category: Category::ResourceExhausted,
                reason: "NO_THREAD".to_owned(),
                message: format!("the worker cannot start a thread for the fit: {e}"),
            }),
        }
    }

    async fn fetch(&self, job: &LeasedJob) -> Result<Inputs, Fault> {
        let settings = settings_of(job.settings_json())?;
        let observation = job.fetch_observation(&self.dir).await.map_err(|e| e.fault())?;
        let checkpoint = job.fetch_checkpoint().await.map_err(|e| e.fault())?;
        let start = match &settings.start_from {
            Some(name) => Some(self.twin(job, name).await?),
            None => None,
        };
        let capture_name = job.capture_display_name().to_owned();
        Ok(Inputs { capture_name, settings, start, observation, checkpoint })
    }

    /// The twin that a fit begins with.
    async fn twin(&self, job: &LeasedJob, name: &str) -> Result<Twin, Fault> {
        let fetched = job.fetch_twin(name, self.limits.twin_bytes).await;
        let file = fetched.map_err(|e| e.fault())?;
        let read = tokio::task::spawn_blocking(move || Twin::decode(&file)).await;
        let read = read.map_err(|e| e.to_string()).and_then(|r| r.map_err(|e| e.to_string()));
        read.map_err(|why| bendtwin_fit::Error::Twin(why).fault())
    }

    /// True if the fit failed because a rollout had broken the device.
    fn met_a_broken_device(&self, fault: &Fault) -> bool {
        fault.reason == "DEVICE_FAILED" && self.device.broken_by() == Some(Priority::Interactive)
    }

    /// Reports the outcome to the server.
    async fn conclude(&self, attempt: &mut Attempt<'_>, outcome: Outcome) {
        if attempt.stop.reason() == Some(Reason::Stale) {
            tracing::warn!(
                "the lease is stale: the server has ended the attempt, or another worker has the job"
            );
            return;
        }
        match (outcome, attempt.stop.reason()) {
            (Outcome::Finished(finished), _) => {
                attempt.drop_checkpoint();
                twin::deliver(attempt, *finished).await;
            }
            (Outcome::Failed(fault), None) if self.met_a_broken_device(&fault) => {
                tracing::warn!("a rollout broke the device: the fit is handed back");
                attempt.save_last_checkpoint().await;
                attempt.fail(fault, deliver::Failure::Interrupted).await;
            }
            (Outcome::Failed(fault), _) => attempt.fail_unfinished("fit", fault).await,
            (Outcome::Panicked(text), _) => {
                attempt.save_last_checkpoint().await;
                tracing::error!("fit panicked: {text}");
                let fault = Fault {
                    category: Category::Internal,
                    reason: "WORKER_PANICKED".to_owned(),
                    message: "the fit failed for a reason inside the worker, which restarts; \
                              its log has the details"
                        .to_owned(),
                };
                attempt.fail(fault, deliver::Failure::Passing).await;
                let _ = self.fatal.send(Error::Panicked(text));
            }
        }
    }
}

/// Waits for the thread's outcome. If the job is stopped, the wait is short, and a thread that
/// still runs is returned, too.
async fn finish(mut thread: Thread, stop: &Stop) -> (Outcome, Option<Thread>) {
    let abandoned = async {
        stop.stopped().await;
        match stop.reason() {
            // A job that is handed back is worth its last checkpoint.
            Some(Reason::Drained) => std::future::pending().await,
            _ => tokio::time::sleep(CANCEL_GRACE).await,
        }
    };
    tokio::select! {
        biased;
        outcome = &mut thread => {
            let vanished = |_| Outcome::Panicked("the fit's thread ended".to_owned());
            (outcome.unwrap_or_else(vanished), None)
        }
        () = abandoned => (Outcome::Failed(cancelled()), Some(thread)),
    }
}

fn settings_of(json: &str) -> Result<FitSettings, Fault> {
    let invalid = |message: String| Fault {
        category: Category::InvalidArgument,
        reason: "INVALID_SETTINGS".to_owned(),
        message,
    };
    let settings: FitSettings = match json.trim() {
        "" => FitSettings::default(),
        json => serde_json::from_str(json).map_err(|e| invalid(format!("settings: {e}")))?,
    };
    settings.validate().map_err(|faults| invalid(format!("settings: {}", faults.join("; "))))?;
    Ok(settings)
}

fn cancelled() -> Fault {
    bendtwin_engine::Error::Cancelled.fault()
}

#[cfg(test)]
mod tests;

//! A fit job from lease to twin: fetches the observation and computes in a separate thread.

mod compute;
mod twin;

use std::{path::PathBuf, time::Duration};

use bendtwin_core::{Category, Fault, FitSettings, Problem as _, Twin};
use bendtwin_fit::OpenRasteriser;
use bendtwin_proto::worker::v1::{Lease, lease_job_request::Kind};
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;
use tracing::Instrument as _;

use self::compute::{Compute, Finished, Inputs};
use crate::{
    Error, Limits, artifact,
    device::{Device, Priority},
    job::{
        Job, checkpoints, deliver, report, resume,
        stop::{Reason, Stop},
    },
    leasing::Execute,
    observation, priority,
    server_client::ServerClient,
};

/// Executor of fit jobs.
#[derive(Clone)]
pub(crate) struct Fits {
    pub(crate) server: ServerClient,
    pub(crate) device: Device,
    /// workers/{uuid}
    pub(crate) worker: String,
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

    fn server(&self) -> &ServerClient {
        &self.server
    }

    fn worker(&self) -> &str {
        &self.worker
    }

    async fn execute(&self, lease: Lease, drain: &CancellationToken) {
        let span = tracing::info_span!(
            "fit",
            job = lease.job,
            epoch = lease.epoch,
            request_id = lease.request_id,
            trace_parent = lease.trace_parent
        );
        bendtwin_telemetry::continue_from(&span, &lease.trace_parent);
        self.execute_in_span(lease, drain).instrument(span).await;
    }
}

impl Fits {
    async fn execute_in_span(&self, lease: Lease, drain: &CancellationToken) {
        tracing::info!(capture = lease.capture, resumed = lease.has_checkpoint, "fit leased");
        let job = Job::new(self.server.clone(), self.worker.clone(), &lease);
        let stop = Stop::default();
        let (progress, reporter) = report::start(job.clone(), stop.clone());
        let (checkpoints, saver) = checkpoints::start(job.clone(), stop.clone());
        let draining = stop.on_drain(drain);
        let compute = Compute { progress: progress.clone(), checkpoints, stop: stop.clone() };
        let (outcome, straggler) = match self.begin(&lease, compute).await {
            Err(fault) => (Outcome::Failed(fault), None),
            Ok(thread) => finish(thread, &stop).await,
        };
        if stop.reason().is_none() {
            report::flush(&job, &progress).await;
        }
        // The lease is renewed until the end is written: only then may its renewal cease.
        self.conclude(&job, outcome, &stop, saver, drain).await;
        draining.abort();
        reporter.abort();
        if let Some(straggler) = straggler {
            // Before the next job: two captures in memory may be one too many.
            tokio::select! {
                _ = straggler => {}
                () = drain.cancelled() => {}
            }
        }
    }

    /// Fetches the inputs and starts the thread that computes.
    async fn begin(&self, lease: &Lease, compute: Compute) -> Result<Thread, Fault> {
        let stop = compute.stop.clone();
        let inputs = tokio::select! {
            fetched = self.fetch(lease) => fetched?,
            () = stop.stopped() => return Err(cancelled()),
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

    async fn fetch(&self, lease: &Lease) -> Result<Inputs, Fault> {
        let settings = settings_of(&lease.settings_json)?;
        let (name, digest) = (observation::name(&lease.capture), &lease.observation_digest);
        let observation = artifact::fetch_file(&self.server, &name, Some(digest), &self.dir)
            .await
            .map_err(|e| e.fault())?;
        let checkpoint = resume::checkpoint(&self.server, lease).await.map_err(|e| e.fault())?;
        let start = match &settings.start_from {
            Some(name) => Some(self.twin(name).await?),
            None => None,
        };
        Ok(Inputs { lease: lease.clone(), settings, start, observation, checkpoint })
    }

    /// The twin that a fit begins with.
    async fn twin(&self, name: &str) -> Result<Twin, Fault> {
        let fetched = artifact::fetch(&self.server, name, self.limits.twin_bytes).await;
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
    async fn conclude(
        &self,
        job: &Job,
        outcome: Outcome,
        stop: &Stop,
        saver: checkpoints::Saver,
        drain: &CancellationToken,
    ) {
        if stop.reason() == Some(Reason::Stale) {
            tracing::warn!("the lease is stale: another worker has the job");
            return saver.abort();
        }
        let delivery = deliver::Delivery { job, drain, delivery_timeout: self.delivery_timeout };
        match (outcome, stop.reason()) {
            (Outcome::Finished(finished), _) => {
                saver.abort();
                twin::deliver(&delivery, *finished).await;
            }
            (Outcome::Failed(fault), None) if self.met_a_broken_device(&fault) => {
                tracing::warn!("a rollout broke the device: the fit is handed back");
                saver.flush().await;
                delivery.fail(fault, deliver::Failure::Interrupted).await;
            }
            (Outcome::Failed(fault), stopped) => {
                delivery.fail_unfinished("fit", fault, stopped, saver).await;
            }
            (Outcome::Panicked(text), _) => {
                saver.flush().await;
                tracing::error!("fit panicked: {text}");
                let fault = Fault {
                    category: Category::Internal,
                    reason: "WORKER_PANICKED".to_owned(),
                    message: "the fit failed for a reason inside the worker, which restarts; \
                              its log has the details"
                        .to_owned(),
                };
                delivery.fail(fault, deliver::Failure::Passing).await;
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

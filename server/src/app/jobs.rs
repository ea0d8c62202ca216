//! Jobs as workers see them: leased, reported, checkpointed, ended.

mod overrun;
mod preview;
pub(super) mod results;

use std::{collections::HashSet, time::Duration};

use bendtwin_core::{
    Fault, ModelLoss, Progress,
    ids::{CaptureId, TwinId, WorkerId},
};
use bendtwin_proto::v1::FitPreview;
use bendtwin_store::{
    AttemptEnd, Capture, Claimant, Content, Digest, Error as StoreError, Job, JobId, JobReport,
    Kind, Lease, LeaseTerms, Observation, Reported, Supplement, SupplementKind, Turns, TwinFacts,
    WorkerEnd,
};

use super::{App, Body, Error, Result, captures::supplements, receive::Receiving};

/// News of a worker about its job.
#[derive(Clone, Debug, Default)]
pub(crate) struct News {
    pub(crate) progress: Option<Progress>,
    /// Losses since the last report.
    pub(crate) losses: Vec<ModelLoss>,
    /// What the fit has so far, if that is newer than in the last report.
    pub(crate) preview: Option<FitPreview>,
}

/// Contents that workers may download.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Downloadable {
    Capture(CaptureId),
    Observation(CaptureId),
    /// Masks that the ingest before made of strokes.
    Masks(CaptureId),
    Supplement(CaptureId, SupplementKind),
    Twin(TwinId),
    /// The checkpoint of a job.
    Checkpoint(JobId),
}

impl std::str::FromStr for Downloadable {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        match name.split_once('/').map(|(collection, _)| collection) {
            Some("captures") => of_capture(name),
            Some("twins") => Ok(Self::Twin(super::name_of_worker(name)?)),
            Some("fits" | "ingests") => Ok(Self::Checkpoint(super::name_of_worker(name)?)),
            _ => Err(Error::invalid("name", "names no capture, twin or job")),
        }
    }
}

/// A content of a capture.
fn of_capture(name: &str) -> Result<Downloadable> {
    if let Some(capture) = name.strip_suffix("/observation") {
        return Ok(Downloadable::Observation(super::name_of_worker(capture)?));
    }
    // Before the masks: they are a supplement, too.
    if let Some((capture, kind)) = name.split_once("/supplements/") {
        return Ok(Downloadable::Supplement(
            super::name_of_worker(capture)?,
            supplements::kind(kind)?,
        ));
    }
    match name.strip_suffix("/masks") {
        Some(capture) => Ok(Downloadable::Masks(super::name_of_worker(capture)?)),
        None => Ok(Downloadable::Capture(super::name_of_worker(name)?)),
    }
}

impl std::fmt::Display for Downloadable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Capture(id) => id.fmt(f),
            Self::Observation(id) => write!(f, "{id}/observation"),
            Self::Masks(id) => write!(f, "{id}/masks"),
            Self::Supplement(id, kind) => write!(f, "{id}/supplements/{kind}"),
            Self::Twin(id) => id.fmt(f),
            Self::Checkpoint(id) => write!(f, "the checkpoint of {id}"),
        }
    }
}

/// A job that was leased to a worker, with its capture and what it may read of it.
#[derive(Clone, Debug)]
pub(crate) struct LeasedJob {
    pub(crate) job: Job,
    pub(crate) capture: Capture,
    pub(crate) observation: Option<Observation>,
    /// Files that were added to the capture, for an ingest.
    pub(crate) supplements: Vec<Supplement>,
    /// Masks that the ingest before made, for an ingest.
    pub(crate) masks: Option<Digest>,
}

/// Answer to a worker that asks for a job.
#[derive(Clone, Debug)]
pub(crate) enum Offer {
    /// A job, which is leased to it.
    Job(Box<LeasedJob>),
    /// No job within the wait.
    Nothing,
    /// The worker is to drain and exit.
    Drain,
}

/// Longest wait for a job in one call.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

impl App {
    /// Waits for a job of a kind, or for a brief one, and leases it.
    pub(crate) async fn lease_job(
        &self,
        kind: Kind,
        worker: WorkerId,
        wait: Duration,
        brief: bool,
    ) -> Result<Offer> {
        self.require_known(worker).await?;
        let jobs = self.store.jobs();
        let mut claimant = self.claimant(worker);
        claimant.capabilities.brief = brief;
        let wait = wait.min(LONGEST_WAIT);
        let claimed = jobs.claim_within(kind, claimant, self.options.lease(), wait);
        let draining = self.dispatch.draining(worker);
        let claimed = tokio::select! {
            () = self.stopping.cancelled() => return Err(Error::Stopping),
            () = draining.cancelled() => return Ok(Offer::Drain),
            claimed = claimed => claimed?,
        };
        let Some(job) = claimed else { return Ok(Offer::Nothing) };
        // From here on, every return without an answer to the worker gives the job back.
        let mut guard = LeaseGuard { app: self.clone(), lease: job.lease() };
        // A process that ended while it waited must not hold the job until the lease runs out:
        // its registration was dropped before its leases were.
        self.require_known(worker).await?;
        let captures = self.store.captures();
        let capture = match captures.get(job.capture).await {
            // A server of a version without a trash queued it.
            Err(StoreError::InTrash { .. }) => {
                guard.lease = None;
                if let Some(lease) = job.lease() {
                    jobs.end_attempt(lease, AttemptEnd::Cancelled).await?;
                }
                return Ok(Offer::Nothing);
            }
            capture => capture?,
        };
        let observation = captures.observation(job.capture).await?;
        let (supplements, masks) = match kind {
            Kind::Ingest => {
                let supplements = captures.supplements(job.capture).await?;
                (supplements, captures.masks_digest(job.capture).await?)
            }
            Kind::Fit => (Vec::new(), None),
        };
        guard.lease = None;
        if job.lease_epoch == 1 {
            // Later ones were handed back, or failed: they did not wait all the time.
            let queued = job.created.duration_until(self.store.now()).as_secs_f64();
            self.metrics.job_leased(kind, queued);
        }
        self.dispatch.set_job(worker, kind, Some(&job));
        self.dispatch.seen(worker);
        tracing::info!(job = %job.id, %worker, epoch = job.lease_epoch, "job leased");
        let leased = LeasedJob { job, capture, observation, supplements, masks };
        Ok(Offer::Job(Box::new(leased)))
    }

    /// A worker as one that asks for jobs.
    fn claimant(&self, worker: WorkerId) -> Claimant {
        Claimant { worker, capabilities: self.dispatch.capabilities(worker) }
    }

    /// Renews a lease and keeps what is new. Ends the attempt if the job has run too long or makes no
    /// progress: the worker learns of it with its next report, whose lease is stale.
    pub(crate) async fn report_job(&self, lease: Lease, news: &News) -> Result<Reported> {
        // Ingests have none, and do not make way.
        let is_fit = lease.job.fit().is_some();
        let losses = if is_fit { &news.losses[..] } else { &[] };
        let preview = news.preview.as_ref().filter(|_| is_fit).map(preview::encode).transpose()?;
        let claimant = self.claimant(lease.worker);
        let turns = Turns { claimant: &claimant, slice: self.options.queue.slice() };
        let turns = is_fit.then_some(turns);
        let (progress, preview) = (news.progress.as_ref(), preview.as_deref());
        let report = JobReport { progress, losses, preview, turns };
        let reported = self.store.jobs().report(lease, report, self.options.lease()).await?;
        self.dispatch.seen(lease.worker);
        let overrun = overrun::of(lease.job.kind(), &reported.times, &self.options.queue);
        if let Some(overrun) = overrun.filter(|_| !reported.cancel_requested) {
            tracing::warn!(job = %lease.job, worker = %lease.worker, "{overrun}");
            self.end_attempt(lease, overrun.into()).await?;
        }
        Ok(reported)
    }

    pub(crate) async fn save_checkpoint(
        &self,
        lease: Lease,
        digest: &str,
        body: Body,
    ) -> Result<()> {
        self.store.jobs().check_lease(lease).await?;
        let limit = self.options.limits.checkpoint_bytes;
        let receiving = Receiving::Result(limit);
        let content = self.receive(body, receiving, super::digest(digest)?).await?;
        let (store, renew) = (self.store.clone(), self.options.lease());
        self.change(async move { store.jobs().save_checkpoint(lease, content, renew).await })
            .await?;
        self.dispatch.seen(lease.worker);
        Ok(())
    }

    pub(crate) async fn complete_fit(
        &self,
        lease: Lease,
        facts: TwinFacts,
        digest: &str,
        body: Body,
    ) -> Result<TwinId> {
        self.store.jobs().check_lease(lease).await?;
        let limit = self.options.limits.twin_bytes;
        let receiving = Receiving::Result(limit);
        let content = self.receive(body, receiving, super::digest(digest)?).await?;
        let found = self.check_twin(&content).await?;
        results::compare_facts(&facts, &found)?;
        let facts = found;
        let store = self.store.clone();
        let complete = async move { store.jobs().complete_fit(lease, &facts, content).await };
        let twin = self.change(complete).await?;
        self.dispatch.set_job(lease.worker, Kind::Fit, None);
        self.metrics.job_ended(Kind::Fit, "succeeded");
        tracing::info!(fit = %lease.job, %twin, "fit succeeded");
        Ok(twin)
    }

    pub(crate) async fn end_attempt(&self, lease: Lease, end: AttemptEnd) -> Result<()> {
        let store = self.store.clone();
        let change = async move { store.jobs().end_attempt(lease, end).await };
        let job = self.change(change).await?;
        self.record_end(lease.worker, &job);
        Ok(())
    }

    /// Opens the content that a worker asks for, if one of its jobs needs it.
    pub(crate) async fn download(
        &self,
        worker: Option<WorkerId>,
        what: Downloadable,
    ) -> Result<Content> {
        let unknown = || Error::WorkerUnknown("the worker that calls".to_owned());
        if !self.needs(worker.ok_or_else(unknown)?, what).await? {
            return Err(Error::NotLeased(what.to_string()));
        }
        Ok(match what {
            Downloadable::Capture(id) => self.store.captures().content(id).await?.1,
            Downloadable::Observation(id) => self.store.captures().observation_content(id).await?.1,
            Downloadable::Masks(id) => self.store.captures().masks_content(id).await?,
            Downloadable::Supplement(id, kind) => {
                self.store.captures().supplement_content(id, kind).await?
            }
            Downloadable::Twin(id) => self.store.twins().content(id).await?.1,
            Downloadable::Checkpoint(id) => self.store.jobs().checkpoint(id).await?,
        })
    }

    /// True if the content belongs to a job that the worker has, or to the rollouts that any may
    /// get: of any twin, from a frame of any capture.
    async fn needs(&self, worker: WorkerId, what: Downloadable) -> Result<bool> {
        let held = self.store.jobs().held_by(worker).await?;
        let has_capture = |id: CaptureId| held.iter().any(|job| job.capture == id);
        Ok(match what {
            Downloadable::Twin(_) | Downloadable::Observation(_) => true,
            Downloadable::Checkpoint(id) => held.iter().any(|job| job.id == id),
            Downloadable::Capture(id)
            | Downloadable::Masks(id)
            | Downloadable::Supplement(id, _) => has_capture(id),
        })
    }

    /// Ends the attempts of a worker process that has ended: its jobs are requeued immediately. If
    /// the server itself ended it, the attempts do not count.
    pub(crate) async fn worker_gone(&self, worker: WorkerId) -> Result<()> {
        self.end_worker(worker).await.map(drop)
    }

    /// Ends the attempts of a worker that gave no sign of life for a whole lease.
    pub(super) async fn worker_fell_silent(&self, worker: WorkerId) -> Result<()> {
        tracing::warn!(%worker, "worker fell silent");
        for job in self.end_worker(worker).await? {
            self.metrics.lease_lost(job.id.kind());
        }
        Ok(())
    }

    async fn end_worker(&self, worker: WorkerId) -> Result<Vec<Job>> {
        let end = if self.stopping.is_cancelled() {
            WorkerEnd::ByServer
        } else {
            self.dispatch.worker_end(worker)
        };
        self.forfeit(worker, end).await
    }

    /// Lets the time of leases pass, ends the attempts of workers that fell silent, and forgets
    /// them.
    pub(crate) async fn sweep(&self, terms: LeaseTerms) -> Result<()> {
        let elsewhere = match self.store.is_shared() {
            true => self.sweep_members(terms.lease).await?,
            false => HashSet::new(),
        };
        // Renewals of leases are signs of life, so the leases of these workers have also run out.
        for worker in self.dispatch.silent(terms.lease) {
            self.worker_fell_silent(worker).await?;
        }
        // The lease of a job may run out here a moment before its server has been silent for one:
        // that is judged by its server, or when that is found gone.
        let worker_end =
            |worker| (!elsewhere.contains(&worker)).then(|| self.dispatch.worker_end(worker));
        for job in self.store.jobs().sweep(terms, worker_end).await? {
            self.metrics.lease_lost(job.id.kind());
            self.note_end(&job);
        }
        Ok(())
    }

    /// Records the end of a worker's attempt.
    pub(super) fn record_end(&self, worker: WorkerId, job: &Job) {
        self.dispatch.set_job(worker, job.id.kind(), None);
        self.note_end(job);
    }

    pub(super) fn note_end(&self, job: &Job) {
        let fault = job.fault.as_ref().or(job.attempt_faults.last());
        let fault: Option<&Fault> = fault;
        let (state, reason) = (job.state.as_str(), fault.map_or("", |f| f.reason.as_str()));
        tracing::info!(job = %job.id, state, reason, attempts = job.attempts, "attempt ended");
        self.metrics.job_ended(job.id.kind(), state);
    }
}

/// Gives a leased job back when dropped, unless the lease has been handed to the worker.
struct LeaseGuard {
    app: App,
    lease: Option<Lease>,
}

impl Drop for LeaseGuard {
    fn drop(&mut self) {
        let Some(lease) = self.lease.take() else { return };
        let app = self.app.clone();
        tokio::spawn(async move {
            if let Err(error) = app.store.jobs().end_attempt(lease, AttemptEnd::Released).await {
                tracing::warn!(%error, "cannot give back a job that no worker received: it waits for its lease to end");
            }
        });
    }
}

//! A worker in the routing table: its registration, its current work, and the connection to it.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use bendtwin_contract::rollout::SessionParts;
use bendtwin_core::{
    ids::{CaptureId, FitId, SessionId, TwinId},
    settings::memory::Lanes,
};
use bendtwin_proto::worker::v1::worker_rollouts_client::WorkerRolloutsClient;
use bendtwin_store::{Capabilities, Job, Kind, Worker};
use jiff::Timestamp;
use semver::Version;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use tonic::{metadata::AsciiMetadataValue, transport::Channel};

use super::{
    executing::Executing,
    line::{Ask, Line},
    route::Candidate,
};
use crate::{
    access::Child,
    error::{Error, Result},
    options::Limits,
};

/// Time for which a worker that broke a connection is left alone.
const BROKEN_FOR: Duration = Duration::from_secs(2);
/// Longest that a heartbeat is under way.
const UNDER_WAY: Duration = Duration::from_secs(10);

/// A worker in the routing table.
#[derive(Debug)]
pub(super) struct Entry {
    worker: Worker,
    /// The process of the server's that it is, if it is one.
    pub(super) child: Option<Child>,
    /// Cancelled once it is to take no more work.
    pub(super) draining: CancellationToken,
    /// Cancelled when the entry goes.
    pub(super) gone: CancellationToken,
    live: Mutex<Live>,
    pub(super) line: Line,
    client: WorkerRolloutsClient<Channel>,
    token: AsciiMetadataValue,
    /// Rollouts that it has taken.
    pub(super) executing: Executing,
}

/// The time of day, and the time of leases: [`bendtwin_store::Store::lease_time`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Now {
    pub(super) day: Timestamp,
    pub(super) lease: Duration,
}

/// Last sign of life of a worker when its entry is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum LastSign {
    At(Now),
    /// Never seen here: another server knows it. It is not used until it answers.
    Never,
}

/// Facts that change while a worker lives.
#[derive(Debug)]
pub(super) struct Live {
    /// Last sign of life, by the time of leases; `None` without one at this server.
    last_sign: Option<Duration>,
    last_seen: Timestamp,
    warm: Vec<TwinId>,
    /// Sessions that live there.
    sessions: HashMap<SessionId, HeldSession>,
    /// Opening times of sessions that a heartbeat may not list yet.
    opened: HashMap<SessionId, Instant>,
    in_flight: u32,
    memory: Option<Memory>,
    fit_bytes: u64,
    fit: Option<ReportedJob<FitId>>,
    /// The capture whose ingest it is at.
    ingest: Option<ReportedJob<CaptureId>>,
    broken_until: Option<Instant>,
}

/// A job, and when it was heard of.
#[derive(Clone, Copy, Debug)]
struct ReportedJob<T> {
    id: T,
    at: Instant,
}

impl<T> ReportedJob<T> {
    fn now(id: T) -> Self {
        Self { id, at: Instant::now() }
    }
}

/// A worker as listings show it.
#[derive(Clone, Debug)]
pub(crate) struct WorkerView {
    pub(crate) worker: Worker,
    pub(crate) last_seen: Timestamp,
    pub(crate) warm: Vec<TwinId>,
    pub(crate) in_flight: u32,
    pub(crate) memory: Option<Memory>,
    pub(crate) fit: Option<FitId>,
    pub(crate) ingest: Option<CaptureId>,
}

impl From<Worker> for WorkerView {
    /// A worker known only by its registration.
    fn from(worker: Worker) -> Self {
        let last_seen = worker.started;
        Self {
            worker,
            last_seen,
            warm: Vec::new(),
            in_flight: 0,
            memory: None,
            fit: None,
            ingest: None,
        }
    }
}

/// Facts that a worker reports with every heartbeat.
#[derive(Clone, Debug, Default)]
pub(crate) struct Heartbeat {
    /// The twins that it has loaded.
    pub(crate) warm: Vec<TwinId>,
    /// The sessions that live there.
    pub(crate) sessions: HashMap<SessionId, HeldSession>,
    pub(crate) in_flight: u32,
    pub(crate) memory: Option<Memory>,
    /// Memory that a fit may take [bytes]; zero if it takes no fits.
    pub(crate) fit_bytes: u64,
    /// The fit under way, and the capture whose ingest is.
    pub(crate) fit: Option<FitId>,
    pub(crate) ingest: Option<CaptureId>,
}

/// Facts of a session that lives at a worker.
#[derive(Clone, Debug)]
pub(crate) struct HeldSession {
    pub(crate) twin: TwinId,
    /// The owner that opened it; empty if it is not known.
    pub(crate) owner: Arc<str>,
    pub(crate) slots: u32,
    /// Surroundings of the session, for rollouts that name none themselves.
    pub(crate) parts: SessionParts,
}

/// Capacity of a worker for a fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FitRoom {
    /// Memory that a fit may take [bytes].
    pub(crate) bytes: u64,
    pub(crate) lanes: Lanes,
}

/// Memory of a worker's device [bytes].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Memory {
    /// In use, by all processes.
    pub(crate) used: u64,
    pub(crate) total: u64,
}

impl Live {
    /// Takes over the sessions in a heartbeat. The heartbeat may have been sent before a session
    /// was opened, so a new session stays even if it is missing there.
    fn take_sessions(&mut self, mut sessions: HashMap<SessionId, HeldSession>) {
        self.opened.retain(|_, opened| opened.elapsed() < UNDER_WAY);
        let new = self.sessions.iter().filter(|(id, _)| self.opened.contains_key(id));
        sessions.extend(new.map(|(id, held)| (*id, held.clone())));
        // Workers of earlier versions do not know the owner.
        for (id, held) in &mut sessions {
            if let Some(known) = self.sessions.get(id).filter(|_| held.owner.is_empty()) {
                held.owner = Arc::clone(&known.owner);
            }
        }
        self.sessions = sessions;
    }

    /// Takes over the jobs in a heartbeat. The heartbeat may have been sent before a job was leased
    /// here, and a job that was leased here may have ended at another server.
    fn take_jobs(&mut self, fit: Option<FitId>, ingest: Option<CaptureId>) {
        self.fit = fit.map(ReportedJob::now).or(self.fit.filter(|f| f.at.elapsed() < UNDER_WAY));
        self.ingest =
            ingest.map(ReportedJob::now).or(self.ingest.filter(|i| i.at.elapsed() < UNDER_WAY));
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        self.gone.cancel();
    }
}

impl Entry {
    pub(super) fn new(
        worker: Worker,
        child: Option<Child>,
        token: &str,
        limits: &Limits,
        heard: LastSign,
        channel: Channel,
    ) -> Result<Self> {
        let client = WorkerRolloutsClient::new(channel)
            .max_decoding_message_size(limits.rollout.sent_reply_bytes())
            .max_encoding_message_size(limits.rollout.sent_request_bytes());
        let mut token =
            AsciiMetadataValue::try_from(format!("Bearer {token}")).map_err(|_| Error::BadToken)?;
        token.set_sensitive(true);
        let live = Live {
            last_sign: match heard {
                LastSign::At(now) => Some(now.lease),
                LastSign::Never => None,
            },
            last_seen: match heard {
                LastSign::At(now) => now.day,
                LastSign::Never => worker.started,
            },
            warm: Vec::new(),
            sessions: HashMap::new(),
            opened: HashMap::new(),
            in_flight: 0,
            memory: None,
            fit_bytes: 0,
            fit: None,
            ingest: None,
            broken_until: None,
        };
        let draining = CancellationToken::new();
        if worker.is_draining {
            draining.cancel();
        }
        Ok(Self {
            worker,
            child,
            draining,
            gone: CancellationToken::new(),
            live: Mutex::new(live),
            line: Line::new(limits.rollouts_per_worker, limits.rollout_queue),
            client,
            token,
            executing: Executing::default(),
        })
    }

    /// The registration.
    pub(super) fn worker(&self) -> &Worker {
        &self.worker
    }

    pub(super) fn id(&self) -> bendtwin_core::ids::WorkerId {
        self.worker.registration.id
    }

    /// Instances that the worker simulates concurrently.
    pub(super) fn lanes(&self) -> u32 {
        self.worker.registration.lanes
    }

    /// True if its results do not depend on how many instances are simulated together.
    pub(super) fn is_cpu(&self) -> bool {
        self.worker.registration.backend == "cpu"
    }

    /// True if the other computes the same way: the same build on the same device.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let of = |entry: &Self| {
            let worker = &entry.worker.registration;
            (worker.backend.clone(), worker.device.clone(), worker.build.clone())
        };
        of(self) == of(other)
    }

    /// The connection, and the token to show.
    pub(super) fn client(&self) -> (WorkerRolloutsClient<Channel>, AsciiMetadataValue) {
        (self.client.clone(), self.token.clone())
    }

    pub(super) fn live(&self) -> MutexGuard<'_, Live> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn heartbeat(&self, now: Now, heartbeat: Heartbeat) {
        self.executing.is_alive(heartbeat.in_flight);
        self.seen(now);
        let mut live = self.live();
        live.warm = heartbeat.warm;
        live.take_sessions(heartbeat.sessions);
        live.in_flight = heartbeat.in_flight;
        live.memory = heartbeat.memory;
        live.fit_bytes = heartbeat.fit_bytes;
        live.take_jobs(heartbeat.fit, heartbeat.ingest);
        self.line.set_fit(live.fit.is_some());
    }

    /// Notes the job of a kind that it is at.
    pub(super) fn set_job(&self, kind: Kind, job: Option<&Job>) {
        let mut live = self.live();
        match kind {
            Kind::Ingest => live.ingest = job.map(|j| ReportedJob::now(j.capture)),
            Kind::Fit => {
                live.fit = job.and_then(|j| j.id.fit()).map(ReportedJob::now);
                self.line.set_fit(live.fit.is_some());
            }
        }
    }

    /// True if it said that it is at more rollouts than those of this server.
    pub(super) fn has_others_rollouts(&self) -> bool {
        self.live().in_flight as usize > self.line.len()
    }

    pub(super) fn seen(&self, now: Now) {
        let mut live = self.live();
        (live.last_sign, live.last_seen) = (Some(now.lease), now.day);
    }

    /// The worker answered a rollout of this twin: it has it loaded.
    pub(super) fn warmed(&self, twin: TwinId) {
        let mut live = self.live();
        live.broken_until = None;
        if !live.warm.contains(&twin) {
            live.warm.push(twin);
        }
    }

    /// Number of sessions that live there.
    pub(super) fn session_count(&self) -> usize {
        self.live().sessions.len()
    }

    /// A session that lives there.
    pub(super) fn session(&self, session: SessionId) -> Option<HeldSession> {
        self.live().sessions.get(&session).cloned()
    }

    /// Notes a session that has begun there.
    pub(super) fn opened(&self, session: SessionId, held: HeldSession) {
        let mut live = self.live();
        live.opened.insert(session, Instant::now());
        live.sessions.insert(session, held);
    }

    /// Notes that a session is not there, or no longer.
    pub(super) fn closed(&self, session: SessionId) {
        let mut live = self.live();
        live.opened.remove(&session);
        live.sessions.remove(&session);
    }

    /// The connection broke: leave the worker alone for a while.
    pub(super) fn broke(&self) {
        self.live().broken_until = Some(Instant::now() + BROKEN_FOR);
    }

    /// Capacity for a fit; `None` if the worker takes no fits or has not reported yet.
    pub(super) fn fit_room(&self) -> Option<FitRoom> {
        let bytes = self.live().fit_bytes;
        let worker = &self.worker.registration;
        let lanes = Lanes { count: u64::from(worker.lanes), on_host: worker.backend == "cpu" };
        (bytes > 0).then_some(FitRoom { bytes, lanes })
    }

    /// Properties that jobs can ask for.
    pub(super) fn capabilities(&self) -> Capabilities {
        let live = self.live();
        let worker = &self.worker.registration;
        let of_device = live.memory.map_or(0, |memory| memory.total);
        Capabilities {
            backend: worker.backend.clone(),
            memory_bytes: if self.is_cpu() { live.fit_bytes } else { of_device },
            labels: worker.labels.clone(),
            version: version(&worker.build),
            brief: false,
        }
    }

    /// Time without a sign of life, given the time of leases.
    pub(super) fn silence(&self, now: Duration) -> Duration {
        self.live().last_sign.map_or(Duration::MAX, |sign| now.saturating_sub(sign))
    }

    pub(super) fn candidate(&self, twin: TwinId, ask: &Ask, is_fresh: bool) -> Candidate {
        let live = self.live();
        let broken = live.broken_until.is_some_and(|until| until > Instant::now());
        Candidate {
            worker: self.id(),
            usable: !broken && is_fresh && !self.draining.is_cancelled(),
            warm: live.warm.contains(&twin),
            has_room: self.line.has_room(ask),
            ahead_s: self.line.ahead_s(),
            calls: self.line.len(),
            has_fit: live.fit.is_some(),
        }
    }

    pub(super) fn view(&self) -> WorkerView {
        let live = self.live();
        WorkerView {
            worker: Worker { is_draining: self.draining.is_cancelled(), ..self.worker.clone() },
            last_seen: live.last_seen,
            warm: live.warm.clone(),
            in_flight: live.in_flight.max(u32::try_from(self.line.len()).unwrap_or(u32::MAX)),
            memory: live.memory,
            fit: live.fit.map(|job| job.id),
            ingest: live.ingest.map(|job| job.id),
        }
    }
}

/// The version in the name of a build, such as `bendtwin 0.1.0`.
fn version(build: &str) -> Option<Version> {
    Version::parse(build.rsplit(' ').next()?).ok()
}

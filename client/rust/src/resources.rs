//! The server's resources as Rust types.

use bendtwin_core::{
    Fault, Quality,
    ids::{CaptureId, FitId, TwinId, WorkerId},
};
use bendtwin_proto::v1;
use jiff::Timestamp;
use serde::Serialize;

use crate::Error;

/// A stored capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Capture {
    /// Its name.
    pub name: CaptureId,
    /// Display name.
    pub display_name: String,
    /// Time of the upload.
    pub create_time: Timestamp,
    /// Size of the archive [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of the archive, hex.
    pub digest: String,
    /// The job that reads it. There is one for each capture; running it again replaces it. Fits of
    /// the capture fail with its fault.
    pub ingest: Job,
    /// The report's verdict: `good`, `usable` or `unusable`; none while there is no report.
    pub verdict: Option<String>,
    /// Text that people write about it.
    pub note: String,
    /// Tags, sorted.
    pub tags: Vec<String>,
    /// Owner of the key with which it was made; empty if that is not known.
    pub owner: String,
    /// Worker that its ingest asks for.
    pub ingest_requirements: Requirements,
}

/// Work that a worker does for a fit, or for the ingest of a capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Job {
    /// State of the job.
    pub state: JobState,
    /// The settings in force.
    pub settings: serde_json::Value,
    /// Progress while it runs.
    pub progress: Option<JobProgress>,
    /// The fault if it failed.
    pub fault: Option<Fault>,
    /// Faults of earlier attempts.
    pub attempt_faults: Vec<Fault>,
    /// Number of attempts.
    pub attempts: u32,
    /// The worker while it runs.
    pub worker: Option<WorkerId>,
    /// True if it has been asked to stop.
    pub cancel_requested: bool,
    /// Time of creation.
    pub create_time: Timestamp,
    /// Time of the first start.
    pub start_time: Option<Timestamp>,
    /// Time of the end.
    pub end_time: Option<Timestamp>,
    /// Revision; grows with every change, and from one run of an ingest to the next.
    pub revision: u64,
}

/// State of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum JobState {
    /// The job waits for a worker.
    Queued,
    /// A worker executes the job.
    Running,
    /// The job has a result.
    Succeeded,
    /// The job failed for good.
    Failed,
    /// A user stopped the job.
    Cancelled,
}

impl JobState {
    /// True if the state is final.
    pub fn has_ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }

    /// Its form in a request.
    pub(crate) fn wire(self) -> v1::job::State {
        match self {
            Self::Queued => v1::job::State::Queued,
            Self::Running => v1::job::State::Running,
            Self::Succeeded => v1::job::State::Succeeded,
            Self::Failed => v1::job::State::Failed,
            Self::Cancelled => v1::job::State::Cancelled,
        }
    }

    /// The state as one lower-case word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }
}

/// Progress of a running job.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JobProgress {
    /// `ingest`, `search`, `refine` or `evaluate`.
    pub stage: String,
    /// `bending` or `axial`; for an ingest, its step.
    pub variant: String,
    /// Iterations of the stage that are done.
    pub iteration: u32,
    /// Iterations of the stage in total.
    pub iterations: u32,
    /// Fraction of the whole job, 0..=1.
    pub fraction: f64,
    /// Loss of the last iteration.
    pub loss: Option<f64>,
    /// Best loss so far.
    pub best_loss: Option<f64>,
    /// Estimated time until the end [s].
    pub eta_s: Option<f64>,
    /// A note for the user; empty if none.
    pub note: String,
    /// The last loss of each model that is fitted side by side with others.
    pub models: Vec<ModelLoss>,
}

/// Loss of a model after an iteration.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ModelLoss {
    /// `search` or `refine`.
    pub stage: String,
    /// `bending` or `axial`, of several starts followed by which: `bending 2/3`.
    pub variant: String,
    /// Iterations of the stage that were done.
    pub iteration: u32,
    /// Loss of that iteration; none if it was not finite.
    pub loss: Option<f64>,
    /// Lowest loss up to it.
    pub best_loss: Option<f64>,
}

/// A fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Its name.
    pub name: FitId,
    /// The capture to be fitted.
    pub capture: CaptureId,
    /// The result.
    pub twin: Option<TwinId>,
    /// Priority: jobs of higher priority run earlier.
    pub priority: i32,
    /// The work on it.
    pub job: Job,
    /// Display name: the capture's, unless one was given.
    pub display_name: String,
    /// Text that people write about it.
    pub note: String,
    /// Tags, sorted.
    pub tags: Vec<String>,
    /// Owner of the key with which it was made; empty if that is not known.
    pub owner: String,
    /// Error of its twin, as there [m].
    pub error_m: Option<f64>,
    /// Worker that it asks for.
    pub requirements: Requirements,
}

/// Worker that a fit or an ingest asks for, which waits until there is one; by default any.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Requirements {
    /// `cpu` or `cuda`; empty means either.
    pub backend: String,
    /// Memory of the device at least [bytes]; on a CPU, that which a fit may take.
    pub memory_bytes: u64,
    /// Labels of which the worker has each.
    pub labels: Vec<String>,
}

/// A stored twin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Twin {
    /// Its name.
    pub name: TwinId,
    /// Display name.
    pub display_name: String,
    /// The capture that it was fitted to; none if it was imported.
    pub capture: Option<CaptureId>,
    /// The job that made it; none if it was imported.
    pub fit: Option<FitId>,
    /// Time of storage.
    pub create_time: Timestamp,
    /// Size of its file [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of its file, hex.
    pub digest: String,
    /// Number of nodes.
    pub node_count: u32,
    /// Number of springs.
    pub spring_count: u32,
    /// Number of bending triplets.
    pub triplet_count: u32,
    /// Number of control points.
    pub control_count: u32,
    /// Number of frames per second.
    pub fps: f64,
    /// Number of substeps per frame.
    pub substeps: u32,
    /// The quality table.
    pub quality: Quality,
    /// Mass of the object, if it is known [kg].
    pub mass_kg: Option<f64>,
    /// Text that people write about it.
    pub note: String,
    /// Tags, sorted.
    pub tags: Vec<String>,
    /// Owner of the key with which it was made; empty if that is not known.
    pub owner: String,
    /// Error over frames that it was not fitted to [m]: of tracks, else of coordinates, else the
    /// Chamfer distance.
    pub error_m: Option<f64>,
}

/// A worker process.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Worker {
    /// Its name; a restarted worker has another one.
    pub name: WorkerId,
    /// `cpu` or `cuda`.
    pub backend: String,
    /// Name of its device.
    pub device: String,
    /// Time of registration.
    pub start_time: Timestamp,
    /// Time of the last heartbeat.
    pub last_seen_time: Timestamp,
    /// The fit under way.
    pub fit: Option<FitId>,
    /// The capture whose ingest is under way.
    pub ingest: Option<CaptureId>,
    /// Twins that are loaded and answer at once.
    pub warm_twins: Vec<TwinId>,
    /// Number of rollouts under way.
    pub rollouts_in_flight: u32,
    /// Version of its software.
    pub build: String,
    /// Memory of its device, if known.
    pub memory: Option<DeviceMemory>,
    /// Words that it was started with, which fits can ask for.
    pub labels: Vec<String>,
    /// True if it was asked to end.
    pub draining: bool,
    /// `servers/{uuid}` of the server that started it and whose rollouts alone it answers.
    pub server: Option<String>,
}

/// Memory of a worker's device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceMemory {
    /// In use by all processes [bytes].
    pub used_bytes: u64,
    /// In total [bytes].
    pub total_bytes: u64,
}

impl TryFrom<v1::Capture> for Capture {
    type Error = Error;
    fn try_from(wire: v1::Capture) -> Result<Self, Error> {
        Ok(Self {
            name: id(&wire.name)?,
            display_name: wire.display_name,
            create_time: time(wire.create_time)?,
            size_bytes: wire.size_bytes,
            digest: wire.digest,
            ingest: wire.ingest.ok_or_else(|| Error::malformed("no ingest"))?.try_into()?,
            verdict: Some(wire.verdict).filter(|v| !v.is_empty()),
            note: wire.note,
            tags: wire.tags,
            owner: wire.owner,
            ingest_requirements: wire.ingest_requirements.map(Into::into).unwrap_or_default(),
        })
    }
}

impl TryFrom<v1::Job> for Job {
    type Error = Error;
    fn try_from(wire: v1::Job) -> Result<Self, Error> {
        use v1::job::State;
        let state = match wire.state() {
            State::Queued => JobState::Queued,
            State::Running => JobState::Running,
            State::Succeeded => JobState::Succeeded,
            State::Failed => JobState::Failed,
            State::Cancelled => JobState::Cancelled,
            State::Unspecified => {
                return Err(Error::malformed(format!("job state {}", wire.state)));
            }
        };
        Ok(Self {
            state,
            settings: settings(&wire.settings_json)?,
            progress: wire.progress.map(JobProgress::from),
            fault: wire.fault.as_ref().map(Fault::from),
            attempt_faults: wire.attempt_faults.iter().map(Fault::from).collect(),
            attempts: wire.attempts,
            worker: optional_id(&wire.worker)?,
            cancel_requested: wire.cancel_requested,
            create_time: time(wire.create_time)?,
            start_time: optional_time(wire.start_time)?,
            end_time: optional_time(wire.end_time)?,
            revision: wire.revision,
        })
    }
}

impl TryFrom<v1::Fit> for Fit {
    type Error = Error;
    fn try_from(wire: v1::Fit) -> Result<Self, Error> {
        Ok(Self {
            name: id(&wire.name)?,
            capture: id(&wire.capture)?,
            twin: optional_id(&wire.twin)?,
            priority: wire.priority,
            job: wire.job.ok_or_else(|| Error::malformed("no job"))?.try_into()?,
            display_name: wire.display_name,
            note: wire.note,
            tags: wire.tags,
            owner: wire.owner,
            error_m: wire.error_m,
            requirements: wire.requirements.map(Into::into).unwrap_or_default(),
        })
    }
}

impl From<v1::WorkerRequirements> for Requirements {
    fn from(wire: v1::WorkerRequirements) -> Self {
        let v1::WorkerRequirements { backend, memory_bytes, labels } = wire;
        Self { backend, memory_bytes, labels }
    }
}

impl Requirements {
    /// The message; none if any worker will do.
    pub(crate) fn message(self) -> Option<v1::WorkerRequirements> {
        (self != Self::default()).then(|| self.into())
    }

    /// As JSON; none if any worker will do.
    pub(crate) fn json(&self) -> Result<Option<String>, Error> {
        if *self == Self::default() {
            return Ok(None);
        }
        serde_json::to_string(self).map(Some).map_err(Error::malformed)
    }
}

impl From<Requirements> for v1::WorkerRequirements {
    fn from(asked: Requirements) -> Self {
        let Requirements { backend, memory_bytes, labels } = asked;
        Self { backend, memory_bytes, labels }
    }
}

impl From<v1::Progress> for JobProgress {
    fn from(wire: v1::Progress) -> Self {
        Self {
            stage: wire.stage,
            variant: wire.variant,
            iteration: wire.iteration,
            iterations: wire.iterations,
            fraction: wire.fraction,
            loss: wire.loss,
            best_loss: wire.best_loss,
            eta_s: wire.eta_s,
            note: wire.note,
            models: wire.models.into_iter().map(ModelLoss::from).collect(),
        }
    }
}

impl From<v1::ModelLoss> for ModelLoss {
    fn from(wire: v1::ModelLoss) -> Self {
        Self {
            stage: wire.stage,
            variant: wire.variant,
            iteration: wire.iteration,
            loss: wire.loss,
            best_loss: wire.best_loss,
        }
    }
}

impl TryFrom<v1::Twin> for Twin {
    type Error = Error;
    fn try_from(wire: v1::Twin) -> Result<Self, Error> {
        let quality = match wire.quality_json.as_str() {
            "" => Quality::default(),
            json => serde_json::from_str(json).map_err(Error::malformed)?,
        };
        Ok(Self {
            name: id(&wire.name)?,
            display_name: wire.display_name,
            capture: optional_id(&wire.capture)?,
            fit: optional_id(&wire.fit)?,
            create_time: time(wire.create_time)?,
            size_bytes: wire.size_bytes,
            digest: wire.digest,
            node_count: wire.node_count,
            spring_count: wire.spring_count,
            triplet_count: wire.triplet_count,
            control_count: wire.control_count,
            fps: wire.fps,
            substeps: wire.substeps,
            quality,
            mass_kg: wire.mass_kg,
            note: wire.note,
            tags: wire.tags,
            owner: wire.owner,
            error_m: wire.error_m,
        })
    }
}

impl TryFrom<v1::Worker> for Worker {
    type Error = Error;
    fn try_from(wire: v1::Worker) -> Result<Self, Error> {
        Ok(Self {
            name: id(&wire.name)?,
            backend: wire.backend,
            device: wire.device,
            start_time: time(wire.start_time)?,
            last_seen_time: time(wire.last_seen_time)?,
            fit: optional_id(&wire.fit)?,
            ingest: optional_id(&wire.ingest)?,
            warm_twins: wire.warm_twins.iter().map(|t| id(t)).collect::<Result<_, _>>()?,
            rollouts_in_flight: wire.rollouts_in_flight,
            build: wire.build,
            memory: (wire.memory_total_bytes > 0).then_some(DeviceMemory {
                used_bytes: wire.memory_used_bytes,
                total_bytes: wire.memory_total_bytes,
            }),
            labels: wire.labels,
            draining: wire.draining,
            server: Some(wire.server).filter(|server| !server.is_empty()),
        })
    }
}

fn settings(json: &str) -> Result<serde_json::Value, Error> {
    if json.is_empty() {
        return Ok(serde_json::Value::Null);
    }
    serde_json::from_str(json).map_err(Error::malformed)
}

pub(crate) fn id<T: std::str::FromStr<Err: std::fmt::Display>>(name: &str) -> Result<T, Error> {
    name.parse().map_err(Error::malformed)
}

fn optional_id<T: std::str::FromStr<Err: std::fmt::Display>>(
    name: &str,
) -> Result<Option<T>, Error> {
    if name.is_empty() { Ok(None) } else { id(name).map(Some) }
}

pub(crate) fn time(wire: Option<prost_types::Timestamp>) -> Result<Timestamp, Error> {
    optional_time(wire)?.ok_or_else(|| Error::malformed("a time is missing"))
}

pub(crate) fn optional_time(
    wire: Option<prost_types::Timestamp>,
) -> Result<Option<Timestamp>, Error> {
    wire.map(|t| Timestamp::new(t.seconds, t.nanos).map_err(Error::malformed)).transpose()
}

/// The form of a time in a request, to the second.
pub(crate) fn wire_time(time: Timestamp) -> prost_types::Timestamp {
    prost_types::Timestamp { seconds: time.as_second(), nanos: 0 }
}

//! Resources as JSON documents. Field names are those of the proto messages;
//! settings and quality are nested objects, times are RFC 3339.

use bendtwin_core::{Fault, Progress, ids};
use bendtwin_store as store;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::{IntoParams, ToSchema};

use crate::dispatch::WorkerView;

/// A stored capture.
#[derive(Serialize, ToSchema)]
pub(super) struct Capture {
    /// `captures/{uuid}`
    name: String,
    display_name: String,
    /// RFC 3339.
    create_time: String,
    size_bytes: u64,
    /// BLAKE3 of the archive, hex.
    digest: String,
    /// The job that reads it. There is one for each capture; running it again replaces it. Fits of
    /// the capture fail with its fault.
    ingest: Job,
    /// The report's verdict: good, usable or unusable. Null until there is a report.
    verdict: Option<String>,
    /// Text that people write about it.
    note: String,
    tags: Vec<String>,
    /// Owner of the key with which it was made; empty if that is not known.
    owner: String,
    /// Worker that its ingest asks for.
    ingest_requirements: Requirements,
}

impl From<store::Overview> for Capture {
    fn from(overview: store::Overview) -> Self {
        let store::Overview { capture, mut ingest, report } = overview;
        Self {
            name: capture.id.to_string(),
            display_name: capture.labels.display_name,
            create_time: capture.created.to_string(),
            size_bytes: capture.size_bytes,
            digest: capture.digest.to_hex().to_string(),
            ingest_requirements: std::mem::take(&mut ingest.requirements).into(),
            ingest: ingest.into(),
            verdict: report.map(|r| r.verdict),
            note: capture.labels.note,
            tags: capture.labels.tags,
            owner: capture.owner,
        }
    }
}

/// Work that a worker does for a fit, or for the ingest of a capture.
#[derive(Serialize, ToSchema)]
pub(super) struct Job {
    /// QUEUED, RUNNING, SUCCEEDED, FAILED or CANCELLED.
    state: String,
    /// The settings in force.
    #[schema(value_type = Object)]
    settings: Box<RawValue>,
    #[schema(value_type = Option<Object>)]
    progress: Option<Progress>,
    /// Reason for a failure: category, reason, message. Fits of the capture fail with it.
    #[schema(value_type = Option<Object>)]
    fault: Option<Fault>,
    /// Faults of earlier attempts.
    #[schema(value_type = Vec<Object>)]
    attempt_faults: Vec<Fault>,
    attempts: u32,
    /// `workers/{uuid}` while it runs.
    worker: Option<String>,
    cancel_requested: bool,
    create_time: String,
    start_time: Option<String>,
    end_time: Option<String>,
    /// Number that grows with every change, and from one run of an ingest to the next.
    revision: u64,
}

impl From<store::Job> for Job {
    fn from(job: store::Job) -> Self {
        let time = |t: Option<jiff::Timestamp>| t.map(|t| t.to_string());
        Self {
            state: job.state.as_str().to_uppercase(),
            settings: raw(job.settings),
            progress: job.progress,
            fault: job.fault,
            attempt_faults: job.attempt_faults,
            attempts: job.attempts,
            worker: job.worker.map(|w| w.to_string()),
            cancel_requested: job.cancel_requested,
            create_time: job.created.to_string(),
            start_time: time(job.started),
            end_time: time(job.ended),
            revision: job.revision,
        }
    }
}

/// An ingest to be run again.
#[derive(Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewIngest {
    /// Settings that differ from the defaults.
    #[schema(value_type = Option<Object>)]
    pub(super) settings: Option<Box<RawValue>>,
    /// Worker that it asks for.
    #[serde(default)]
    pub(super) requirements: Requirements,
}

/// A page of captures, newest first unless another order was asked for.
#[derive(Serialize, ToSchema)]
pub(super) struct Captures {
    pub(super) captures: Vec<Capture>,
    /// Empty on the last page.
    pub(super) next_page_token: String,
}

/// A fit.
#[derive(Serialize, ToSchema)]
pub(super) struct Fit {
    /// `fits/{uuid}`
    name: String,
    /// `captures/{uuid}`
    capture: String,
    /// `twins/{uuid}` once it has succeeded.
    twin: Option<String>,
    /// Jobs of higher priority run earlier.
    priority: i32,
    job: Job,
    /// The capture's when the fit was created, unless one was given.
    display_name: String,
    /// Text that people write about it.
    note: String,
    tags: Vec<String>,
    /// Owner of the key with which it was made; empty if that is not known.
    owner: String,
    /// Error of its twin [m], as there.
    error_m: Option<f64>,
    /// Worker that it asks for.
    requirements: Requirements,
}

/// Worker that a fit or an ingest asks for, which waits until there is one.
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Requirements {
    /// `cpu` or `cuda`; empty means either.
    backend: String,
    /// Memory of the device at least [bytes]; on a CPU, that which a fit may take.
    memory_bytes: u64,
    /// Labels of which the worker has each: up to 32 of up to 50 characters without spaces and commas.
    labels: Vec<String>,
}

impl From<store::Requirements> for Requirements {
    fn from(of_job: store::Requirements) -> Self {
        // The version follows from the settings.
        let store::Requirements { backend, memory_bytes, labels, version: _ } = of_job;
        Self { backend, memory_bytes, labels }
    }
}

impl From<Requirements> for store::Requirements {
    fn from(given: Requirements) -> Self {
        let Requirements { backend, memory_bytes, labels } = given;
        Self { backend, memory_bytes, labels, version: None }
    }
}

impl From<store::Job> for Fit {
    fn from(mut fit: store::Job) -> Self {
        let labels = std::mem::take(&mut fit.labels);
        let owner = std::mem::take(&mut fit.owner);
        Self {
            display_name: labels.display_name,
            note: labels.note,
            tags: labels.tags,
            owner,
            error_m: fit.error_m,
            name: fit.id.to_string(),
            capture: fit.capture.to_string(),
            twin: fit.twin.map(|t| t.to_string()),
            priority: fit.priority,
            requirements: std::mem::take(&mut fit.requirements).into(),
            job: fit.into(),
        }
    }
}

/// A page of fits, newest first unless another order was asked for.
#[derive(Serialize, ToSchema)]
pub(super) struct Fits {
    pub(super) fits: Vec<Fit>,
    /// Empty on the last page.
    pub(super) next_page_token: String,
}

/// A fit to be queued.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewFit {
    /// `captures/{uuid}`
    pub(super) capture: String,
    /// Settings that differ from the defaults.
    #[schema(value_type = Option<Object>)]
    pub(super) settings: Option<Box<RawValue>>,
    /// Jobs of higher priority run earlier, -100..=100.
    #[serde(default)]
    pub(super) priority: i32,
    /// Display name; empty means the capture's.
    #[serde(default)]
    pub(super) display_name: String,
    /// Worker that it asks for.
    #[serde(default)]
    pub(super) requirements: Requirements,
}

/// A stored twin.
#[derive(Serialize, ToSchema)]
pub(super) struct Twin {
    /// `twins/{uuid}`
    name: String,
    display_name: String,
    /// None if it was imported.
    capture: Option<String>,
    /// None if it was imported.
    fit: Option<String>,
    create_time: String,
    size_bytes: u64,
    /// BLAKE3 of the twin file, hex.
    digest: String,
    node_count: u32,
    spring_count: u32,
    triplet_count: u32,
    control_count: u32,
    fps: f64,
    substeps: u32,
    /// Mass of the object [kg]; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    mass_kg: Option<f64>,
    /// The quality table.
    #[schema(value_type = Object)]
    quality: Box<RawValue>,
    /// Text that people write about it.
    note: String,
    tags: Vec<String>,
    /// Owner of the key with which it was made; empty if that is not known.
    owner: String,
    /// Error over frames that it was not fitted to [m]: of tracks, else of coordinates, else the
    /// Chamfer distance.
    error_m: Option<f64>,
}

impl From<store::Twin> for Twin {
    fn from(twin: store::Twin) -> Self {
        let (facts, labels) = (twin.facts, twin.labels);
        Self {
            name: twin.id.to_string(),
            display_name: labels.display_name,
            note: labels.note,
            tags: labels.tags,
            error_m: twin.error_m,
            owner: twin.owner,
            capture: twin.capture.map(|c| c.to_string()),
            fit: twin.fit.map(|f| f.to_string()),
            create_time: twin.created.to_string(),
            size_bytes: twin.size_bytes,
            digest: twin.digest.to_hex().to_string(),
            node_count: facts.node_count,
            spring_count: facts.spring_count,
            triplet_count: facts.triplet_count,
            control_count: facts.control_count,
            fps: facts.fps,
            substeps: facts.substeps,
            mass_kg: facts.mass_kg,
            quality: raw(facts.quality),
        }
    }
}

/// A page of twins, newest first unless another order was asked for.
#[derive(Serialize, ToSchema)]
pub(super) struct Twins {
    pub(super) twins: Vec<Twin>,
    /// Empty on the last page.
    pub(super) next_page_token: String,
}

/// A worker process.
#[derive(Serialize, ToSchema)]
pub(super) struct Worker {
    /// `workers/{uuid}`
    name: String,
    /// cpu or cuda.
    backend: String,
    device: String,
    start_time: String,
    last_seen_time: String,
    /// `fits/{uuid}` under way.
    fit: Option<String>,
    /// `captures/{uuid}` whose ingest is under way.
    ingest: Option<String>,
    /// Twins that are loaded and answer at once.
    warm_twins: Vec<String>,
    rollouts_in_flight: u32,
    build: String,
    /// Memory of its device in use by all processes, and in total [bytes]; absent if unknown.
    memory_used_bytes: Option<u64>,
    memory_total_bytes: Option<u64>,
    /// Words that it was started with, which fits can ask for.
    labels: Vec<String>,
    /// True if it was asked to end.
    draining: bool,
    /// `servers/{uuid}` of the server that started it, and whose rollouts alone it answers.
    server: Option<String>,
}

impl From<WorkerView> for Worker {
    fn from(view: WorkerView) -> Self {
        let registration = view.worker.registration;
        Self {
            name: registration.id.to_string(),
            backend: registration.backend,
            device: registration.device,
            start_time: view.worker.started.to_string(),
            last_seen_time: view.last_seen.to_string(),
            fit: view.fit.map(|f: ids::FitId| f.to_string()),
            ingest: view.ingest.map(|c| c.to_string()),
            warm_twins: view.warm.iter().map(ToString::to_string).collect(),
            rollouts_in_flight: view.in_flight,
            build: registration.build,
            memory_used_bytes: view.memory.map(|m| m.used),
            memory_total_bytes: view.memory.map(|m| m.total),
            labels: registration.labels,
            draining: view.worker.is_draining,
            server: registration.server.map(|s| s.to_string()),
        }
    }
}

/// All workers, newest first.
#[derive(Serialize, ToSchema)]
pub(super) struct Workers {
    pub(super) workers: Vec<Worker>,
    /// Always empty: workers are few.
    pub(super) next_page_token: String,
}

/// Selection of a page.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct Paging {
    /// 0 means 50; more than 1000 counts as 1000.
    #[serde(default)]
    page_size: u32,
    /// `next_page_token` of the previous page.
    #[serde(default)]
    page_token: String,
}

impl From<Paging> for store::PageRequest {
    fn from(paging: Paging) -> Self {
        Self { size: paging.page_size, token: paging.page_token }
    }
}

/// The name of an upload.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct UploadParams {
    /// Display name.
    #[serde(default)]
    pub(super) display_name: String,
    /// BLAKE3 of the body, hex; checked. Headers may give it instead.
    #[serde(default)]
    pub(super) digest: String,
}

/// The name of a capture, and the settings for reading it.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct CaptureParams {
    /// Display name.
    #[serde(default)]
    pub(super) display_name: String,
    /// BLAKE3 of the body, hex; checked. Headers may give it instead.
    #[serde(default)]
    pub(super) digest: String,
    /// Settings of the ingest that differ from the defaults, as JSON.
    #[serde(default)]
    pub(super) ingest: String,
    /// Worker that the ingest asks for, as JSON.
    #[serde(default)]
    pub(super) ingest_requirements: String,
}

/// Stored JSON as it is; null if it is none.
pub(super) fn raw(json: String) -> Box<RawValue> {
    RawValue::from_string(json).unwrap_or_else(|_| RawValue::NULL.to_owned())
}

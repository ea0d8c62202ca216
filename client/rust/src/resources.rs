//! The server's resources as Rust types.

pub(crate) mod value;

use bendtwin_core::{
    Fault, Quality,
    ids::{CaptureId, FitId, TwinId, WorkerId},
    quality::Measure,
};
use bendtwin_proto::v1;
use jiff::Timestamp;
use serde::Serialize;

use crate::{JobProgress, JobState, Requirements};

pub(crate) use value::resource;

resource! { v1::Capture =>
/// A stored capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Capture {
    /// Name of the capture.
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
    /// Who recorded it; empty if that was not stated.
    pub recorded_by: String,
    /// Files that were added after the upload, one of each kind.
    pub supplements: Vec<Supplement>,
    /// True if the last ingest made masks of strokes.
    pub masks: bool,
}
}

resource! { v1::Supplement =>
/// A file that was added to a capture, which ingests read beside the archive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Supplement {
    /// `masks` or `calibration`.
    pub kind: String,
    /// Size of the file [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of the file, hex.
    pub digest: String,
    /// Time of storage.
    pub create_time: Timestamp,
}
}

resource! { v1::Job =>
/// Work that a worker does for a fit, or for the ingest of a capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Job {
    /// State of the job.
    pub state: JobState,
    /// The settings in force.
    pub settings: serde_json::Value = settings_json,
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
    /// Time for which it has run at workers, over all attempts, as of the last report [s].
    pub run_s: f64,
}
}

resource! { v1::Fit =>
/// A fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Name of the fit.
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
    /// Kind of that error, if it is known.
    pub measure: Option<Measure>,
    /// Worker that it asks for.
    pub requirements: Requirements,
}
}

resource! { v1::Twin =>
/// A stored twin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Twin {
    /// Name of the twin.
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
    pub quality: Quality = quality_json,
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
}

resource! { v1::Worker =>
/// A worker process.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Worker {
    /// Name of the worker, new after a restart.
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
    /// Twins that are loaded and answer immediately.
    pub warm_twins: Vec<TwinId>,
    /// Number of rollouts under way.
    pub rollouts_in_flight: u32,
    /// Version of its software.
    pub build: String,
    /// Memory of its device, if known.
    pub memory: Option<DeviceMemory> = memory_used_bytes, memory_total_bytes,
    /// Words that it was started with, which fits can ask for.
    pub labels: Vec<String>,
    /// True if it was asked to end.
    pub draining: bool,
    /// `servers/{uuid}` of the server that started it and whose rollouts alone it answers.
    pub server: Option<String>,
}
}

/// Memory of a worker's device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceMemory {
    /// In use by all processes [bytes].
    pub used_bytes: u64,
    /// In total [bytes].
    pub total_bytes: u64,
}

/// Requirements as a field of a message; none if any worker will do.
pub(crate) fn if_any(requirements: &Requirements) -> Option<Requirements> {
    (!are_none(requirements)).then(|| requirements.clone())
}

/// True if any worker will do.
pub(crate) fn are_none(requirements: &Requirements) -> bool {
    *requirements == Requirements::default()
}

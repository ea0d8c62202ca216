//! An ingest job from lease to observation, masks, playback and report. Captures are untrusted files, so
//! each is read in a separate process, confined and under limits of memory and time: a crash of
//! that process harms neither worker nor server.
//!
//! ```text
//!   server ◄── lease, progress, checkpoints, result ──► worker ◄── lines, files ──► child
//! ```
//!
//! [`protocol`] defines the messages between the two, `child` is the worker's side, `process` the
//! child's with its [`sandbox`], and [`bendtwin_ingest::ingest()`] the work itself; `deliver` takes the result to the
//! server.

mod child;
mod deliver;
mod process;
mod protocol;
mod sandbox;

use std::{io, path::PathBuf, time::Duration};

use bendtwin_core::{Category, Fault, Problem as _, settings::ingest::IngestSettings};
use bendtwin_proto::worker::v1::lease_job_request::Kind;
use tempfile::{NamedTempFile, TempDir};
use tokio_util::sync::CancellationToken;

use self::{
    child::Child,
    protocol::{
        ARCHIVE, CHECKPOINT, EARLIER_MASKS, Request, SUPPLEMENT_CALIBRATION, SUPPLEMENT_MASKS,
    },
};
pub use self::{
    process::ingest_capture,
    sandbox::{Enforced, Layer, Resources, Sandbox, available, confine},
};
use crate::{
    job::{Attempt, LeasedJob, stop::Reason},
    leasing::Execute,
};

/// Bytes of input for which the child gets another second.
const BYTES_PER_SECOND: u64 = 1 << 20;

/// Executor of ingest jobs.
#[derive(Clone)]
pub(crate) struct Ingests {
    /// Folder for captures while they are read.
    pub(crate) dir: PathBuf,
    /// The program whose command `ingest-capture` reads them.
    pub(crate) program: PathBuf,
    /// Memory that the child may take [bytes].
    pub(crate) memory_bytes: u64,
    /// Time that it may take, beside that for the size of its input.
    pub(crate) time: Duration,
    /// Demand on its confinement.
    pub(crate) sandbox: Sandbox,
    /// Time for which a result is kept while the server cannot be reached.
    pub(crate) delivery_timeout: Duration,
}

impl Execute for Ingests {
    const KIND: Kind = Kind::Ingest;

    async fn execute(&self, job: LeasedJob, drain: &CancellationToken) {
        tracing::info!(resumed = job.has_checkpoint(), "ingest leased");
        let mut attempt = Attempt::begin(job, drain, self.delivery_timeout);
        let work = async {
            let (folder, time) = self.prepare(&attempt.job).await?;
            let child = Child { program: &self.program, folder: folder.path(), time };
            let ended = child.run(&attempt.progress, &attempt.checkpoints).await?;
            Ok::<_, Fault>((folder, ended))
        };
        let outcome = tokio::select! {
            outcome = work => outcome,
            // Dropping the work kills the child.
            () = attempt.stop.stopped() => Err(stopped()),
        };
        match (outcome, attempt.stop.reason()) {
            (_, Some(Reason::Stale)) => {
                tracing::warn!("the job is gone, or another worker has it");
            }
            (Err(fault), _) => attempt.fail_unfinished("ingest", fault).await,
            // A finished result is delivered even if the job was asked to stop meanwhile.
            (Ok((folder, ended)), _) => {
                attempt.drop_checkpoint();
                deliver::deliver(&attempt, folder.path(), ended).await;
            }
        }
    }
}

impl Ingests {
    /// Prepares a folder for the child: archive, supplements, earlier masks, checkpoint and request.
    /// Also returns the time that the child may take.
    async fn prepare(&self, job: &LeasedJob) -> Result<(TempDir, Duration), Fault> {
        let disk = |source: std::io::Error| Fault {
            category: Category::ResourceExhausted,
            reason: "NO_DISK_SPACE".to_owned(),
            message: format!("the worker has no room for the capture: {source}"),
        };
        let folder =
            tempfile::Builder::new().prefix("ingest-").tempdir_in(&self.dir).map_err(disk)?;
        let keep = |file: NamedTempFile, name: &str| -> io::Result<u64> {
            Ok(file.persist(folder.path().join(name))?.metadata()?.len())
        };
        let archive = job.fetch_capture(folder.path()).await.map_err(|e| e.fault())?;
        let mut bytes = keep(archive, ARCHIVE).map_err(disk)?;
        for kind in job.supplements() {
            let Some(name) = supplement_name(kind) else { return Err(unknown_supplement(kind)) };
            let file = job.fetch_supplement(kind, folder.path()).await.map_err(|e| e.fault())?;
            bytes += keep(file, name).map_err(disk)?;
        }
        if has_strokes(job.settings_json()) {
            let masks = job.fetch_masks(folder.path()).await.map_err(|e| e.fault())?;
            if let Some(masks) = masks {
                bytes += keep(masks, EARLIER_MASKS).map_err(disk)?;
            }
        }
        let time = self.time + Duration::from_secs(bytes / BYTES_PER_SECOND);
        let checkpoint = job.fetch_checkpoint().await.map_err(|e| e.fault())?;
        if let Some(checkpoint) = checkpoint {
            std::fs::write(folder.path().join(CHECKPOINT), checkpoint).map_err(disk)?;
        }
        let request = Request {
            name: job.capture_display_name().to_owned(),
            settings: job.settings_json().to_owned(),
            resources: Resources {
                memory_bytes: self.memory_bytes,
                // More than that passes only if the worker did not end it in time.
                processor_s: time.as_secs().saturating_mul(child::threads() as u64),
                file_bytes: self.memory_bytes.saturating_mul(2),
            },
            sandbox: self.sandbox,
        };
        request.write(folder.path()).map_err(disk)?;
        Ok((folder, time))
    }
}

/// Name of the file that the child reads a supplement from.
fn supplement_name(kind: &str) -> Option<&'static str> {
    match kind {
        "masks" => Some(SUPPLEMENT_MASKS),
        "calibration" => Some(SUPPLEMENT_CALIBRATION),
        _ => None,
    }
}

/// The fault of an input that a newer server knows. To read the capture without it would be wrong.
fn unknown_supplement(kind: &str) -> Fault {
    Fault {
        category: Category::Unavailable,
        reason: "SUPPLEMENT_UNKNOWN".to_owned(),
        message: format!(
            "this worker is older than the server and does not know the supplement `{kind}`: start \
             workers of the server's version"
        ),
    }
}

/// True if masks are to be made of strokes. The child reports settings that cannot be read.
fn has_strokes(settings_json: &str) -> bool {
    serde_json::from_str::<IngestSettings>(settings_json)
        .is_ok_and(|settings| !settings.strokes.is_empty())
}

fn stopped() -> Fault {
    bendtwin_ingest::Error::Cancelled.fault()
}

#[cfg(test)]
mod tests;

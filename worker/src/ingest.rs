//! An ingest job from lease to observation, masks, playback and report. Captures are untrusted files, so
//! each is read in a separate process, confined and under limits of memory and time: a crash of
//! that process harms neither worker nor server.
//!
//! ```text
//!   server ◄── lease, progress, checkpoints, result ──► worker ◄── lines, files ──► child
//! ```
//!
//! A worker has two seats for them. The first takes any ingest. The second is open while the first is taken, and
//! takes those that are not known to take long, for a few seconds each: what takes longer is handed back, and
//! waits for a first seat. So a small capture waits seconds for a long one, and not its end.
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
use tokio::sync::watch;
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
    options::LEAST_INGEST_BYTES,
};

/// Bytes of input for which the child gets another second.
const BYTES_PER_SECOND: u64 = 1 << 20;

/// Part of the memory of a reader that one in the second seat may take.
const BRIEF_MEMORY_SHARE: u64 = 4;
/// Longest wait for a brief job in one call: afterwards the first seat may be free.
const BRIEF_WAIT: Duration = Duration::from_secs(2);

/// Executor of ingest jobs in the first seat.
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
    /// True while a job is executed.
    pub(crate) taken: watch::Sender<bool>,
}

/// Executor of ingest jobs in the second seat.
pub(crate) struct BriefIngests {
    /// The executor in the first seat.
    pub(crate) first: Ingests,
    /// Time that a job may take.
    pub(crate) time: Duration,
}

impl Execute for Ingests {
    const KIND: Kind = Kind::Ingest;

    async fn execute(&self, job: LeasedJob, drain: &CancellationToken) {
        self.taken.send_replace(true);
        let _taken = Taken(&self.taken);
        self.run(job, drain, None).await;
    }
}

/// The first seat, which is free when this is dropped.
struct Taken<'a>(&'a watch::Sender<bool>);

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        self.0.send_replace(false);
    }
}

impl Execute for BriefIngests {
    const KIND: Kind = Kind::Ingest;
    const BRIEF: bool = true;
    const WAIT: Duration = BRIEF_WAIT;

    async fn until_open(&self) {
        // The sender is here as well, so it is not gone.
        let _ = self.first.taken.subscribe().wait_for(|taken| *taken).await;
    }

    async fn execute(&self, job: LeasedJob, drain: &CancellationToken) {
        // A server of an older version leases any job, and takes none back as outgrown.
        let longest = job.is_brief().then_some(self.time);
        self.first.run(job, drain, longest).await;
    }
}

impl Ingests {
    /// Works on a job until it has ended, here or elsewhere; on a brief one for a limited time and with less
    /// memory.
    async fn run(&self, job: LeasedJob, drain: &CancellationToken, longest: Option<Duration>) {
        tracing::info!(resumed = job.has_checkpoint(), brief = longest.is_some(), "ingest leased");
        let mut attempt = Attempt::begin(job, drain, self.delivery_timeout);
        let memory_bytes = match longest {
            Some(_) => self.memory_bytes / BRIEF_MEMORY_SHARE,
            None => self.memory_bytes,
        };
        let memory_bytes = memory_bytes.max(LEAST_INGEST_BYTES);
        let work = async {
            let (folder, time) = self.prepare(&attempt.job, memory_bytes).await?;
            let child = Child { program: &self.program, folder: folder.path(), time };
            let ended = child.run(&attempt.progress, &attempt.checkpoints).await?;
            Ok::<_, Fault>((folder, ended))
        };
        let outgrown = async {
            match longest {
                Some(longest) => tokio::time::sleep(longest).await,
                None => std::future::pending().await,
            }
        };
        let outcome = tokio::select! {
            outcome = work => outcome.map(Some),
            // Dropping the work kills the child.
            () = attempt.stop.stopped() => Err(stopped()),
            () = outgrown => Ok(None),
        };
        match (outcome, attempt.stop.reason()) {
            (_, Some(Reason::Stale)) => {
                tracing::warn!("the job is gone, or another worker has it");
            }
            (Err(fault), _) => attempt.fail_unfinished("ingest", fault).await,
            (Ok(None), _) => attempt.hand_on(stopped()).await,
            (Ok(Some((_, ended))), None) if longest.is_some() && ended.may_lack_memory() => {
                attempt.hand_on(stopped()).await;
            }
            // A finished result is delivered even if the job was asked to stop meanwhile.
            (Ok(Some((folder, ended))), _) => {
                attempt.drop_checkpoint();
                deliver::deliver(&attempt, folder.path(), ended).await;
            }
        }
    }

    /// Prepares a folder for the child: archive, supplements, earlier masks, checkpoint and request.
    /// Also returns the time that the child may take.
    async fn prepare(
        &self,
        job: &LeasedJob,
        memory_bytes: u64,
    ) -> Result<(TempDir, Duration), Fault> {
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
                memory_bytes,
                // More than that passes only if the worker did not end it in time.
                processor_s: time.as_secs().saturating_mul(child::threads() as u64),
                file_bytes: memory_bytes.saturating_mul(2),
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

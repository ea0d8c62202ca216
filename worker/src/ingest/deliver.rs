//! Delivery of an ingest's result: streamed from files, and repeated until the server has
//! acknowledged it.

use std::path::{Path, PathBuf};

use bendtwin_core::{Category, Fault};
use bendtwin_ingest::unread;
use bendtwin_inspect::Verdict;
use bendtwin_proto::worker::v1::{EndIngestRequest, IngestWrite, end_ingest_request::Part};
use bytes::Bytes;
use futures::{Stream, StreamExt as _, stream};
use tokio_util::io::ReaderStream;

use super::{
    child::ChildOutcome,
    process::write_report,
    protocol::{OBSERVATION, PAGE, PLAYBACK, REPORT, open_result},
};
use crate::{
    job::{
        Attempt, LeasedJob,
        deliver::{Failure, Undelivered},
    },
    server_client::CallError,
};

/// Bytes of one chunk: large enough to be cheap, well below any message limit.
const CHUNK: usize = 256 << 10;

/// Sends the results in the folder, which ends the job.
pub(super) async fn deliver(attempt: &Attempt<'_>, folder: &Path, ended: ChildOutcome) {
    let (verdict, fault) = match ended {
        ChildOutcome::Observed { verdict } | ChildOutcome::Masked { verdict } => (verdict, None),
        ChildOutcome::Refused { verdict, fault } => (verdict, Some(fault)),
        ChildOutcome::Exceeded { fault } => {
            // The child could not write a report.
            let report = unread(attempt.job.capture_display_name(), &fault).report;
            if let Err(error) = write_report(folder, &report) {
                tracing::warn!(%error, "no report can be written");
                return attempt.fail(fault, Failure::Permanent).await;
            }
            (Verdict::Unusable, Some(fault))
        }
    };
    if let Some(fault) = &fault {
        tracing::warn!(reason = fault.reason, "the capture cannot be fitted: {fault}");
    }
    let made = match measure(&attempt.job, folder, verdict, fault).await {
        Ok(made) => made,
        Err(error) => {
            return attempt.fail(unreadable(&error), Failure::Passing).await;
        }
    };
    let parts = parts(folder, made.fault.is_none());
    match attempt
        .send_until_acknowledged("what the ingest made", || send(&attempt.job, &made, &parts))
        .await
    {
        Ok(()) => tracing::info!(verdict = made.verdict, "ingest ended"),
        // Too large, for example: another attempt would have the same result and be refused, too.
        Err(Undelivered::Refused(fault)) if fault.category == Category::InvalidArgument => {
            attempt.fail(fault, Failure::Permanent).await;
        }
        Err(_) => {}
    }
}

type Wrap = fn(Bytes) -> Part;

/// The files of a result, in the order in which they are sent.
fn parts(folder: &Path, observed: bool) -> Vec<(PathBuf, Wrap)> {
    let seen: [(&str, Wrap); 2] = [(OBSERVATION, Part::Observation), (PLAYBACK, Part::Playback)];
    let reports: [(&str, Wrap); 2] = [(REPORT, Part::Report), (PAGE, Part::Page)];
    let parts = seen.into_iter().filter(|_| observed).chain(reports);
    parts.map(|(file, wrap)| (folder.join(file), wrap)).collect()
}

async fn measure(
    job: &LeasedJob,
    folder: &Path,
    verdict: Verdict,
    fault: Option<Fault>,
) -> std::io::Result<IngestWrite> {
    let (write, folder) = (job.write(), folder.to_owned());
    let measured = tokio::task::spawn_blocking(move || {
        let digest = |file: &str| -> std::io::Result<String> {
            let mut hasher = blake3::Hasher::new();
            hasher.update_reader(open_result(&folder.join(file))?)?;
            Ok(hasher.finalize().to_hex().to_string())
        };
        let of_seen = |file: &str| match fault {
            None => digest(file),
            Some(_) => Ok(String::new()),
        };
        Ok(IngestWrite {
            job: Some(write),
            verdict: verdict_name(verdict).to_owned(),
            observation_digest: of_seen(OBSERVATION)?,
            playback_digest: of_seen(PLAYBACK)?,
            report_digest: digest(REPORT)?,
            page_digest: digest(PAGE)?,
            fault: fault.as_ref().map(Into::into),
        })
    });
    measured.await.map_err(std::io::Error::other)?
}

async fn send(
    job: &LeasedJob,
    made: &IngestWrite,
    parts: &[(PathBuf, Wrap)],
) -> Result<(), CallError> {
    let mut files = Vec::with_capacity(parts.len());
    for (path, wrap) in parts {
        let file = open_result(path).map_err(|e| CallError::Unavailable(unreadable(&e)))?;
        files.push((tokio::fs::File::from_std(file), *wrap));
    }
    job.server().end_ingest(messages(made.clone(), files)).await
}

/// Metadata, then each file. A file that cannot be read any more cuts the upload short, which the
/// digest reveals.
fn messages(
    made: IngestWrite,
    files: Vec<(tokio::fs::File, Wrap)>,
) -> impl Stream<Item = EndIngestRequest> + Send + 'static {
    let chunks = stream::iter(files).flat_map(|(file, wrap)| {
        let chunks = ReaderStream::with_capacity(file, CHUNK);
        chunks.filter_map(move |chunk| std::future::ready(chunk.ok().map(wrap)))
    });
    let first = stream::once(std::future::ready(Part::Metadata(made)));
    first.chain(chunks).map(|part| EndIngestRequest { part: Some(part) })
}

fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::Usable => "usable",
        Verdict::Unusable => "unusable",
    }
}

fn unreadable(error: &std::io::Error) -> Fault {
    Fault {
        category: Category::Unavailable,
        reason: "INGEST_RESULT_LOST".to_owned(),
        message: format!("what the ingest made cannot be read any more: {error}"),
    }
}

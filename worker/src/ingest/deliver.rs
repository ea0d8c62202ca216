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
    protocol::{MASKS, OBSERVATION, PAGE, PLAYBACK, REPORT, open_result},
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
    let files = match &ended {
        ChildOutcome::Observed { .. } => Files { observed: true, completed: true },
        ChildOutcome::Masked { .. } | ChildOutcome::Refused { .. } => {
            Files { observed: false, completed: true }
        }
        ChildOutcome::Exceeded { .. } => Files { observed: false, completed: false },
    };
    let masks_only = matches!(ended, ChildOutcome::Masked { .. });
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
    let end = IngestWrite {
        job: Some(attempt.job.write()),
        verdict: verdict_name(verdict).to_owned(),
        fault: fault.as_ref().map(Into::into),
        masks_only,
        ..IngestWrite::default()
    };
    let (made, parts) = match measure(end, folder, files).await {
        Ok(measured) => measured,
        Err(error) => {
            return attempt.fail(unreadable(&error), Failure::Passing).await;
        }
    };
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

/// Files that a child left beside the report.
#[derive(Clone, Copy)]
struct Files {
    /// True if there is an observation, with a playback.
    observed: bool,
    /// True if the child came to its end: a playback and masks are whole, if they are there.
    completed: bool,
}

/// The end of an ingest with the digests of all files that are there, and these files in the order in
/// which they are sent.
async fn measure(
    mut made: IngestWrite,
    folder: &Path,
    files: Files,
) -> std::io::Result<(IngestWrite, Vec<(PathBuf, Wrap)>)> {
    let folder = folder.to_owned();
    let measured = tokio::task::spawn_blocking(move || {
        let mut parts: Vec<(PathBuf, Wrap)> = Vec::new();
        let mut part = |file: &str, wrap: Wrap| -> std::io::Result<String> {
            let path = folder.join(file);
            let mut hasher = blake3::Hasher::new();
            hasher.update_reader(open_result(&path)?)?;
            parts.push((path, wrap));
            Ok(hasher.finalize().to_hex().to_string())
        };
        if files.observed {
            made.observation_digest = part(OBSERVATION, Part::Observation)?;
        }
        let mut if_there = |file: &str, wrap: Wrap| match part(file, wrap) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
            measured => measured,
        };
        if files.completed {
            made.playback_digest = if_there(PLAYBACK, Part::Playback)?;
            made.masks_digest = if_there(MASKS, Part::Masks)?;
        }
        made.report_digest = part(REPORT, Part::Report)?;
        made.page_digest = part(PAGE, Part::Page)?;
        Ok((made, parts))
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

//! Results of workers, checked before they are stored. A worker holds a token, and what it sends
//! goes to users and to other workers: twins are decoded, reports, observations, playbacks and masks
//! are what their headers should say.

use bendtwin_core::{
    Twin as TwinFile,
    capture_files::{OBSERVATION_MARKER, PLAYBACK_MAGIC, REPORT_FORMAT},
};
use bendtwin_store::{Staged, TwinFacts};
use serde::Deserialize;

use crate::app::{App, Error, Result};

/// First bytes of an entry of a ZIP archive.
const ENTRY: &[u8] = b"PK\x03\x04";
/// Bytes of such an entry before its name, and where the length of the name stands.
const ENTRY_HEAD: usize = 30;
const NAME_LENGTH: std::ops::Range<usize> = 26..28;

impl App {
    /// Decodes and checks a twin file. Returns the facts that listings show.
    pub(in crate::app) async fn check_twin(&self, content: &Staged) -> Result<TwinFacts> {
        // Only when it is whole, so that a slow upload holds no memory.
        let share = self.memory.twin_file(content.size_bytes()).await?;
        let bytes = content.bytes().await?;
        tokio::task::spawn_blocking(move || {
            let _share = share;
            TwinFile::decode(&bytes).map_err(Error::from).and_then(|twin| facts(&twin))
        })
        .await
        .map_err(|e| Error::Internal(format!("reading a twin file: {e}")))?
    }

    /// Checks that a report is one, and that it has this verdict.
    pub(in crate::app) async fn check_report(&self, content: &Staged, verdict: &str) -> Result<()> {
        let unsound = |fault: String| Error::Unsound { what: "a report", fault };
        let share = self.memory.report(content.size_bytes()).await?;
        let bytes = content.bytes().await?;
        let read = tokio::task::spawn_blocking(move || {
            let _share = share;
            serde_json::from_slice(&bytes)
        });
        let read = read.await.map_err(|e| Error::Internal(format!("reading a report: {e}")))?;
        let head: ReportHead = read.map_err(|e| unsound(e.to_string()))?;
        if head.format != REPORT_FORMAT || head.version == 0 {
            return Err(unsound(format!("its format is `{}` {}", head.format, head.version)));
        }
        if head.verdict != verdict {
            return Err(unsound(format!("its verdict is `{}`, not `{verdict}`", head.verdict)));
        }
        Ok(())
    }
}

/// Refuses a twin that is not what its worker says it is.
pub(in crate::app) fn compare_facts(said: &TwinFacts, found: &TwinFacts) -> Result<()> {
    let of = |f: &TwinFacts| {
        let counts = [f.node_count, f.spring_count, f.triplet_count, f.control_count, f.substeps];
        (counts, f.fps.to_bits())
    };
    if of(said) == of(found) {
        return Ok(());
    }
    let fault = format!("it has {found:?}, not {said:?}");
    Err(Error::Unsound { what: "a twin", fault })
}

/// The head of a report: the rest is for its readers.
#[derive(Deserialize)]
struct ReportHead {
    format: String,
    version: u32,
    verdict: String,
}

/// Checks that an observation begins like a capture bundle. Workers check the rest when they read
/// it: the server does not know captures.
pub(in crate::app) async fn check_observation(content: &Staged) -> Result<()> {
    let head = content.head((ENTRY_HEAD + OBSERVATION_MARKER.len()) as u64).await?;
    let length = head.get(NAME_LENGTH).and_then(|b| b.try_into().ok()).map(u16::from_le_bytes);
    let sound = head.starts_with(ENTRY)
        && length.map(usize::from) == Some(OBSERVATION_MARKER.len())
        && head.get(ENTRY_HEAD..) == Some(OBSERVATION_MARKER.as_bytes());
    if sound {
        return Ok(());
    }
    let fault = format!("it does not begin with `{OBSERVATION_MARKER}`");
    Err(Error::Unsound { what: "an observation", fault })
}

/// Checks that a playback begins like one. It is for browsers: no program here reads it.
pub(in crate::app) async fn check_playback(content: &Staged) -> Result<()> {
    if content.head(PLAYBACK_MAGIC.len() as u64).await?.starts_with(PLAYBACK_MAGIC) {
        return Ok(());
    }
    let fault = "it does not begin like one".to_owned();
    Err(Error::Unsound { what: "a playback", fault })
}

/// Checks that masks begin like an archive. Workers check the rest when they read them.
pub(in crate::app) async fn check_masks(content: &Staged) -> Result<()> {
    if content.head(ENTRY.len() as u64).await?.starts_with(ENTRY) {
        return Ok(());
    }
    let fault = "they do not begin like an archive".to_owned();
    Err(Error::Unsound { what: "masks", fault })
}

/// The facts of a twin that listings show.
fn facts(twin: &TwinFile) -> Result<TwinFacts> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Ok(TwinFacts {
        node_count: count(twin.graph.node_count()),
        spring_count: count(twin.graph.springs.len()),
        triplet_count: count(twin.graph.triplets.len()),
        control_count: count(twin.graph.control_count()),
        fps: twin.timing.fps,
        substeps: twin.timing.substeps,
        quality: serde_json::to_string(&twin.quality)
            .map_err(|e| Error::Internal(e.to_string()))?,
        mass_kg: twin.mass_kg,
        skin_point_count: Some(count(twin.skin.len())),
    })
}

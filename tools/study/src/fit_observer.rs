//! Observer of a fit: forwards its progress, records its losses, and keeps its checkpoints in the
//! folder, so that the fit can continue after any interruption.

use std::time::{Duration, Instant};

use bendtwin_core::{Observer, ObserverError, Progress, Stage};
use serde::{Deserialize, Serialize};

use crate::{folder::Folder, record::Losses, suite::RunId};

/// Header before a fit's own checkpoint, as a line of JSON.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    /// Digest of the run that it belongs to.
    digest: String,
    /// Time spent until then [s].
    spent_s: f64,
    losses: Losses,
}

/// The point from which an interrupted fit continues.
#[derive(Debug, Default)]
pub(crate) struct Resumption {
    /// Checkpoint of the fit; `None` if it starts from the beginning.
    pub(crate) checkpoint: Option<Vec<u8>>,
    spent_s: f64,
    losses: Losses,
}

impl Resumption {
    /// The last checkpoint of a run in the folder; the default without one.
    pub(crate) fn find(folder: &Folder, id: &RunId, digest: &str) -> Self {
        let read = || {
            let mut bytes = folder.checkpoint(id)?;
            let end = bytes.iter().position(|b| *b == b'\n')?;
            let header: Header = serde_json::from_slice(&bytes[..end]).ok()?;
            let checkpoint = bytes.split_off(end + 1);
            (header.digest == digest).then_some(Self {
                checkpoint: Some(checkpoint),
                spent_s: header.spent_s,
                losses: header.losses,
            })
        };
        read().unwrap_or_default()
    }
}

/// Observer of one fit.
pub(crate) struct FitObserver<'a> {
    folder: &'a Folder,
    id: &'a RunId,
    digest: &'a str,
    every: Duration,
    tell: &'a dyn Fn(Progress),
    began: Instant,
    spent_before_s: f64,
    losses: Losses,
    written: Instant,
    /// Stage and iteration of the last report.
    last: Option<(Stage, u32)>,
    /// The last checkpoint. It is written when the next one comes, since the losses of its
    /// iteration are reported after it.
    pending: Option<Vec<u8>>,
}

impl<'a> FitObserver<'a> {
    pub(crate) fn new(
        folder: &'a Folder,
        (id, digest): (&'a RunId, &'a str),
        from: &Resumption,
        every: Duration,
        tell: &'a dyn Fn(Progress),
    ) -> Self {
        let now = Instant::now();
        Self {
            folder,
            id,
            digest,
            every,
            tell,
            began: now,
            spent_before_s: from.spent_s,
            losses: from.losses,
            written: now,
            last: None,
            pending: None,
        }
    }

    pub(crate) fn losses(&self) -> Losses {
        self.losses
    }

    /// The lowest loss of an iteration, which every start of the fit reports in turn.
    fn lowest(&self, progress: &Progress, so_far: Option<f64>) -> Option<f64> {
        let is_same = self.last == Some((progress.stage, progress.iteration));
        let others = so_far.filter(|_| is_same);
        progress.best_loss.into_iter().chain(others).reduce(f64::min)
    }

    /// Time spent on the run in all [s].
    pub(crate) fn spent_s(&self) -> f64 {
        self.spent_before_s + self.began.elapsed().as_secs_f64()
    }

    /// Writes the last checkpoint, if it is not written yet.
    pub(crate) fn flush(&mut self) -> Result<(), ObserverError> {
        let Some(checkpoint) = self.pending.take() else { return Ok(()) };
        let header =
            Header { digest: self.digest.to_owned(), spent_s: self.spent_s(), losses: self.losses };
        let mut bytes = serde_json::to_vec(&header)?;
        bytes.push(b'\n');
        bytes.extend(checkpoint);
        self.folder.write_checkpoint(self.id, &bytes)?;
        self.written = Instant::now();
        Ok(())
    }
}

impl Observer<Progress> for FitObserver<'_> {
    fn progress(&mut self, progress: Progress) {
        match progress.stage {
            Stage::Search => self.losses.search = self.lowest(&progress, self.losses.search),
            Stage::Refine => self.losses.refine = self.lowest(&progress, self.losses.refine),
            Stage::Ingest | Stage::Evaluate | Stage::Appearance => {}
        }
        self.last = Some((progress.stage, progress.iteration));
        (self.tell)(progress);
    }

    fn checkpoint(&mut self, checkpoint: Vec<u8>) -> Result<(), ObserverError> {
        if self.written.elapsed() >= self.every {
            self.flush()?;
        }
        self.pending = Some(checkpoint);
        Ok(())
    }
}

//! One run: a fit with its evaluation, and the record of it.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
    time::Duration,
};

use bendtwin_core::{
    CancelToken, Capture, Category, Fault, FitSettings, Problem, Progress, error::panic_text,
};
use bendtwin_engine::{Backend, Model, stable_substeps};
use bendtwin_fit::{Error as FitError, FitJob, Outcome as Fitted};

use crate::{
    Error, command,
    folder::Folder,
    keeper::{Keeper, Resumption},
    plan::Source,
    record::{Finished, GraphCounts, Outcome, Record, VERSION},
    suite::RunId,
};

/// A run that is to be done.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    pub(crate) id: RunId,
    pub(crate) settings: FitSettings,
    pub(crate) source: Arc<Source>,
    pub(crate) build: String,
    pub(crate) digest: String,
}

/// Where a run happens.
pub(crate) struct Site<'a> {
    pub(crate) folder: &'a Folder,
    pub(crate) backend: &'a Arc<dyn Backend>,
    pub(crate) checkpoint_every: Duration,
    pub(crate) cancel: &'a CancelToken,
}

/// How a run ended.
pub(crate) enum End {
    /// The record is written.
    Recorded(Box<Record>),
    /// It goes on from its checkpoint the next time.
    Interrupted,
}

impl Work {
    /// Whether the folder has a checkpoint to go on from.
    pub(crate) fn is_begun(&self, folder: &Folder) -> bool {
        Resumption::find(folder, &self.id, &self.digest).checkpoint.is_some()
    }

    /// Runs and records.
    pub(crate) fn run(&self, site: &Site<'_>, tell: &dyn Fn(Progress)) -> Result<End, Error> {
        let outcome = match &self.source.capture {
            Ok(capture) => match self.fit(capture, site, tell)? {
                Some(outcome) => outcome,
                None => return Ok(End::Interrupted),
            },
            Err(fault) => Outcome::Failed(fault.clone()),
        };
        let device = site.backend.device();
        let record = Record {
            version: VERSION,
            run: self.id.clone(),
            digest: self.digest.clone(),
            capture_digest: self.source.digest.clone(),
            settings: self.settings.clone(),
            build: self.build.clone(),
            command: command::of_run(&self.source.path, &self.settings, &device.kind),
            backend: device.kind,
            device: device.name,
            outcome,
        };
        site.folder.write_record(&record)?;
        // What may go better the next time goes on from where it was.
        if record.is_final() {
            site.folder.remove_checkpoint(&self.id);
        }
        Ok(End::Recorded(Box::new(record)))
    }

    /// `None` if it was cancelled.
    fn fit(
        &self,
        capture: &Capture,
        site: &Site<'_>,
        tell: &dyn Fn(Progress),
    ) -> Result<Option<Outcome>, Error> {
        let job = FitJob {
            capture,
            capture_digest: self.source.digest.clone(),
            settings: self.settings.clone(),
            backend: site.backend.clone(),
        };
        let mut from = Resumption::find(site.folder, &self.id, &self.digest);
        loop {
            let key = (&self.id, self.digest.as_str());
            let mut keeper = Keeper::new(site.folder, key, &from, site.checkpoint_every, tell);
            let result = catch_unwind(AssertUnwindSafe(|| {
                job.run(from.checkpoint.as_deref(), &mut keeper, site.cancel)
            }));
            let fault = match result {
                Ok(Ok(fitted)) => return self.finish(&fitted, &keeper, site).map(Some),
                // Of another backend, say: the fit starts anew.
                Ok(Err(FitError::OtherCheckpoint | FitError::Checkpoint(_)))
                    if from.checkpoint.is_some() =>
                {
                    from = Resumption::default();
                    continue;
                }
                Ok(Err(error)) if error.category() == Category::Cancelled => {
                    keeper.flush().map_err(|e| Error::Writing(e.to_string()))?;
                    return Ok(None);
                }
                Ok(Err(error)) => error.fault(),
                Err(panic) => Fault {
                    category: Category::Internal,
                    reason: "PANIC".to_owned(),
                    message: format!("a defect of this software: {}", panic_text(&*panic)),
                },
            };
            // A checkpoint that cannot be kept costs time the next time, no more.
            let _ = keeper.flush();
            return Ok(Some(Outcome::Failed(fault)));
        }
    }

    fn finish(
        &self,
        fitted: &Fitted,
        keeper: &Keeper<'_>,
        site: &Site<'_>,
    ) -> Result<Outcome, Error> {
        let twin = &fitted.twin;
        let finished = Finished {
            graph: GraphCounts::from(&twin.graph),
            losses: keeper.losses(),
            substeps: twin.timing.substeps,
            stable_substeps: stable_substeps(&Model::from(twin)).needed,
            quality: twin.quality.clone(),
            fit_s: keeper.spent_s(),
        };
        let bytes = twin.encode().map_err(|e| Error::Writing(format!("{}: {e}", self.id)))?;
        site.folder.write_twin(&self.id, &bytes)?;
        Ok(Outcome::Finished(Box::new(finished)))
    }
}

//! A run: a fit with its evaluation, and the record of it.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
    time::Duration,
};

use bendtwin_core::{
    CancelToken, Capture, Category, Fault, FitSettings, Problem, Progress, error::panic_text,
};
use bendtwin_engine::{Backend, Model, stable_substeps};
use bendtwin_fit::{Error as FitError, FitJob, Look, OpenRasteriser, Outcome as Fitted};

use crate::{
    Error, command,
    fit_observer::{FitObserver, Resumption},
    folder::Folder,
    plan::Source,
    record::{Finished, GraphCounts, Outcome, Record, VERSION},
    suite::RunId,
};

/// A run that is to be done.
#[derive(Clone, Debug)]
pub(crate) struct PendingRun {
    pub(crate) id: RunId,
    pub(crate) settings: FitSettings,
    pub(crate) source: Arc<Source>,
    pub(crate) build: String,
    pub(crate) digest: String,
}

/// The folder, backend and options that a run uses.
pub(crate) struct RunContext<'a> {
    pub(crate) folder: &'a Folder,
    pub(crate) backend: &'a Arc<dyn Backend>,
    pub(crate) rasteriser: &'a OpenRasteriser,
    pub(crate) checkpoint_every: Duration,
    pub(crate) cancel: &'a CancelToken,
}

/// The end of a run.
pub(crate) enum RunEnd {
    /// The record is written.
    Recorded(Box<Record>),
    /// The run was cancelled and continues from its checkpoint the next time.
    Interrupted,
}

impl PendingRun {
    /// True if the folder has a checkpoint to continue from.
    pub(crate) fn is_begun(&self, folder: &Folder) -> bool {
        Resumption::find(folder, &self.id, &self.digest).checkpoint.is_some()
    }

    /// Executes the run and writes its record.
    pub(crate) fn run(
        &self,
        context: &RunContext<'_>,
        tell: &dyn Fn(Progress),
    ) -> Result<RunEnd, Error> {
        let outcome = match &self.source.capture {
            Ok(capture) => match self.fit(capture, context, tell)? {
                Some(outcome) => outcome,
                None => return Ok(RunEnd::Interrupted),
            },
            Err(fault) => Outcome::Failed(fault.clone()),
        };
        let device = context.backend.device();
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
        context.folder.write_record(&record)?;
        // A run that may succeed the next time keeps its checkpoint.
        if record.is_final() {
            context.folder.remove_checkpoint(&self.id);
        }
        Ok(RunEnd::Recorded(Box::new(record)))
    }

    /// `None` if it was cancelled.
    fn fit(
        &self,
        capture: &Capture,
        context: &RunContext<'_>,
        tell: &dyn Fn(Progress),
    ) -> Result<Option<Outcome>, Error> {
        let job = FitJob {
            capture,
            capture_digest: self.source.digest.clone(),
            settings: self.settings.clone(),
            backend: context.backend.clone(),
            look: self
                .source
                .views
                .as_ref()
                .map(|views| Look { views, rasteriser: context.rasteriser.clone() }),
        };
        let mut from = Resumption::find(context.folder, &self.id, &self.digest);
        loop {
            let key = (&self.id, self.digest.as_str());
            let mut observer =
                FitObserver::new(context.folder, key, &from, context.checkpoint_every, tell);
            let result = catch_unwind(AssertUnwindSafe(|| {
                job.run(from.checkpoint.as_deref(), &mut observer, context.cancel)
            }));
            let fault = match result {
                Ok(Ok(fitted)) => return self.finish(&fitted, &observer, context).map(Some),
                // A checkpoint of another backend, for example: the fit starts from the beginning.
                Ok(Err(FitError::OtherCheckpoint | FitError::Checkpoint(_)))
                    if from.checkpoint.is_some() =>
                {
                    from = Resumption::default();
                    continue;
                }
                Ok(Err(error)) if error.category() == Category::Cancelled => {
                    observer.flush().map_err(|e| Error::Writing(e.to_string()))?;
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
            let _ = observer.flush();
            return Ok(Some(Outcome::Failed(fault)));
        }
    }

    fn finish(
        &self,
        fitted: &Fitted,
        observer: &FitObserver<'_>,
        context: &RunContext<'_>,
    ) -> Result<Outcome, Error> {
        let twin = &fitted.twin;
        let finished = Finished {
            graph: GraphCounts::from(&twin.graph),
            losses: observer.losses(),
            substeps: twin.timing.substeps,
            stable_substeps: stable_substeps(&Model::from(twin)).needed,
            quality: twin.quality.clone(),
            fit_s: observer.spent_s(),
        };
        let bytes = twin.encode().map_err(|e| Error::Writing(format!("{}: {e}", self.id)))?;
        context.folder.write_twin(&self.id, &bytes)?;
        Ok(Outcome::Finished(Box::new(finished)))
    }
}

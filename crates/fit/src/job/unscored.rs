//! Fits whose twin is scored elsewhere, if at all.

use bendtwin_core::{CancelToken, Observer, Progress, Twin};

use super::{FitJob, Run, validation::Validation};
use crate::{Error, task::Task};

impl FitJob<'_> {
    /// The twin alone, without quality table, report and look: for those who score it elsewhere.
    ///
    /// # Errors
    /// Those of [`FitJob::run`].
    pub fn twin(
        &self,
        observer: &mut dyn Observer<Progress>,
        cancel: &CancelToken,
    ) -> Result<Twin, Error> {
        let task = self.task(cancel)?;
        self.unscored(&task, Validation::new(&task).as_ref(), observer, cancel)
    }

    /// The twin that a task's own twin is refined to, without its quality.
    pub(crate) fn refined(&self, task: &Task<'_>, cancel: &CancelToken) -> Result<Twin, Error> {
        self.unscored(task, None, &mut (), cancel)
    }

    /// The twin of a task without its quality.
    fn unscored(
        &self,
        task: &Task<'_>,
        validation: Option<&Validation<'_>>,
        observer: &mut dyn Observer<Progress>,
        cancel: &CancelToken,
    ) -> Result<Twin, Error> {
        let mut run = Run::new(self, task, validation, observer, cancel);
        run.search()?;
        let nothing = || Error::NothingStable("there is no model".into());
        Ok(run.refine()?.into_iter().next().ok_or_else(nothing)?.twin)
    }
}

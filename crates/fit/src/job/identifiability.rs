//! The report of what the recordings leave open, as the end of a fit.

use bendtwin_core::Twin;
use bendtwin_identify::identify;

use super::{Run, time_limit::TimeLimit};
use crate::Error;

impl Run<'_> {
    /// Adds the report to a twin that has been evaluated. A twin that cannot be asked, or not within the
    /// time limit of the fit, has a warning in its place.
    pub(super) fn identify(&self, twin: &mut Twin) -> Result<(), Error> {
        let limit = self.limit.as_ref().map(TimeLimit::end);
        let cancel = limit.map_or_else(|| self.cancel.clone(), |end| self.cancel.until(end));
        match identify(&*self.job.backend, twin, self.job.capture, &cancel) {
            Ok(report) => twin.quality.identifiability = report,
            Err(error) => {
                self.check_cancelled()?;
                let why = if cancel.is_late() {
                    "the time limit was over before it".to_owned()
                } else {
                    error.to_string()
                };
                let warning = format!("what the recordings leave open is not known: {why}");
                twin.quality.warnings.push(warning);
            }
        }
        Ok(())
    }
}

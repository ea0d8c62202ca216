//! The report of what the recordings leave open, as the end of a fit.

use bendtwin_core::Twin;
use bendtwin_identify::identify;

use super::Run;
use crate::Error;

impl Run<'_> {
    /// Adds the report to a twin that has been evaluated. A twin that cannot be asked has a warning in its
    /// place.
    pub(super) fn identify(&self, twin: &mut Twin) -> Result<(), Error> {
        match identify(&*self.job.backend, twin, self.job.capture, self.cancel) {
            Ok(report) => twin.quality.identifiability = report,
            Err(error) => {
                self.check_cancelled()?;
                let warning = format!("what the recordings leave open is not known: {error}");
                twin.quality.warnings.push(warning);
            }
        }
        Ok(())
    }
}

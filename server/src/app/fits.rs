//! Fit jobs as users see them: created, read, cancelled.

use bendtwin_core::{FitSettings, ids::FitId};
use bendtwin_store::{Job, NewFit, Page, PageRequest};

use super::{App, Error, Result};
use crate::context::Context;

const PRIORITIES: std::ops::RangeInclusive<i32> = -100..=100;

impl App {
    /// Queues a fit. Empty settings mean the defaults.
    pub(crate) async fn create_fit(
        &self,
        capture: &str,
        settings_json: &str,
        priority: i32,
        request_id: String,
    ) -> Result<Job> {
        if !PRIORITIES.contains(&priority) {
            return Err(Error::invalid("priority", format!("is {priority}: use -100..=100")));
        }
        let new = NewFit {
            capture: super::name(capture)?,
            settings: settings(settings_json, self.options.limits.json_bytes)?,
            priority,
            request_id: super::request_id(request_id)?,
            trace_parent: Context::current().trace_parent,
        };
        let fit = self.store.jobs().create_fit(new).await?;
        tracing::info!(fit = %fit.id, capture = %fit.capture, "fit queued");
        Ok(fit)
    }

    pub(crate) async fn fit(&self, name: &str) -> Result<Job> {
        Ok(self.store.jobs().get(super::name::<FitId>(name)?).await?)
    }

    pub(crate) async fn fits(&self, page: &PageRequest, capture: &str) -> Result<Page<Job>> {
        Ok(self.store.jobs().fits(page, super::optional_name(capture)?).await?)
    }

    pub(crate) async fn cancel_fit(&self, name: &str) -> Result<Job> {
        Ok(self.store.jobs().cancel(super::name::<FitId>(name)?).await?)
    }

    pub(crate) async fn delete_fit(&self, name: &str) -> Result<()> {
        let id: FitId = super::name(name)?;
        let store = self.store.clone();
        super::run_to_completion(async move { store.jobs().delete(id).await }).await
    }
}

/// The settings in force as canonical JSON: equal settings are equal text.
fn settings(json: &str, limit: usize) -> Result<String> {
    let settings: FitSettings = super::read_settings(json, limit)?;
    settings.validate().map_err(Error::Settings)?;
    serde_json::to_string(&settings).map_err(|e| Error::Internal(e.to_string()))
}

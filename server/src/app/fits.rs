//! Fit jobs as users see them: asked for, looked at, cancelled.

use bendtwin_core::{FitSettings, ids::FitId};
use bendtwin_store::{Fit, NewFit, Page, PageRequest};

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
    ) -> Result<Fit> {
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
        let fit = self.store.fits().create(new).await?;
        tracing::info!(fit = %fit.id, capture = %fit.capture, "fit queued");
        Ok(fit)
    }

    pub(crate) async fn fit(&self, name: &str) -> Result<Fit> {
        Ok(self.store.fits().get(super::name(name)?).await?)
    }

    pub(crate) async fn fits(&self, page: &PageRequest, capture: &str) -> Result<Page<Fit>> {
        Ok(self.store.fits().list(page, super::optional_name(capture)?).await?)
    }

    pub(crate) async fn cancel_fit(&self, name: &str) -> Result<Fit> {
        Ok(self.store.fits().cancel(super::name(name)?).await?)
    }

    pub(crate) async fn delete_fit(&self, name: &str) -> Result<()> {
        let id: FitId = super::name(name)?;
        let store = self.store.clone();
        super::to_the_end(async move { store.fits().delete(id).await }).await
    }
}

/// The settings in force, in one spelling: equal settings are equal text.
fn settings(json: &str, limit: usize) -> Result<String> {
    if json.len() > limit {
        return Err(Error::invalid("settings_json", format!("is longer than {limit} bytes")));
    }
    let settings = if json.trim().is_empty() {
        FitSettings::default()
    } else if !json.trim_start().starts_with('{') {
        // Serde would take a list for a struct, field by field.
        return Err(Error::Settings(vec!["they are not a JSON object".to_owned()]));
    } else {
        serde_json::from_str(json).map_err(|e| Error::Settings(vec![e.to_string()]))?
    };
    settings.validate().map_err(Error::Settings)?;
    serde_json::to_string(&settings).map_err(|e| Error::Internal(e.to_string()))
}

//! Fit jobs.

use bendtwin_core::{
    FitSettings,
    ids::{CaptureId, FitId},
};
use bendtwin_proto::v1::{
    CancelFitRequest, CreateFitRequest, DeleteFitRequest, GetFitRequest, ListFitsRequest,
    WatchFitRequest, fit_service_client::FitServiceClient,
};
use uuid::Uuid;

use crate::{
    Error, Fit, Watch,
    channel::Channel,
    page::{self, Page, PageRequest},
    watch,
};

/// Calls about fit jobs.
#[derive(Clone, Debug)]
pub struct Fits {
    service: FitServiceClient<Channel>,
}

impl Fits {
    pub(crate) fn new(service: FitServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Queues a fit of a capture. Jobs of higher priority run earlier; 0 is normal.
    ///
    /// # Errors
    /// If the settings are wrong, the capture is unknown, or the server cannot be asked.
    pub async fn create(
        &self,
        capture: CaptureId,
        settings: &FitSettings,
        priority: i32,
    ) -> Result<Fit, Error> {
        self.create_once(capture, settings, priority, &Uuid::new_v4().to_string()).await
    }

    /// As [`Fits::create`], but calling it again with the same `request_id` gives the same job.
    ///
    /// # Errors
    /// As [`Fits::create`].
    pub async fn create_once(
        &self,
        capture: CaptureId,
        settings: &FitSettings,
        priority: i32,
        request_id: &str,
    ) -> Result<Fit, Error> {
        let settings_json = serde_json::to_string(settings)
            .map_err(|e| Error::invalid(format!("the settings cannot be written as JSON: {e}")))?;
        let request = CreateFitRequest {
            capture: capture.to_string(),
            settings_json,
            priority,
            request_id: request_id.to_owned(),
        };
        self.service.clone().create_fit(request).await?.into_inner().try_into()
    }

    /// One job.
    ///
    /// # Errors
    /// If there is none of that name, or the server cannot be asked.
    pub async fn get(&self, name: FitId) -> Result<Fit, Error> {
        let request = GetFitRequest { name: name.to_string() };
        self.service.clone().get_fit(request).await?.into_inner().try_into()
    }

    /// A page of the jobs, of one capture if given.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(
        &self,
        capture: Option<CaptureId>,
        page: PageRequest,
    ) -> Result<Page<Fit>, Error> {
        let request = ListFitsRequest {
            page_size: page.size,
            page_token: page.token,
            capture: capture.map(|c| c.to_string()).unwrap_or_default(),
        };
        let reply = self.service.clone().list_fits(request).await?.into_inner();
        Page::new(reply.fits, reply.next_page_token, Fit::try_from)
    }

    /// All jobs, of one capture if given.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn all(&self, capture: Option<CaptureId>) -> Result<Vec<Fit>, Error> {
        page::all(|page| self.list(capture, page)).await
    }

    /// Asks a job to stop; one that has ended is returned as it is.
    ///
    /// # Errors
    /// If there is none of that name, or the server cannot be asked.
    pub async fn cancel(&self, name: FitId) -> Result<Fit, Error> {
        let request = CancelFitRequest { name: name.to_string() };
        self.service.clone().cancel_fit(request).await?.into_inner().try_into()
    }

    /// Deletes a job that has ended; its twin stays.
    ///
    /// # Errors
    /// If it still runs, or the server cannot be asked.
    pub async fn delete(&self, name: FitId) -> Result<(), Error> {
        let request = DeleteFitRequest { name: name.to_string() };
        self.service.clone().delete_fit(request).await?;
        Ok(())
    }

    /// The job now and after every change, until it has ended. Waits up to a minute for a server
    /// that cannot be reached.
    pub fn watch(&self, name: FitId) -> Watch<Fit> {
        let service = self.service.clone();
        watch::start(move |after_revision| {
            let mut service = service.clone();
            let request = WatchFitRequest { name: name.to_string(), after_revision };
            Box::pin(async move { Ok(service.watch_fit(request).await?.into_inner()) })
        })
    }

    /// Waits until a job has ended, however it ends.
    ///
    /// # Errors
    /// As [`Fits::watch`].
    pub async fn wait(&self, name: FitId) -> Result<Fit, Error> {
        self.watch(name).last().await
    }
}

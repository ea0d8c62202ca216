//! Fit jobs.

mod losses;
mod preview;

use bendtwin_core::{
    FitSettings,
    ids::{CaptureId, FitId},
};
use bendtwin_proto::v1::{
    CancelFitRequest, CreateFitRequest, DeleteFitRequest, GetFitLossesRequest,
    GetFitPreviewRequest, GetFitRequest, ListFitsRequest, UpdateFitRequest, WatchFitRequest,
    fit_service_client::FitServiceClient,
};
use uuid::Uuid;

use crate::{
    Error, Fit, ListQuery, Requirements, Update, Watch,
    client::Channel,
    labels::{list_request, update_request},
    page::{self, Page},
    resources::if_any,
    watch,
};

pub use losses::LossCurve;
pub use preview::FitPreview;

/// Properties of a new fit beside its settings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FitOrder {
    /// Jobs of higher priority run earlier; 0 is normal, -100..=100.
    pub priority: i32,
    /// Idempotency key: calls with the same one give the same job.
    pub request_id: Option<String>,
    /// Display name; empty means the capture's.
    pub display_name: String,
    /// Worker that it asks for.
    pub requirements: Requirements,
}

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
        self.create_as(capture, settings, FitOrder { priority, ..FitOrder::default() }).await
    }

    /// [`Fits::create`], where calls with the same `request_id` give the same job.
    ///
    /// # Errors
    /// Those of [`Fits::create`].
    pub async fn create_once(
        &self,
        capture: CaptureId,
        settings: &FitSettings,
        priority: i32,
        request_id: &str,
    ) -> Result<Fit, Error> {
        let request_id = Some(request_id.to_owned());
        let order = FitOrder { priority, request_id, ..FitOrder::default() };
        self.create_as(capture, settings, order).await
    }

    /// [`Fits::create`] with all options of a fit beside its settings.
    ///
    /// # Errors
    /// Those of [`Fits::create`].
    pub async fn create_as(
        &self,
        capture: CaptureId,
        settings: &FitSettings,
        order: FitOrder,
    ) -> Result<Fit, Error> {
        let settings_json = serde_json::to_string(settings)
            .map_err(|e| Error::invalid(format!("the settings cannot be written as JSON: {e}")))?;
        let request = CreateFitRequest {
            capture: capture.to_string(),
            settings_json,
            priority: order.priority,
            request_id: order.request_id.unwrap_or_else(|| Uuid::new_v4().to_string()),
            display_name: order.display_name,
            requirements: if_any(&order.requirements),
        };
        self.service.clone().create_fit(request).await?.into_inner().try_into()
    }

    /// Returns a fit.
    ///
    /// # Errors
    /// If the fit does not exist, or the server cannot be asked.
    pub async fn get(&self, name: FitId) -> Result<Fit, Error> {
        let request = GetFitRequest { name: name.to_string() };
        self.service.clone().get_fit(request).await?.into_inner().try_into()
    }

    /// A page of fits.
    ///
    /// # Errors
    /// If the query is not allowed, or the server cannot be asked.
    pub async fn list(&self, query: ListQuery) -> Result<Page<Fit>, Error> {
        let (capture, state) = (query.capture_name(), query.state.map_or(0, i32::from));
        let request = list_request!(ListFitsRequest { capture, state }, query);
        let reply = self.service.clone().list_fits(request).await?.into_inner();
        Page::new(reply.fits, reply.next_page_token, Fit::try_from)
    }

    /// All fits of a query, page by page.
    ///
    /// # Errors
    /// Those of [`Fits::list`].
    pub async fn all(&self, query: &ListQuery) -> Result<Vec<Fit>, Error> {
        page::all(|page| self.list(ListQuery { page, ..query.clone() })).await
    }

    /// The losses of all iterations so far, by stage and model. They stay until the fit is deleted.
    ///
    /// # Errors
    /// If the fit does not exist, or the server cannot be asked.
    pub async fn losses(&self, name: FitId) -> Result<Vec<LossCurve>, Error> {
        let request = GetFitLossesRequest { name: name.to_string() };
        let losses = self.service.clone().get_fit_losses(request).await?.into_inner();
        losses.curves.into_iter().map(LossCurve::try_from).collect()
    }

    /// What a running fit has so far.
    ///
    /// # Errors
    /// If there is no preview yet or any more, or the server cannot be asked.
    pub async fn preview(&self, name: FitId) -> Result<FitPreview, Error> {
        let request = GetFitPreviewRequest { name: name.to_string() };
        self.service.clone().get_fit_preview(request).await?.into_inner().try_into()
    }

    /// Changes name, note and tags.
    ///
    /// # Errors
    /// If a change is not allowed, the fit does not exist, or the server cannot be asked.
    pub async fn update(&self, name: FitId, update: &Update) -> Result<Fit, Error> {
        let request = update_request!(UpdateFitRequest { fit: Fit }, name, update);
        self.service.clone().update_fit(request).await?.into_inner().try_into()
    }

    /// Asks a fit to stop; one that has ended is returned unchanged.
    ///
    /// # Errors
    /// If the fit does not exist, or the server cannot be asked.
    pub async fn cancel(&self, name: FitId) -> Result<Fit, Error> {
        let request = CancelFitRequest { name: name.to_string() };
        self.service.clone().cancel_fit(request).await?.into_inner().try_into()
    }

    /// Moves a job that does not run to the trash; its twin stays.
    ///
    /// # Errors
    /// If it still runs, or the server cannot be asked.
    pub async fn delete(&self, name: FitId) -> Result<(), Error> {
        self.remove(name, false).await
    }

    /// Deletes a job for good, in the trash or not.
    ///
    /// # Errors
    /// If it still runs, or the server cannot be asked.
    pub async fn purge(&self, name: FitId) -> Result<(), Error> {
        self.remove(name, true).await
    }

    async fn remove(&self, name: FitId, purge: bool) -> Result<(), Error> {
        let request = DeleteFitRequest { name: name.to_string(), purge };
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
    /// Those of [`Fits::watch`].
    pub async fn wait(&self, name: FitId) -> Result<Fit, Error> {
        self.watch(name).last().await
    }
}

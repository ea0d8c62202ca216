//! Workers: their registration, and what users see of them.

use bendtwin_core::ids::WorkerId;
use bendtwin_store::{Loss, NewWorker};

use super::{App, Error, Result, requirements};
use crate::{dispatch::WorkerView, tokens::Bearer};

impl App {
    /// Registers a worker. `token` is the one that it showed, and that it expects in calls.
    pub(crate) async fn register_worker(
        &self,
        new: NewWorker,
        bearer: Bearer,
        token: &str,
    ) -> Result<()> {
        requirements::check_labels("labels", &new.labels)?;
        let child = match bearer {
            Bearer::Child(child) => Some(child),
            Bearer::External => None,
        };
        let worker = self.store.workers().register(new).await?;
        let id = worker.registration.id;
        tracing::info!(worker = %id, device = worker.registration.device, "worker registered");
        if let Err(error) = self.dispatch.add(worker, child, token) {
            self.store.workers().forget(id).await?;
            return Err(error);
        }
        // A process that ended meanwhile has been cleaned up after already.
        if self.tokens.bearer(token) != Some(bearer) {
            self.worker_gone(id).await?;
            return Err(Error::BadToken);
        }
        Ok(())
    }

    pub(crate) fn workers(&self, page_token: &str) -> Result<Vec<WorkerView>> {
        if page_token.is_empty() {
            return Ok(self.dispatch.views());
        }
        // No listing of workers ever gave one out.
        Err(bendtwin_store::Error::InvalidPageToken.into())
    }

    pub(crate) fn worker(&self, name: &str) -> Result<WorkerView> {
        let id: WorkerId = super::name(name)?;
        let views = self.dispatch.views();
        views
            .into_iter()
            .find(|v| v.worker.registration.id == id)
            .ok_or_else(|| bendtwin_store::Error::NotFound { name: id.to_string() }.into())
    }

    /// Takes up the state that the last run of the server left. Jobs of workers that it had started
    /// are free at once: those processes ended with it, and fencing keeps stragglers off. Workers
    /// started by others are expected to be alive still, and get the time of a lease to report.
    pub(crate) async fn recover(&self) -> Result<()> {
        for worker in self.store.workers().all().await? {
            let id = worker.registration.id;
            match &self.options.worker_token {
                Some(token) if !worker.registration.supervised => {
                    if let Err(error) = self.dispatch.add(worker, None, token) {
                        // It registers again if it is alive.
                        tracing::warn!(worker = %id, %error, "cannot take a worker up again");
                        self.store.jobs().forfeit(id, Loss::Server).await?;
                        self.store.workers().forget(id).await?;
                    }
                }
                _ => {
                    self.store.jobs().forfeit(id, Loss::Server).await?;
                    self.store.workers().forget(id).await?;
                }
            }
        }
        Ok(())
    }
}

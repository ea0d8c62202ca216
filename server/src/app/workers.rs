//! Workers: their registration, what they say of themselves, and what users see of them.

mod members;

use bendtwin_core::ids::WorkerId;
use bendtwin_store::{NewWorker, WorkerEnd};

use super::{App, Error, Result, requirements};
use crate::{
    access::{Bearer, Child},
    dispatch::{Heartbeat, WorkerView},
};

pub(super) use members::Members;

impl App {
    /// A token for a worker process that is about to be started.
    pub(crate) fn admit_child(&self, child: Child) -> String {
        self.tokens.issue(child)
    }

    /// A worker process was started in the place of one that had ended.
    pub(crate) fn child_restarted(&self, slot: u32) {
        self.metrics.worker_restarted(slot);
    }

    /// Revokes the token of a worker process that has ended, so that no further call gets through,
    /// and gives its jobs back.
    pub(crate) async fn child_gone(&self, child: Child) {
        self.tokens.revoke(child);
        for worker in self.dispatch.of_child(child) {
            if let Err(error) = self.worker_gone(worker).await {
                tracing::error!(%error, %worker, "its jobs wait for their leases to run out");
            }
        }
    }

    /// The holder of a worker's token, if it is valid.
    pub(crate) fn bearer(&self, token: &str) -> Option<Bearer> {
        self.tokens.bearer(token)
    }

    /// Registers a worker. `token` is the one that it showed, and that it expects in calls.
    pub(crate) async fn register_worker(
        &self,
        mut new: NewWorker,
        bearer: Bearer,
        token: &str,
    ) -> Result<()> {
        requirements::check_labels("labels", &new.labels)?;
        let child = match bearer {
            Bearer::Child(child) => Some(child),
            Bearer::External => None,
        };
        new.server = child.map(|_| self.id);
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

    /// Takes a heartbeat in. Returns true if the worker is to end.
    pub(crate) async fn heartbeat(
        &self,
        worker: WorkerId,
        bearer: Bearer,
        heartbeat: Heartbeat,
    ) -> Result<bool> {
        self.require_known(worker).await?;
        let unknown = || Error::WorkerUnknown(worker.to_string());
        if !self.dispatch.heartbeat(worker, heartbeat) {
            return Err(unknown());
        }
        if bearer == Bearer::External && !self.tell_of(worker).await? {
            self.dispatch.remove(worker);
            return Err(unknown());
        }
        // Workers that others started outlive a restart of the server.
        let ends_with_server = self.stopping.is_cancelled() && bearer != Bearer::External;
        Ok(ends_with_server || self.dispatch.draining(worker).is_cancelled())
    }

    /// A worker ends in good order.
    pub(crate) async fn worker_left(&self, worker: WorkerId) -> Result<()> {
        tracing::info!(%worker, "worker ended");
        self.forfeit(worker, WorkerEnd::ByServer).await.map(drop)
    }

    /// Asks a worker to take no more work and to end.
    pub(crate) async fn drain_worker(&self, name: &str) -> Result<WorkerView> {
        let worker = self.store.workers().drain(super::name(name)?).await?;
        let id = worker.registration.id;
        tracing::info!(worker = %id, "worker is to end");
        self.dispatch.drain(id);
        Ok(found(self.dispatch.views(), id).unwrap_or_else(|| worker.into()))
    }

    pub(crate) async fn workers(&self, page_token: &str) -> Result<Vec<WorkerView>> {
        if !page_token.is_empty() {
            // No listing of workers ever gave one out.
            return Err(bendtwin_store::Error::InvalidPageToken.into());
        }
        let mut views = self.dispatch.views();
        if self.store.is_shared() {
            // The processes of other servers, and what registered in this moment.
            let unknown = |id: WorkerId| !views.iter().any(|v| v.worker.registration.id == id);
            let mut others = self.store.workers().all().await?;
            others.retain(|worker| unknown(worker.registration.id));
            views.extend(others.into_iter().map(WorkerView::from));
            views.sort_by_key(|v| std::cmp::Reverse(v.worker.registration.id));
        }
        Ok(views)
    }

    pub(crate) async fn worker(&self, name: &str) -> Result<WorkerView> {
        let id: WorkerId = super::name(name)?;
        found(self.workers("").await?, id)
            .ok_or_else(|| bendtwin_store::Error::NotFound { name: id.to_string() }.into())
    }
}

fn found(views: Vec<WorkerView>, id: WorkerId) -> Option<WorkerView> {
    views.into_iter().find(|view| view.worker.registration.id == id)
}

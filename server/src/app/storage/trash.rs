//! Deletions, which go to the trash, and restorations.

use bendtwin_core::ids::{CaptureId, FitId, TwinId};
use bendtwin_store::{
    Collection, Deletion, Job, Overview, Page, PageRequest, Resource, Trashed, Twin,
};

use crate::{
    access::Scope,
    app::{App, Result, labels, rights},
    audit,
    context::Context,
};

impl App {
    pub(crate) async fn delete_capture(&self, name: &str, purge: bool) -> Result<()> {
        let done: Result<()> = async {
            let id: CaptureId = self.reach(Scope::CapturesWrite, name).await?;
            self.delete(id, purge).await
        }
        .await;
        audit::changed("DeleteCapture", name, &done);
        done
    }

    pub(crate) async fn delete_fit(&self, name: &str, purge: bool) -> Result<()> {
        let done: Result<()> = async {
            let id: FitId = self.reach(Scope::FitsWrite, name).await?;
            self.delete(id, purge).await
        }
        .await;
        audit::changed("DeleteFit", name, &done);
        done
    }

    pub(crate) async fn delete_twin(&self, name: &str, purge: bool) -> Result<()> {
        let done: Result<()> = async {
            let id: TwinId = self.reach(Scope::TwinsWrite, name).await?;
            self.delete(id, purge).await
        }
        .await;
        audit::changed("DeleteTwin", name, &done);
        done
    }

    /// Deletes a resource: for good if that is asked for or there is no trash.
    async fn delete(&self, resource: impl Into<Resource>, purge: bool) -> Result<()> {
        let resource = resource.into();
        let (store, kept) = (self.store.clone(), self.options.trash());
        if purge || kept.is_zero() {
            self.change(async move { store.trash().delete(resource).await }).await?;
        } else {
            let deletion = Deletion { kept, by: Context::current().caller.creator().owner };
            self.change(async move { store.trash().put(resource, &deletion).await }).await?;
            // A deletion frees space where that is short.
            self.room_wanted.notify_one();
        }
        tracing::info!(%resource, purge, "deleted");
        if let Resource::Twin(id) = resource {
            self.dispatch.forget_twin(id);
        }
        Ok(())
    }

    /// A page of the trash of a collection.
    pub(crate) async fn trashed(
        &self,
        collection: Collection,
        owner: String,
        page: &PageRequest,
    ) -> Result<Page<Trashed>> {
        let owner = labels::owner(owner)?;
        let scope = match collection {
            Collection::Captures => Scope::CapturesRead,
            Collection::Fits => Scope::FitsRead,
            Collection::Twins => Scope::TwinsRead,
        };
        let shared_with = rights::confined(scope);
        let shared_with = shared_with.as_deref();
        Ok(self.store.trash().list(collection, &owner, shared_with, page).await?)
    }

    pub(crate) async fn undelete_capture(&self, name: &str) -> Result<Overview> {
        let done: Result<Overview> = async {
            let id: CaptureId = self.reach(Scope::CapturesWrite, name).await?;
            self.restore(id.into()).await?;
            Ok(self.store.captures().overview(id).await?)
        }
        .await;
        audit::changed("UndeleteCapture", name, &done);
        done
    }

    pub(crate) async fn undelete_fit(&self, name: &str) -> Result<Job> {
        let done: Result<Job> = async {
            let id: FitId = self.reach(Scope::FitsWrite, name).await?;
            self.restore(id.into()).await?;
            Ok(self.store.jobs().get(id).await?)
        }
        .await;
        audit::changed("UndeleteFit", name, &done);
        done
    }

    pub(crate) async fn undelete_twin(&self, name: &str) -> Result<Twin> {
        let done: Result<Twin> = async {
            let id: TwinId = self.reach(Scope::TwinsWrite, name).await?;
            self.restore(id.into()).await?;
            Ok(self.store.twins().get(id).await?)
        }
        .await;
        audit::changed("UndeleteTwin", name, &done);
        done
    }

    async fn restore(&self, resource: Resource) -> Result<()> {
        let (store, creator) = (self.store.clone(), Context::current().caller.creator());
        self.change(async move { store.trash().restore(resource, &creator).await }).await?;
        tracing::info!(%resource, "restored");
        Ok(())
    }

    /// Waits until the disk may be short of space that the trash has.
    pub(crate) async fn room_wanted(&self) {
        self.room_wanted.notified().await;
    }

    /// Purges what is due in the trash, and, where less of the disk is free than the floor, what was
    /// deleted first, until a quarter more is free.
    pub(crate) async fn sweep_trash(&self) -> Result<()> {
        let store = self.store.clone();
        let due = self.change(async move { store.trash().sweep().await }).await?;
        let floor = self.options.disk_floor_bytes();
        let early = match self.store.disk() {
            Ok(disk) if disk.free_bytes < floor => {
                let store = self.store.clone();
                let wanted = floor.saturating_add(floor / 4);
                self.change(async move { store.trash().make_room(wanted).await }).await?
            }
            _ => Vec::new(),
        };
        for (resources, why) in [(due, "due"), (early, "the disk is short of space")] {
            for resource in resources {
                tracing::info!(%resource, why, "purged from the trash");
                audit::by_server("Purge", resource, why);
            }
        }
        Ok(())
    }
}

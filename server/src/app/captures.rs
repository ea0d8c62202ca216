//! Captures. Their content is opaque here; workers read it. What people state about them is in
//! `facts`, files that are added to them in `supplements`.

mod facts;
pub(super) mod supplements;

use bendtwin_proto::v1::{
    CaptureMetadata, ListCapturesRequest, SupplementMetadata, UpdateCaptureRequest,
};
use bendtwin_store::{Capture, CaptureFacts, Content, Creator, NewCapture, Overview, Page, Staged};

use super::{App, Body, Error, Result, receive::Receiving};
use crate::{access::Scope, audit, context::Context};

impl App {
    pub(crate) async fn create_capture(
        &self,
        mut metadata: CaptureMetadata,
        body: Body,
    ) -> Result<Overview> {
        let request_id = super::request_id(std::mem::take(&mut metadata.request_id))?;
        let digest = super::digest(&metadata.digest)?;
        let facts = self.capture_facts(metadata)?;
        self.require_room(0)?;
        let owner = Context::current().caller.owner;
        let is_repetition = match &request_id {
            Some(request_id) => self.store.captures().has_requested(&owner, request_id).await?,
            None => false,
        };
        let limit = self.options.limits.capture_bytes;
        let _buffers = self.memory.upload().await?;
        let receiving = Receiving::Upload { jobs: 1, limit, is_repetition };
        let content = self.receive(body, receiving, digest).await?;
        if content.size_bytes() == 0 {
            return Err(Error::invalid("content", "is empty: send the capture archive"));
        }
        if let Some(request_id) = request_id.as_deref().filter(|_| content.is_compared()) {
            let done: Result<Overview> = async {
                let (captures, name) = (self.store.captures(), &facts.display_name);
                let capture = captures.repeated(&owner, request_id, name, content.digest()).await?;
                Ok(captures.overview(capture.id).await?)
            }
            .await;
            audit::made("CreateCapture", &done, |overview| overview.capture.id.to_string());
            return done;
        }
        let creator = Context::current().caller.creator();
        self.store_capture(facts, request_id, content, creator).await
    }

    /// Makes a capture of received content, the last step of every upload.
    pub(super) async fn store_capture(
        &self,
        facts: CaptureFacts,
        request_id: Option<String>,
        content: Staged,
        creator: Creator,
    ) -> Result<Overview> {
        let done: Result<Overview> = async {
            let trace_parent = Context::current().trace_parent();
            let new = NewCapture { facts, request_id, content, creator, trace_parent };
            let store = self.store.clone();
            let capture = self.change(async move { store.captures().create(new).await }).await?;
            tracing::info!(capture = %capture.id, bytes = capture.size_bytes, "capture stored");
            Ok(self.store.captures().overview(capture.id).await?)
        }
        .await;
        audit::made("CreateCapture", &done, |overview| overview.capture.id.to_string());
        done
    }

    pub(crate) async fn capture(&self, name: &str) -> Result<Overview> {
        Ok(self.store.captures().overview(self.reach(Scope::CapturesRead, name).await?).await?)
    }

    pub(crate) async fn captures(&self, request: ListCapturesRequest) -> Result<Page<Overview>> {
        Ok(self.store.captures().overviews(&facts::query(request)?).await?)
    }

    pub(crate) async fn update_capture(&self, request: UpdateCaptureRequest) -> Result<Overview> {
        let name = request.capture.as_ref().map(|capture| capture.name.clone()).unwrap_or_default();
        let done: Result<Overview> = async {
            let id = self.reach(Scope::CapturesWrite, &name).await?;
            let change = facts::change(request)?;
            self.require_room(0)?;
            let store = self.store.clone();
            self.change(async move { store.captures().update(id, &change).await }).await?;
            Ok(self.store.captures().overview(id).await?)
        }
        .await;
        audit::changed("UpdateCapture", &name, &done);
        done
    }

    pub(crate) async fn capture_content(&self, name: &str) -> Result<(Capture, Content)> {
        Ok(self.store.captures().content(self.reach(Scope::CapturesRead, name).await?).await?)
    }

    /// Adds a file to a capture, or replaces the one of its kind.
    pub(crate) async fn add_supplement(
        &self,
        metadata: SupplementMetadata,
        body: Body,
    ) -> Result<Overview> {
        let resource = format!("{}/supplements/{}", metadata.name, metadata.kind);
        let done = self.receive_supplement(metadata, body).await;
        audit::changed("AddSupplement", resource, &done);
        done
    }

    pub(crate) async fn delete_supplement(&self, name: &str, kind: &str) -> Result<()> {
        let done = self.remove_supplement(name, kind).await;
        audit::changed("DeleteSupplement", format!("{name}/supplements/{kind}"), &done);
        done
    }
}

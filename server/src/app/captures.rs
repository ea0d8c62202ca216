//! Captures. Their content is opaque here; workers read it.

use bendtwin_core::ids::CaptureId;
use bendtwin_proto::v1::CaptureMetadata;
use bendtwin_store::{Capture, Content, Creator, NewCapture, Overview, Page, Staged};

use super::{
    App, Body, Error, Result,
    ingests::Ingest,
    labels::{CAPTURE_ORDERS, Listing},
};
use crate::{audit, context::Context};

impl App {
    pub(crate) async fn create_capture(
        &self,
        metadata: CaptureMetadata,
        body: Body,
    ) -> Result<Overview> {
        let display_name = super::labels::display_name(metadata.display_name)?;
        let request_id = super::request_id(metadata.request_id)?;
        let digest = super::digest(&metadata.digest)?;
        let requirements = super::requirements::of(metadata.ingest_requirements);
        let ingest = self.ingest(&metadata.ingest_json, requirements)?;
        self.require_room(0)?;
        let limit = self.options.limits.capture_bytes;
        let _buffers = self.memory.upload().await?;
        let content = self.receive(body, limit, digest, |_| ()).await?;
        if content.size_bytes() == 0 {
            return Err(Error::invalid("content", "is empty: send the capture archive"));
        }
        let creator = Context::current().caller.creator();
        self.store_capture(display_name, request_id, ingest, content, creator).await
    }

    /// Makes a capture of received content, the last step of every upload.
    pub(super) async fn store_capture(
        &self,
        display_name: String,
        request_id: Option<String>,
        ingest: Ingest,
        content: Staged,
        creator: Creator,
    ) -> Result<Overview> {
        let done: Result<Overview> = async {
            let trace_parent = Context::current().trace_parent();
            let Ingest { settings: ingest, requirements } = ingest;
            let new = NewCapture {
                display_name,
                request_id,
                content,
                ingest,
                requirements,
                creator,
                trace_parent,
            };
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
        Ok(self.store.captures().overview(super::name(name)?).await?)
    }

    pub(crate) async fn captures(&self, listing: Listing) -> Result<Page<Overview>> {
        let query = listing.query(&CAPTURE_ORDERS)?;
        Ok(self.store.captures().overviews(&query).await?)
    }

    pub(crate) async fn capture_content(&self, name: &str) -> Result<(Capture, Content)> {
        Ok(self.store.captures().content(super::name(name)?).await?)
    }

    pub(crate) async fn delete_capture(&self, name: &str) -> Result<()> {
        let done: Result<()> = async {
            let id: CaptureId = super::name(name)?;
            let store = self.store.clone();
            self.change(async move { store.captures().delete(id).await }).await?;
            tracing::info!(capture = %id, "capture deleted");
            Ok(())
        }
        .await;
        audit::changed("DeleteCapture", name, &done);
        done
    }
}

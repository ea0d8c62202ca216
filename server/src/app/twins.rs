//! Twins: read, exported, imported, and shown: geometry, surface, pictures, files of other programs.

mod export;
mod geometry;
mod surface;
mod thumbnail;

use std::sync::Arc;

use bendtwin_budget::Share;
use bendtwin_contract::rollout;
use bendtwin_core::{Twin as TwinFile, ids::TwinId};
use bendtwin_proto::v1::TwinMetadata;
use bendtwin_store::{Content, NewTwin, Page, Twin};
use futures::TryStreamExt as _;

use super::{
    App, Body, Error, Result,
    labels::{Listing, ORDERS},
    receive::Receiving,
    shares,
};
use crate::{access::Scope, audit, context::Context};

pub(super) use thumbnail::Drawing;
pub(crate) use {export::Exported, geometry::Geometry, surface::SurfaceReply, thumbnail::Shown};

impl App {
    /// Imports a twin file after checking all of it.
    pub(crate) async fn create_twin(&self, metadata: TwinMetadata, body: Body) -> Result<Twin> {
        let done: Result<Twin> = async {
            let display_name = super::labels::display_name(metadata.display_name)?;
            let request_id = super::request_id(metadata.request_id)?;
            let digest = super::digest(&metadata.digest)?;
            self.require_room(0)?;
            let owner = Context::current().caller.owner;
            let is_repetition = match &request_id {
                Some(request_id) => self.store.twins().has_requested(&owner, request_id).await?,
                None => false,
            };
            let limit = self.options.limits.twin_bytes;
            let _buffers = self.memory.upload().await?;
            let receiving = Receiving::Upload { jobs: 0, limit, is_repetition };
            let content = self.receive(body, receiving, digest).await?;
            if let Some(request_id) = request_id.as_deref().filter(|_| content.is_compared()) {
                let twins = self.store.twins();
                return Ok(twins
                    .repeated(&owner, request_id, &display_name, content.digest())
                    .await?);
            }
            let facts = self.check_twin(&content).await?;
            let creator = Context::current().caller.creator();
            let new = NewTwin { display_name, request_id, facts, content, creator };
            let store = self.store.clone();
            self.change(async move { store.twins().create(new).await }).await
        }
        .await;
        audit::made("CreateTwin", &done, |twin| twin.id.to_string());
        done
    }

    pub(crate) async fn twin(&self, name: &str) -> Result<Twin> {
        let twin = self.store.twins().get(self.reach(Scope::TwinsRead, name).await?).await?;
        Ok(match Context::current().caller.share {
            Some(_) => shares::for_visitors(twin),
            None => twin,
        })
    }

    pub(crate) async fn twins(&self, listing: Listing) -> Result<Page<Twin>> {
        Ok(self.store.twins().list(&listing.query(Scope::TwinsRead, &ORDERS)?).await?)
    }

    pub(crate) async fn twin_content(&self, name: &str) -> Result<(Twin, Content)> {
        Ok(self.store.twins().content(self.reach(Scope::TwinsRead, name).await?).await?)
    }

    /// What `read` makes of the row of a twin and its file, beside the tasks of the runtime.
    async fn read_twin<T: Send + 'static>(
        &self,
        twin: TwinId,
        read: impl FnOnce(&Twin, &TwinFile) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        let (row, content) = self.store.twins().content(twin).await?;
        let share = self.memory.twin_file(content.size_bytes).await?;
        let chunks: Vec<_> = content.chunks.try_collect().await?;
        let reading = tokio::task::spawn_blocking(move || {
            let _share = share;
            let twin = TwinFile::decode(&chunks.concat())?;
            drop(chunks);
            read(&row, &twin)
        });
        reading.await.map_err(|e| Error::Internal(format!("reading a twin file: {e}")))?
    }

    /// Memory of a reply with tensors of `bytes`, which as nested lists of JSON may not be large.
    async fn hold_tensors(&self, bytes: u64, as_lists: bool) -> Result<Arc<Share>> {
        let limit = self.options.limits.rollout.json_reply_bytes;
        if as_lists && bytes > limit {
            return Err(Error::Rollout(rollout::Error::TooLarge {
                what: "the size of the reply in bytes",
                asked: bytes,
                limit,
                advice: "ask for tensors=base64, or over gRPC",
            }));
        }
        Ok(Arc::new(self.memory.reply(bytes).await?))
    }
}

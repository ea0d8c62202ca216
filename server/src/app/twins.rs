//! Twins: read, exported, imported.

use bendtwin_core::{Twin as TwinFile, ids::TwinId};
use bendtwin_store::{Content, NewTwin, Page, PageRequest, Twin, TwinFacts};

use super::{App, Body, Error, Result};

/// A requested import of a twin file.
pub(crate) struct TwinUpload {
    pub(crate) display_name: String,
    pub(crate) request_id: String,
    /// BLAKE3 in hex; checked if not empty.
    pub(crate) digest: String,
    pub(crate) body: Body,
}

impl App {
    /// Imports a twin file after checking all of it.
    pub(crate) async fn create_twin(&self, upload: TwinUpload) -> Result<Twin> {
        let display_name = super::display_name(upload.display_name)?;
        let request_id = super::request_id(upload.request_id)?;
        let digest = super::digest(&upload.digest)?;
        self.require_room(0)?;
        let limit = self.options.limits.twin_bytes;
        let _buffers = self.memory.upload().await?;
        let content = self.receive(upload.body, limit, digest, |_| ()).await?;
        // Only now, so that a slow upload holds no memory.
        let share = self.memory.twin_file(content.size_bytes()).await?;
        let bytes = content.read().await?;
        let facts = tokio::task::spawn_blocking(move || {
            let _share = share;
            TwinFile::decode(&bytes).map_err(Error::from).and_then(|twin| facts(&twin))
        })
        .await
        .map_err(|e| Error::Internal(format!("reading an imported twin: {e}")))??;
        let new = NewTwin { display_name, request_id, facts, content };
        let store = self.store.clone();
        self.change(async move { store.twins().create(new).await }).await
    }

    pub(crate) async fn twin(&self, name: &str) -> Result<Twin> {
        Ok(self.store.twins().get(super::name(name)?).await?)
    }

    pub(crate) async fn twins(&self, page: &PageRequest, capture: &str) -> Result<Page<Twin>> {
        Ok(self.store.twins().list(page, super::optional_name(capture)?).await?)
    }

    pub(crate) async fn twin_content(&self, name: &str) -> Result<(Twin, Content)> {
        Ok(self.store.twins().content(super::name(name)?).await?)
    }

    pub(crate) async fn delete_twin(&self, name: &str) -> Result<()> {
        let id: TwinId = super::name(name)?;
        let store = self.store.clone();
        self.change(async move { store.twins().delete(id).await }).await?;
        self.dispatch.forget_twin(id);
        Ok(())
    }
}

/// The facts of a twin that listings show.
fn facts(twin: &TwinFile) -> Result<TwinFacts> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Ok(TwinFacts {
        node_count: count(twin.graph.node_count()),
        spring_count: count(twin.graph.springs.len()),
        triplet_count: count(twin.graph.triplets.len()),
        control_count: count(twin.graph.control_count()),
        fps: twin.timing.fps,
        substeps: twin.timing.substeps,
        quality: serde_json::to_string(&twin.quality)
            .map_err(|e| Error::Internal(e.to_string()))?,
    })
}

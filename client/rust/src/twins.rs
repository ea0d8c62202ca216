//! Fitted twins.

mod geometry;
mod surface;

use bendtwin_core::{Surface, Twin as TwinModel, ids::TwinId};
use bendtwin_proto::v1::{
    CreateTwinRequest, DeleteTwinRequest, ExportTwinRequest, GetTwinGeometryRequest,
    GetTwinRequest, GetTwinSurfaceRequest, ListTwinsRequest, TwinMetadata, UpdateTwinRequest,
    create_twin_request::Part, twin_service_client::TwinServiceClient,
};
use bytes::Bytes;
use uuid::Uuid;

use crate::{
    Category, Error, ListQuery, Twin, Update,
    client::Channel,
    labels::{list_request, update_request},
    page::{self, Page},
};

pub use geometry::Geometry;

/// Bytes of one chunk of an upload.
const CHUNK: usize = 256 << 10;

/// Calls about twins.
#[derive(Clone, Debug)]
pub struct Twins {
    service: TwinServiceClient<Channel>,
}

impl Twins {
    pub(crate) fn new(service: TwinServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Returns a twin's entry.
    ///
    /// # Errors
    /// If the twin does not exist, or the server cannot be asked.
    pub async fn get(&self, name: TwinId) -> Result<Twin, Error> {
        let request = GetTwinRequest { name: name.to_string() };
        self.service.clone().get_twin(request).await?.into_inner().try_into()
    }

    /// A page of twins.
    ///
    /// # Errors
    /// If the query is not allowed, or the server cannot be asked.
    pub async fn list(&self, query: ListQuery) -> Result<Page<Twin>, Error> {
        let (capture, level) = (query.capture_name(), query.level_word());
        let request = list_request!(ListTwinsRequest { capture, level }, query);
        let reply = self.service.clone().list_twins(request).await?.into_inner();
        Page::new(reply.twins, reply.next_page_token, Twin::try_from)
    }

    /// All twins of a query, page by page.
    ///
    /// # Errors
    /// Those of [`Twins::list`].
    pub async fn all(&self, query: &ListQuery) -> Result<Vec<Twin>, Error> {
        page::all(|page| self.list(ListQuery { page, ..query.clone() })).await
    }

    /// Changes name, note and tags.
    ///
    /// # Errors
    /// If a change is not allowed, the twin does not exist, or the server cannot be asked.
    pub async fn update(&self, name: TwinId, update: &Update) -> Result<Twin, Error> {
        let request = update_request!(UpdateTwinRequest { twin: Twin }, name, update);
        self.service.clone().update_twin(request).await?.into_inner().try_into()
    }

    /// Nodes, springs and control points of a twin.
    ///
    /// # Errors
    /// If the twin does not exist, or the server cannot be asked.
    pub async fn geometry(&self, name: TwinId) -> Result<Geometry, Error> {
        let request = GetTwinGeometryRequest { name: name.to_string() };
        self.service.clone().get_twin_geometry(request).await?.into_inner().try_into()
    }

    /// The surface of a twin for the eye, which its file need not have.
    ///
    /// # Errors
    /// If the twin does not exist or has too few points, or the server cannot be asked.
    pub async fn surface(&self, name: TwinId) -> Result<Surface, Error> {
        let request = GetTwinSurfaceRequest { name: name.to_string() };
        surface::read(self.service.clone().get_twin_surface(request).await?.into_inner())
    }

    /// Moves a twin to the trash.
    ///
    /// # Errors
    /// If the twin does not exist, or the server cannot be asked.
    pub async fn delete(&self, name: TwinId) -> Result<(), Error> {
        self.remove(name, false).await
    }

    /// Deletes a twin for good, in the trash or not.
    ///
    /// # Errors
    /// If the twin does not exist, or the server cannot be asked.
    pub async fn purge(&self, name: TwinId) -> Result<(), Error> {
        self.remove(name, true).await
    }

    async fn remove(&self, name: TwinId, purge: bool) -> Result<(), Error> {
        let request = DeleteTwinRequest { name: name.to_string(), purge };
        self.service.clone().delete_twin(request).await?;
        Ok(())
    }

    /// The twin file, checked against its digest.
    ///
    /// # Errors
    /// If the twin does not exist, it arrives damaged, or the server cannot be asked.
    pub async fn export(&self, name: TwinId) -> Result<Vec<u8>, Error> {
        let digest = self.get(name).await?.digest;
        let request = ExportTwinRequest { name: name.to_string() };
        let mut chunks = self.service.clone().export_twin(request).await?.into_inner();
        let mut file = Vec::new();
        while let Some(part) = chunks.message().await? {
            file.extend_from_slice(&part.chunk);
        }
        if blake3::hash(&file).to_hex().as_str() != digest {
            let message = format!("{name} arrived damaged: its digest is not {digest}");
            return Err(Error::new(Category::DataLoss, "DIGEST_MISMATCH", message));
        }
        Ok(file)
    }

    /// The twin itself, ready to be inspected or simulated.
    ///
    /// # Errors
    /// Those of [`Twins::export`], and if this build cannot read the file.
    pub async fn download(&self, name: TwinId) -> Result<TwinModel, Error> {
        let file = self.export(name).await?;
        TwinModel::decode(&file).map_err(Error::malformed)
    }

    /// Stores a twin file that was exported elsewhere.
    ///
    /// # Errors
    /// If it is no twin file, or the server cannot be asked.
    pub async fn import(&self, file: Vec<u8>, display_name: &str) -> Result<Twin, Error> {
        let metadata = TwinMetadata {
            display_name: display_name.to_owned(),
            request_id: Uuid::new_v4().to_string(),
            digest: blake3::hash(&file).to_hex().to_string(),
        };
        let file = Bytes::from(file);
        let chunks = (0..file.len()).step_by(CHUNK).map(move |start| {
            let end = (start + CHUNK).min(file.len());
            CreateTwinRequest { part: Some(Part::Chunk(file.slice(start..end))) }
        });
        let first = CreateTwinRequest { part: Some(Part::Metadata(metadata)) };
        let parts = futures::stream::iter(std::iter::once(first).chain(chunks));
        self.service.clone().create_twin(parts).await?.into_inner().try_into()
    }
}

//! Products of ingests: the observation, which fits read, the playback, which a player shows, and the
//! masks that were made of strokes. One row each for a capture; an ingest that succeeds replaces all,
//! one that is refused those that it made.

use std::collections::HashSet;

use bendtwin_core::ids::CaptureId;

use crate::{
    Captures, Content, Digest, Error, Result,
    sql::{Builder, Transaction, row::row},
};

/// A product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Product {
    Observation,
    Playback,
    Masks,
}

impl Product {
    /// All products.
    pub(crate) const ALL: [Self; 3] = [Self::Observation, Self::Playback, Self::Masks];

    fn table(self) -> &'static str {
        match self {
            Self::Observation => "observations",
            Self::Playback => "playbacks",
            Self::Masks => "masks",
        }
    }
}

row! {
    struct Row {
        size_bytes: i64,
        digest: String,
    }
}

impl Captures<'_> {
    /// The playback of a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is no such capture, [`Error::PlaybackMissing`] if it has none,
    /// [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn playback_content(&self, id: CaptureId) -> Result<Content> {
        let found = self.product(id, Product::Playback, "playback").await?;
        found.ok_or_else(|| Error::PlaybackMissing { name: id.to_string() })
    }

    /// The digest of the playback of a capture; its content is not opened.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is no such capture, [`Error::PlaybackMissing`] if it has none.
    pub async fn playback_digest(&self, id: CaptureId) -> Result<Digest> {
        let row = self.row(id, Product::Playback).await?;
        self.require(id).await?;
        let row = row.ok_or_else(|| Error::PlaybackMissing { name: id.to_string() })?;
        read_digest(&row.digest, &format!("the playback of {id}"))
    }

    /// The masks that the last ingest of a capture made of strokes.
    ///
    /// # Errors
    /// [`Error::NotFound`] if there is no such capture, [`Error::MasksMissing`] if it has none,
    /// [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn masks_content(&self, id: CaptureId) -> Result<Content> {
        let found = self.product(id, Product::Masks, "masks").await?;
        found.ok_or_else(|| Error::MasksMissing { name: id.to_string() })
    }

    /// The digest of the masks of a capture, if it has some.
    ///
    /// # Errors
    /// Database errors.
    pub async fn masks_digest(&self, id: CaptureId) -> Result<Option<Digest>> {
        let row = self.row(id, Product::Masks).await?;
        row.map(|row| read_digest(&row.digest, &format!("the masks of {id}"))).transpose()
    }

    /// Those of these captures that have masks, by their keys.
    pub(crate) async fn with_masks(&self, captures: &[String]) -> Result<HashSet<String>> {
        let mut sql = Builder::new("select capture from masks where capture in (");
        sql.push_list(captures).push(")");
        let rows: Vec<(String,)> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        Ok(rows.into_iter().map(|(capture,)| capture).collect())
    }

    async fn product(
        &self,
        id: CaptureId,
        product: Product,
        name: &str,
    ) -> Result<Option<Content>> {
        let row = self.row(id, product).await?;
        self.require(id).await?;
        let Some(row) = row else { return Ok(None) };
        let name = format!("the {name} of {id}");
        let digest = read_digest(&row.digest, &name)?;
        let size_bytes = u64::try_from(row.size_bytes).unwrap_or_default();
        self.store.blobs().read(&digest, Some(size_bytes), &name).await.map(Some)
    }

    async fn row(&self, id: CaptureId, product: Product) -> Result<Option<Row>> {
        let mut sql = Builder::new("select size_bytes, digest from ");
        sql.push(product.table()).push(" where capture = ").push_bind(id.uuid().to_string());
        sql.build().fetch_optional(self.store.inner.database.read()).await
    }
}

fn read_digest(hex: &str, name: &str) -> Result<Digest> {
    Digest::from_hex(hex)
        .map_err(|_| Error::CorruptRow { name: name.to_owned(), fault: "digest".to_owned() })
}

/// The digest of a product of a capture, within a transaction.
pub(crate) async fn digest_of(
    tx: &mut Transaction,
    product: Product,
    capture: &str,
) -> Result<Option<String>> {
    let mut sql = Builder::new("select digest from ");
    sql.push(product.table()).push(" where capture = ").push_bind(capture);
    let row: Option<(String,)> = sql.build().fetch_optional(tx).await?;
    Ok(row.map(|(digest,)| digest))
}

/// Replaces the row of a capture, or removes it where nothing new was made. Returns the content that
/// is obsolete afterwards.
pub(crate) async fn replace(
    tx: &mut Transaction,
    product: Product,
    capture: &str,
    made: Option<(Digest, u64)>,
    now: i64,
) -> Result<Option<String>> {
    let obsolete = forget(tx, product, capture).await?;
    if let Some((digest, size_bytes)) = made {
        let mut sql = Builder::new("insert into ");
        sql.push(product.table()).push(" (capture, created_at, size_bytes, digest) values (");
        sql.push_bind(capture).push(", ").push_bind(now).push(", ");
        sql.push_bind(i64::try_from(size_bytes).unwrap_or(i64::MAX)).push(", ");
        sql.push_bind(digest.to_hex().as_str()).push(")");
        sql.build().execute(&mut *tx).await?;
    }
    Ok(obsolete)
}

/// Removes the row of a capture. Returns the content that is obsolete afterwards.
pub(crate) async fn forget(
    tx: &mut Transaction,
    product: Product,
    capture: &str,
) -> Result<Option<String>> {
    let mut sql = Builder::new("delete from ");
    sql.push(product.table()).push(" where capture = ").push_bind(capture);
    sql.push(" returning digest");
    let row: Option<(String,)> = sql.build().fetch_optional(tx).await?;
    Ok(row.map(|(digest,)| digest))
}

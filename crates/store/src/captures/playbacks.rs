//! Playbacks: what a player shows of captures, made beside their observations. One row for each
//! capture that was read since there are any; an ingest that succeeds replaces it.

use bendtwin_core::ids::CaptureId;

use crate::{
    Captures, Content, Digest, Error, Result,
    sql::{Transaction, query, query_scalar, row::row},
};

row! {
    struct PlaybackRow {
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
        let row: Option<PlaybackRow> =
            query("select size_bytes, digest from playbacks where capture = $1")
                .bind(id.uuid().to_string())
                .fetch_optional(self.store.inner.database.read())
                .await?;
        let Some(row) = row else {
            self.get(id).await?;
            return Err(Error::PlaybackMissing { name: id.to_string() });
        };
        let name = format!("the playback of {id}");
        let digest = Digest::from_hex(&row.digest)
            .map_err(|_| Error::CorruptRow { name: name.clone(), fault: "digest".to_owned() })?;
        let size_bytes = u64::try_from(row.size_bytes).unwrap_or_default();
        self.store.blobs().read(&digest, Some(size_bytes), &name).await
    }
}

/// Replaces the row of a capture, or removes it where nothing new was made. Returns the content that
/// is obsolete afterwards.
pub(crate) async fn replace(
    tx: &mut Transaction,
    capture: &str,
    made: Option<(Digest, u64)>,
    now: i64,
) -> Result<Option<String>> {
    let obsolete = forget(tx, capture).await?;
    if let Some((digest, size_bytes)) = made {
        query(
            "insert into playbacks (capture, created_at, size_bytes, digest)
             values ($1, $2, $3, $4)",
        )
        .bind(capture)
        .bind(now)
        .bind(i64::try_from(size_bytes).unwrap_or(i64::MAX))
        .bind(digest.to_hex().as_str())
        .execute(&mut *tx)
        .await?;
    }
    Ok(obsolete)
}

/// Removes the row of a capture. Returns the content that is obsolete afterwards.
pub(crate) async fn forget(tx: &mut Transaction, capture: &str) -> Result<Option<String>> {
    let digest = query_scalar("delete from playbacks where capture = $1 returning digest")
        .bind(capture)
        .fetch_optional(&mut *tx)
        .await?;
    Ok(digest)
}

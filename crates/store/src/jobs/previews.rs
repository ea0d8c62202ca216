//! The newest preview of a fit: what it has so far, kept as its worker reports it so that every server
//! can show it. It goes when the fit has a twin, or is deleted.

use bendtwin_core::ids::FitId;
use jiff::Timestamp;

use super::{Jobs, row::Row};
use crate::{
    Error, Result,
    sql::{Transaction, query, row::row},
    store::clock::from_micros,
};

/// A preview.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredPreview {
    /// Text of the server that stored it.
    pub content: String,
    /// Time at which it came.
    pub created: Timestamp,
}

row! {
    struct PreviewRow {
        content: String,
        created_at: i64,
    }
}

impl Jobs<'_> {
    /// The newest preview of a fit.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::PreviewMissing`].
    pub async fn preview(&self, fit: FitId) -> Result<StoredPreview> {
        let row: Option<PreviewRow> =
            query("select content, created_at from previews where fit = $1")
                .bind(fit.uuid().to_string())
                .fetch_optional(self.store.inner.database.read())
                .await?;
        self.get(fit).await?;
        let row = row.ok_or_else(|| Error::PreviewMissing { name: fit.to_string() })?;
        Ok(StoredPreview { content: row.content, created: from_micros(row.created_at) })
    }

    /// Stores the preview of a running fit, whose row this is, in place of the one before.
    pub(super) async fn record_preview(
        &self,
        tx: &mut Transaction,
        row: &Row,
        content: &str,
    ) -> Result<()> {
        query(
            "insert into previews (fit, created_at, content) values ($1, $2, $3)
             on conflict (fit) do update set created_at = excluded.created_at,
                 content = excluded.content",
        )
        .bind(&row.id)
        .bind(self.store.now_micros())
        .bind(content)
        .execute(tx)
        .await?;
        Ok(())
    }
}

/// Drops the preview of a fit.
pub(super) async fn forget(tx: &mut Transaction, fit: &str) -> Result<()> {
    query("delete from previews where fit = $1").bind(fit).execute(tx).await?;
    Ok(())
}

#[cfg(test)]
mod tests;

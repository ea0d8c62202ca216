//! Captures: immutable content with a name.

use bendtwin_core::ids::CaptureId;
use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use crate::{
    Content, Digest, Error, Page, PageRequest, Result, Staged, Store, clock::from_micros,
    failpoint::Failpoint, uploads,
};

/// A stored capture.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// Its id.
    pub id: CaptureId,
    /// A person's name for it.
    pub display_name: String,
    /// When it was stored.
    pub created: Timestamp,
    /// Size of the archive.
    pub size_bytes: u64,
    /// BLAKE3 of the archive.
    pub digest: Digest,
}

/// A capture to be stored.
#[derive(Debug)]
pub struct NewCapture {
    /// A person's name for it.
    pub display_name: String,
    /// Makes creation idempotent, if given.
    pub request_id: Option<String>,
    /// The archive.
    pub content: Staged,
}

/// The captures of a store.
#[derive(Clone, Copy, Debug)]
pub struct Captures<'a> {
    pub(crate) store: &'a Store,
}

#[derive(FromRow)]
struct Row {
    id: String,
    display_name: String,
    created_at: i64,
    size_bytes: i64,
    digest: String,
}

impl TryFrom<Row> for Capture {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let corrupt = |fault: &str| Error::CorruptRow {
            name: format!("captures/{}", row.id),
            fault: fault.to_owned(),
        };
        Ok(Self {
            id: Uuid::try_parse(&row.id).map_err(|_| corrupt("id"))?.into(),
            display_name: row.display_name.clone(),
            created: from_micros(row.created_at),
            size_bytes: row.size_bytes.max(0) as u64,
            digest: Digest::from_hex(&row.digest).map_err(|_| corrupt("digest"))?,
        })
    }
}

impl Captures<'_> {
    /// Stores a capture. The same request id with the same content and name
    /// gives the capture that it made before.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`], database and file errors.
    pub async fn create(&self, new: NewCapture) -> Result<Capture> {
        let NewCapture { display_name, request_id, content } = new;
        let (digest, size_bytes) = (content.digest(), content.size_bytes());
        let upload = content.upload();
        let guard = self.store.blobs().publish(content).await?;
        let mut tx = self.store.inner.database.write().await?;
        if let Some(request_id) = &request_id {
            let row: Option<Row> = sqlx::query_as("select * from captures where request_id = $1")
                .bind(request_id)
                .fetch_optional(&mut *tx)
                .await?;
            if let Some(row) = row {
                let before = Capture::try_from(row)?;
                if before.digest == digest && before.display_name == display_name {
                    if let Some(upload) = upload {
                        uploads::stored(&mut tx, upload, before.id).await?;
                        tx.commit().await?;
                    }
                    return Ok(before);
                }
                drop((tx, guard));
                self.store.release(&digest.to_hex()).await?;
                let (request_id, name) = (request_id.clone(), before.id.to_string());
                return Err(Error::RequestIdTaken { request_id, name });
            }
        }
        let id = CaptureId::generate();
        let row: Row = sqlx::query_as(
            "insert into captures (id, display_name, created_at, size_bytes, digest, request_id)
             values ($1, $2, $3, $4, $5, $6) returning *",
        )
        .bind(id.uuid().to_string())
        .bind(display_name)
        .bind(self.store.now_micros())
        .bind(i64::try_from(size_bytes).unwrap_or(i64::MAX))
        .bind(digest.to_hex().as_str())
        .bind(request_id)
        .fetch_one(&mut *tx)
        .await?;
        if let Some(upload) = upload {
            uploads::stored(&mut tx, upload, id).await?;
        }
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        drop(guard);
        self.store.pass(Failpoint::AfterCommit)?;
        row.try_into()
    }

    /// One capture.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: CaptureId) -> Result<Capture> {
        let row: Option<Row> = sqlx::query_as("select * from captures where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// A page of captures, newest first.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(&self, page: &PageRequest) -> Result<Page<Capture>> {
        const LISTING: &str = "captures";
        let rows: Vec<Row> =
            sqlx::query_as("select * from captures where id < $1 order by id desc limit $2")
                .bind(page.before(LISTING)?)
                .bind(page.fetch())
                .fetch_all(self.store.inner.database.read())
                .await?;
        let items = rows.into_iter().map(Capture::try_from).collect::<Result<_>>()?;
        Ok(Page::cut(items, page, LISTING, |c: &Capture| c.id.uuid()))
    }

    /// The archive of a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::ContentLost`].
    pub async fn content(&self, id: CaptureId) -> Result<(Capture, Content)> {
        let capture = self.get(id).await?;
        let content = self.store.blobs().read(&capture.digest, &id.to_string()).await?;
        Ok((capture, content))
    }

    /// Deletes a capture. Its twins and ended fits stay.
    ///
    /// # Errors
    /// [`Error::NotFound`]; [`Error::CaptureInUse`] while fits of it are queued or running.
    pub async fn delete(&self, id: CaptureId) -> Result<()> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let fits: i64 = sqlx::query_scalar(
            "select count(*) from jobs where capture = $1 and state in ('queued', 'running')",
        )
        .bind(&key)
        .fetch_one(&mut *tx)
        .await?;
        if fits > 0 {
            return Err(Error::CaptureInUse { name: id.to_string(), fits: fits as u64 });
        }
        let digest: Option<String> =
            sqlx::query_scalar("delete from captures where id = $1 returning digest")
                .bind(&key)
                .fetch_optional(&mut *tx)
                .await?;
        let digest = digest.ok_or_else(|| Error::NotFound { name: id.to_string() })?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.store.pass(Failpoint::BeforeRelease)?;
        self.store.release(&digest).await
    }
}

#[cfg(test)]
mod tests;

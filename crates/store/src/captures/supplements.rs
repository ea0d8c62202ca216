//! Supplements: files that were added to captures after their upload, one of each kind. The next
//! ingest reads them beside the archive, which does not change.

use std::{fmt, str::FromStr};

use bendtwin_core::ids::CaptureId;
use jiff::Timestamp;

use crate::{
    Captures, Content, Creator, Digest, Error, Result, Staged,
    failpoint::Failpoint,
    jobs,
    keys::quotas::{self, More, reservation::Reservation},
    sql::{Builder, Transaction, query, query_scalar, row::row},
    store::clock::from_micros,
};

/// Kind of a supplement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SupplementKind {
    /// An archive of masks, in place of those of the recording.
    Masks,
    /// A calibration document, in place of the recording's own calibration.
    Calibration,
}

/// A word that is no kind of supplement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownKind;

impl SupplementKind {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Masks, Self::Calibration];

    /// Name of the kind in the database and in the API.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Masks => "masks",
            Self::Calibration => "calibration",
        }
    }
}

impl fmt::Display for SupplementKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for SupplementKind {
    type Err = UnknownKind;
    fn from_str(word: &str) -> Result<Self, UnknownKind> {
        Self::ALL.into_iter().find(|kind| kind.as_str() == word).ok_or(UnknownKind)
    }
}

/// A file that was added to a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supplement {
    /// Kind of the file.
    pub kind: SupplementKind,
    /// Time of storage.
    pub created: Timestamp,
    /// Size of the file [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of the file.
    pub digest: Digest,
}

/// A file to be added to a capture.
#[derive(Debug)]
pub struct NewSupplement {
    /// The capture.
    pub capture: CaptureId,
    /// Kind of the file.
    pub kind: SupplementKind,
    /// The file.
    pub content: Staged,
    /// The one who adds it.
    pub creator: Creator,
}

row! {
    struct Row {
        capture: String,
        kind: String,
        created_at: i64,
        size_bytes: i64,
        digest: String,
    }
}

impl Row {
    /// The supplement; none of a kind that only a newer version knows.
    fn read(&self) -> Result<Option<Supplement>> {
        let Ok(kind) = self.kind.parse() else { return Ok(None) };
        let digest = Digest::from_hex(&self.digest).map_err(|_| Error::CorruptRow {
            name: format!("captures/{}/supplements/{}", self.capture, self.kind),
            fault: "digest".to_owned(),
        })?;
        let size_bytes = self.size_bytes.max(0) as u64;
        let created = from_micros(self.created_at);
        Ok(Some(Supplement { kind, created, size_bytes, digest }))
    }
}

fn name_of(capture: CaptureId, kind: SupplementKind) -> String {
    format!("{capture}/supplements/{kind}")
}

impl Captures<'_> {
    /// The supplements of a capture, in the order of their kinds.
    ///
    /// # Errors
    /// Database errors.
    pub async fn supplements(&self, id: CaptureId) -> Result<Vec<Supplement>> {
        let key = id.uuid().to_string();
        let found = self.supplements_of(&[key]).await?;
        Ok(found.into_iter().map(|(_, supplement)| supplement).collect())
    }

    /// The supplements of these captures, by the captures' keys and in the order of their kinds.
    pub(crate) async fn supplements_of(
        &self,
        captures: &[String],
    ) -> Result<Vec<(String, Supplement)>> {
        let mut sql = Builder::new("select * from supplements where capture in (");
        sql.push_list(captures).push(")");
        let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        let mut found = Vec::with_capacity(rows.len());
        for row in rows {
            found.extend(row.read()?.map(|supplement| (row.capture, supplement)));
        }
        found.sort_by_key(|(_, supplement)| supplement.kind);
        Ok(found)
    }

    /// A file that was added to a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`] without one, [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn supplement_content(&self, id: CaptureId, kind: SupplementKind) -> Result<Content> {
        let name = name_of(id, kind);
        self.require(id).await?;
        let found = self.supplements(id).await?.into_iter().find(|found| found.kind == kind);
        let supplement = found.ok_or_else(|| Error::NotFound { name: name.clone() })?;
        self.store.blobs().read(&supplement.digest, Some(supplement.size_bytes), &name).await
    }

    /// Refuses a supplement before its content is received, if any content would be refused. While a
    /// job of the capture is under way, only a repetition may succeed: of content that is stored
    /// already.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::IngestUnderWay`], [`Error::CaptureInUse`], [`Error::DiskFull`].
    pub async fn admit_supplement(&self, id: CaptureId, kind: SupplementKind) -> Result<()> {
        self.store.admit()?;
        self.get(id).await?;
        if self.supplements(id).await?.iter().any(|stored| stored.kind == kind) {
            return Ok(());
        }
        let mut tx = self.store.inner.database.write().await?;
        jobs::require_idle(&mut tx, id).await
    }

    /// Adds a file to a capture in place of the one of its kind. The same content again changes
    /// nothing.
    ///
    /// # Errors
    /// [`Error::NotFound`]; [`Error::IngestUnderWay`] and [`Error::CaptureInUse`] while an ingest or
    /// fits of the capture are queued or running: they are not to see two recordings;
    /// [`Error::QuotaBytes`], [`Error::DiskFull`], database and file errors.
    pub async fn add_supplement(&self, new: NewSupplement) -> Result<()> {
        self.store.admit()?;
        let NewSupplement { capture, kind, mut content, creator } = new;
        let (digest, size_bytes) = (content.digest(), content.size_bytes());
        let reservation = content.take_reservation();
        let guard = self.store.publish(content).await?;
        let stored =
            self.refer(capture, kind, (digest, size_bytes), &creator, reservation.as_ref()).await;
        drop(guard);
        let obsolete = match &stored {
            Ok(replaced) => replaced.clone(),
            Err(Error::Failpoint(_)) => None,
            Err(_) => Some(digest.to_hex().to_string()),
        };
        if stored.is_ok() {
            self.store.pass(Failpoint::AfterCommit)?;
            self.store.pass(Failpoint::BeforeRelease)?;
        }
        if let Some(obsolete) = obsolete {
            self.store.release(&obsolete).await?;
        }
        stored.map(drop)
    }

    /// The transaction of [`Captures::add_supplement`]. Returns the digest of the content that it
    /// replaced.
    async fn refer(
        &self,
        capture: CaptureId,
        kind: SupplementKind,
        (digest, size_bytes): (Digest, u64),
        creator: &Creator,
        reservation: Option<&Reservation>,
    ) -> Result<Option<String>> {
        let key = capture.uuid().to_string();
        let digest = digest.to_hex();
        let mut tx = self.store.inner.database.write().await?;
        let stored: Option<String> =
            query_scalar("select digest from supplements where capture = $1 and kind = $2")
                .bind(&key)
                .bind(kind.as_str())
                .fetch_optional(&mut tx)
                .await?;
        if stored.as_deref() == Some(digest.as_str()) {
            return Ok(None);
        }
        jobs::require_idle(&mut tx, capture).await?;
        // The replaced one counts no more.
        remove(&mut tx, &key, kind).await?;
        let held = reservation.map(Reservation::held);
        let more = More { jobs: 0, bytes: size_bytes, held };
        quotas::require(&mut tx, creator, more).await?;
        query(
            "insert into supplements (capture, kind, created_at, size_bytes, digest, owner)
             values ($1, $2, $3, $4, $5, $6)",
        )
        .bind(&key)
        .bind(kind.as_str())
        .bind(self.store.now_micros())
        .bind(i64::try_from(size_bytes).unwrap_or(i64::MAX))
        .bind(digest.as_str())
        .bind(&creator.owner)
        .execute(&mut tx)
        .await?;
        if let Some(reservation) = reservation {
            reservation.settle(&mut tx).await?;
        }
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        Ok(stored)
    }

    /// Removes a file from a capture.
    ///
    /// # Errors
    /// [`Error::NotFound`] without one; [`Error::IngestUnderWay`], [`Error::CaptureInUse`].
    pub async fn delete_supplement(&self, id: CaptureId, kind: SupplementKind) -> Result<()> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        jobs::require_idle(&mut tx, id).await?;
        let digest = remove(&mut tx, &key, kind).await?;
        let digest = digest.ok_or_else(|| Error::NotFound { name: name_of(id, kind) })?;
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        self.store.pass(Failpoint::BeforeRelease)?;
        self.store.release(&digest).await
    }
}

/// Removes the row of a supplement. Returns the content that is obsolete afterwards.
async fn remove(
    tx: &mut Transaction,
    capture: &str,
    kind: SupplementKind,
) -> Result<Option<String>> {
    query_scalar("delete from supplements where capture = $1 and kind = $2 returning digest")
        .bind(capture)
        .bind(kind.as_str())
        .fetch_optional(tx)
        .await
}

/// Removes all rows of a capture. Returns the content that is obsolete afterwards.
pub(super) async fn forget(tx: &mut Transaction, capture: &str) -> Result<Vec<String>> {
    query_scalar("delete from supplements where capture = $1 returning digest")
        .bind(capture)
        .fetch_all(tx)
        .await
}

#[cfg(test)]
mod tests;

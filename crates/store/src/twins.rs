//! Twins: content with the facts that listings show. A twin is made by
//! importing a file or by completing a fit ([`crate::Jobs::complete_fit`]).

use bendtwin_core::ids::{CaptureId, FitId, TwinId};
use jiff::Timestamp;

use uuid::Uuid;

use crate::{
    Content, Creator, Digest, Error, LabelChange, Labels, ListQuery, Page, Result, Staged, Store,
    failpoint::Failpoint,
    keys::quotas::{self, More, reservation::Reservation},
    labels::{self, Collection},
    owners::deleted_requests::{self, Kind},
    owners::request_ids::{self, RequestId},
    sql::{Transaction, query, row::row},
    store::clock::from_micros,
    trash::{self, Remove},
};

/// Facts of a twin, read from its file, for listings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TwinFacts {
    /// Number of nodes N.
    pub node_count: u32,
    /// Number of springs E.
    pub spring_count: u32,
    /// Number of triplets T.
    pub triplet_count: u32,
    /// Number of control points C.
    pub control_count: u32,
    /// Number of frames per second.
    pub fps: f64,
    /// Number of substeps per frame.
    pub substeps: u32,
    /// The quality table as JSON.
    pub quality: String,
    /// Mass of the object, if it is known [kg].
    pub mass_kg: Option<f64>,
    /// Number of points of the skin; none of a twin that was stored before it was counted, whose
    /// skin is its surface nodes.
    pub skin_point_count: Option<u32>,
}

/// A stored twin.
#[derive(Clone, Debug, PartialEq)]
pub struct Twin {
    /// Id of the twin.
    pub id: TwinId,
    /// Display name, note and tags.
    pub labels: Labels,
    /// The capture that it was fitted to; none if imported.
    pub capture: Option<CaptureId>,
    /// The fit that made it; none if imported.
    pub fit: Option<FitId>,
    /// Time of storage.
    pub created: Timestamp,
    /// Size of the twin file [bytes].
    pub size_bytes: u64,
    /// BLAKE3 of the twin file.
    pub digest: Digest,
    /// Facts from its file.
    pub facts: TwinFacts,
    /// Error over frames that it was not fitted to, if there is one [m].
    pub error_m: Option<f64>,
    /// Owner of its fit, or of the key with which it was imported; empty if that is not known.
    pub owner: String,
}

/// A twin to be imported.
#[derive(Debug)]
pub struct NewTwin {
    /// Display name.
    pub display_name: String,
    /// Idempotency key, if given.
    pub request_id: Option<String>,
    /// Facts from its file.
    pub facts: TwinFacts,
    /// The twin file.
    pub content: Staged,
    /// The importer.
    pub creator: Creator,
}

/// The twins of a store.
#[derive(Clone, Copy, Debug)]
pub struct Twins<'a> {
    pub(crate) store: &'a Store,
}

row! {
    pub(crate) struct Row {
        id: String,
        display_name: String,
        capture: Option<String>,
        fit: Option<String>,
        created_at: i64,
        size_bytes: i64,
        digest: String,
        node_count: i64,
        spring_count: i64,
        triplet_count: i64,
        control_count: i64,
        fps: f64,
        substeps: i64,
        quality: String,
        mass_kg: Option<f64>,
        skin_point_count: Option<i64>,
        note: String,
        tags: String,
        first_name: Option<String>,
        error_m: f64,
        owner: String,
        trashed_at: Option<i64>,
        purge_at: Option<i64>,
    }
}

impl Row {
    /// The name that it was created with.
    fn first_name(&self) -> &str {
        self.first_name.as_ref().unwrap_or(&self.display_name)
    }

    /// The twin, if the request that made it is this one.
    fn repeated(self, request: RequestId<'_>, display_name: &str, digest: Digest) -> Result<Twin> {
        let same_name = self.first_name() == display_name;
        let before = Twin::try_from(self)?;
        request.require_same(before.digest == digest && same_name, before.id)?;
        Ok(before)
    }
}

impl TryFrom<Row> for Twin {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let corrupt = |fault: &str| Error::CorruptRow {
            name: format!("twins/{}", row.id),
            fault: fault.to_owned(),
        };
        let uuid = |text: &String| Uuid::try_parse(text).map_err(|_| corrupt("an id"));
        let count = |n: i64| u32::try_from(n).unwrap_or(u32::MAX);
        let id: TwinId = uuid(&row.id)?.into();
        trash::refuse(id, row.trashed_at, row.purge_at)?;
        Ok(Self {
            id,
            capture: row.capture.as_ref().map(uuid).transpose()?.map(Into::into),
            fit: row.fit.as_ref().map(uuid).transpose()?.map(Into::into),
            created: from_micros(row.created_at),
            size_bytes: row.size_bytes.max(0) as u64,
            digest: Digest::from_hex(&row.digest).map_err(|_| corrupt("digest"))?,
            facts: TwinFacts {
                node_count: count(row.node_count),
                spring_count: count(row.spring_count),
                triplet_count: count(row.triplet_count),
                control_count: count(row.control_count),
                fps: row.fps,
                substeps: count(row.substeps),
                quality: row.quality,
                mass_kg: row.mass_kg,
                skin_point_count: row.skin_point_count.map(count),
            },
            labels: Labels::of_row(row.display_name, row.note, &row.tags),
            error_m: labels::error_of(row.error_m),
            owner: row.owner,
        })
    }
}

/// A row to be inserted.
pub(crate) struct Insert<'a> {
    pub(crate) display_name: &'a str,
    pub(crate) origin: Option<(&'a str, &'a str)>,
    pub(crate) size_bytes: u64,
    pub(crate) digest: Digest,
    pub(crate) facts: &'a TwinFacts,
    pub(crate) request_id: Option<&'a str>,
    pub(crate) owner: &'a str,
    pub(crate) now: i64,
}

/// Inserts a twin within the caller's transaction.
pub(crate) async fn insert(tx: &mut Transaction, new: Insert<'_>) -> Result<Twin> {
    let facts = new.facts;
    let row: Row = query(
        "insert into twins (id, display_name, capture, fit, created_at, size_bytes, digest,
             node_count, spring_count, triplet_count, control_count, fps, substeps, quality,
             request_id, mass_kg, skin_point_count, name_key, search_text, error_m, level, owner)
         values ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18,
             $19, $20, $21, $22)
         returning *",
    )
    .bind(TwinId::generate().uuid().to_string())
    .bind(new.display_name)
    .bind(new.origin.map(|(capture, _)| capture))
    .bind(new.origin.map(|(_, fit)| fit))
    .bind(new.now)
    .bind(i64::try_from(new.size_bytes).unwrap_or(i64::MAX))
    .bind(new.digest.to_hex().as_str())
    .bind(i64::from(facts.node_count))
    .bind(i64::from(facts.spring_count))
    .bind(i64::from(facts.triplet_count))
    .bind(i64::from(facts.control_count))
    .bind(facts.fps)
    .bind(i64::from(facts.substeps))
    .bind(&facts.quality)
    .bind(new.request_id)
    .bind(facts.mass_kg)
    .bind(facts.skin_point_count.map(i64::from))
    .bind(labels::name_key(new.display_name))
    .bind(labels::search_text(new.display_name, ""))
    .bind(labels::error_key(&facts.quality))
    .bind(labels::level(&facts.quality))
    .bind(new.owner)
    .fetch_one(&mut *tx)
    .await?;
    row.try_into()
}

impl Twins<'_> {
    /// True if there is a twin that was imported under a request id.
    ///
    /// # Errors
    /// Database errors.
    pub async fn has_requested(&self, owner: &str, request_id: &str) -> Result<bool> {
        let request = RequestId { owner, id: request_id };
        let row: Option<Row> = request.find(self.store.inner.database.read(), "*", "twins").await?;
        Ok(row.is_some())
    }

    /// The twin that the same request imported before, by the digest of its file. Nothing else is
    /// made.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`] if that has other content or another name,
    /// [`Error::DeletedSince`].
    pub async fn repeated(
        &self,
        owner: &str,
        request_id: &str,
        name: &str,
        digest: Digest,
    ) -> Result<Twin> {
        let request = RequestId { owner, id: request_id };
        let row: Option<Row> = request.find(self.store.inner.database.read(), "*", "twins").await?;
        match row {
            Some(row) => row.repeated(request, name, digest),
            None => Err(self.store.vanished(Kind::Twins, request).await),
        }
    }

    /// Stores an imported twin. The same request id with the same content and name returns the twin
    /// created before.
    ///
    /// # Errors
    /// [`Error::RequestIdTaken`], [`Error::DeletedSince`], [`Error::QuotaBytes`],
    /// [`Error::DiskFull`], database and file errors.
    pub async fn create(&self, new: NewTwin) -> Result<Twin> {
        self.store.admit()?;
        let NewTwin { display_name, request_id, facts, mut content, creator } = new;
        let (digest, size_bytes) = (content.digest(), content.size_bytes());
        let reservation = content.take_reservation();
        let guard = self.store.publish(content).await?;
        let mut tx = self.store.inner.database.write().await?;
        let request = RequestId::of(&creator.owner, request_id.as_deref());
        if let Some(request) = request
            && let Some(row) = request.find::<Row>(&mut tx, "*", "twins").await?
        {
            drop((tx, guard));
            let before = row.repeated(request, &display_name, digest);
            if before.is_err() {
                self.store.release(&digest.to_hex()).await?;
            }
            return before;
        }
        let held = reservation.as_ref().map(Reservation::held);
        let more = More { jobs: 0, bytes: size_bytes, held };
        let admitted = async {
            deleted_requests::refuse(&mut tx, Kind::Twins, request, None).await?;
            quotas::require(&mut tx, &creator, more).await
        }
        .await;
        if let Err(error) = admitted {
            drop((tx, guard));
            self.store.release(&digest.to_hex()).await?;
            return Err(error);
        }
        let request_id = request_ids::text_in(request, &mut tx, "twins").await?;
        let new = Insert {
            display_name: &display_name,
            origin: None,
            size_bytes,
            digest,
            facts: &facts,
            request_id: request_id.as_deref(),
            owner: &creator.owner,
            now: self.store.now_micros(),
        };
        let twin = insert(&mut tx, new).await?;
        if let Some(reservation) = &reservation {
            reservation.settle(&mut tx).await?;
        }
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        drop(guard);
        if let Some(reservation) = reservation {
            reservation.settled();
        }
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(twin)
    }

    /// Returns a twin.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: TwinId) -> Result<Twin> {
        let row: Option<Row> = query("select * from twins where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// A page of twins.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(&self, query: &ListQuery) -> Result<Page<Twin>> {
        let rows: Vec<Row> = query
            .select(Collection::Twins)?
            .build()
            .fetch_all(self.store.inner.database.read())
            .await?;
        let items = rows.into_iter().map(Twin::try_from).collect::<Result<_>>()?;
        let listing = query.listing(Collection::Twins);
        let page = Page::cut(items, &query.page, &listing, |t: &Twin| {
            let name_key = labels::name_key(&t.labels.display_name);
            (t.id.uuid(), query.key(&name_key, labels::key_of(t.error_m)))
        });
        Ok(page.of(query.total(self.store, Collection::Twins).await?))
    }

    /// Changes name, note and tags of a twin.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::TooManyTags`].
    pub async fn update(&self, id: TwinId, change: &LabelChange) -> Result<Twin> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let find = "select * from twins where id = $1";
        let row: Option<Row> = query(find).bind(&key).fetch_optional(&mut tx).await?;
        let row = row.ok_or_else(|| Error::NotFound { name: id.to_string() })?;
        let before = Twin::try_from(row)?.labels;
        labels::change(&mut tx, Collection::Twins, &key, &before, change).await?;
        let row: Row = query(find).bind(&key).fetch_one(&mut tx).await?;
        tx.commit().await?;
        row.try_into()
    }

    /// The file of a twin.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::ContentLost`], [`Error::ContentDamaged`].
    pub async fn content(&self, id: TwinId) -> Result<(Twin, Content)> {
        let twin = self.get(id).await?;
        let content =
            self.store.blobs().read(&twin.digest, Some(twin.size_bytes), &id.to_string()).await?;
        Ok((twin, content))
    }

    /// Deletes a twin for good, also one in the trash. Its request id makes no other for a day.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn delete(&self, id: TwinId) -> Result<()> {
        self.remove(id, Remove::Any).await
    }

    /// Deletes a twin for good if it is one of these.
    pub(crate) async fn remove(&self, id: TwinId, which: Remove) -> Result<()> {
        let key = id.uuid().to_string();
        let mut tx = self.store.inner.database.write().await?;
        let deleted: Option<(String, Option<String>, String)> = query(
            "delete from twins where id = $1 and ($2 or purge_at <= $3)
             returning digest, request_id, owner",
        )
        .bind(&key)
        .bind(which.is_any())
        .bind(which.until())
        .fetch_optional(&mut tx)
        .await?;
        let (digest, request_id, owner) =
            deleted.ok_or_else(|| Error::NotFound { name: id.to_string() })?;
        let request = request_id.as_deref().map(|stored| RequestId::of_row(stored, &owner));
        self.store.keep_request_id(&mut tx, Kind::Twins, request, &id.to_string()).await?;
        labels::forget(&mut tx, Collection::Twins, &key).await?;
        tx.commit().await?;
        self.store.pass(Failpoint::BeforeRelease)?;
        self.store.release(&digest).await
    }
}

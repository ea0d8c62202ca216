//! The trash: captures, fits and twins that were deleted and can be restored for a limited time.
//!
//! A row in the trash stays in its table, with the time of its deletion and the time from which it is
//! purged. What it refers to stays with it: its content, its tags, the products and supplements of a
//! capture, the losses and the checkpoint of a fit. So garbage collection, quotas, backups and the
//! check treat it like any other row. No row in the trash can be read as a resource
//! ([`refuse`]), and lists leave them out. Rules that move what is old to the trash are in `retention`.
//!
//! The request id of a deleted resource makes no other for a day (`deleted_requests`); within that day
//! a restored one takes it back.

pub(crate) mod resource;
pub(crate) mod retention;
mod sweep;

use std::{fmt::Display, time::Duration};

use jiff::Timestamp;

use self::resource::Resource;
use crate::{
    Creator, Error, Page, PageRequest, Result, Store,
    failpoint::Failpoint,
    jobs::fits_under_way,
    labels::Collection,
    owners::deleted_requests,
    owners::{
        projects,
        request_ids::{self, RequestId},
    },
    sql::{Builder, Transaction, row::row},
    store::clock::from_micros,
};

/// Terms of a deletion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deletion {
    /// Time for which it can be undone.
    pub kept: Duration,
    /// Owner of the key that deletes, or the rule that does; empty if that is not known.
    pub by: String,
}

/// A resource in the trash.
#[derive(Clone, Debug, PartialEq)]
pub struct Trashed {
    /// Name of the resource.
    pub resource: Resource,
    /// Display name.
    pub display_name: String,
    /// Owner; empty if that is not known.
    pub owner: String,
    /// Time of its creation.
    pub created: Timestamp,
    /// Time of the deletion.
    pub deleted: Timestamp,
    /// Time from which it is purged.
    pub purged: Timestamp,
    /// Owner of the key that deleted it, or the rule that did; empty if that is not known.
    pub deleted_by: String,
    /// Size of the archive of a capture, or of a twin file; 0 of a fit [bytes].
    pub size_bytes: u64,
}

/// The trash of a store.
#[derive(Clone, Copy, Debug)]
pub struct Trash<'a> {
    pub(crate) store: &'a Store,
}

/// The rows that a removal for good is limited to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Remove {
    /// All.
    Any,
    /// Those in the trash that are due by a time [us].
    Due(i64),
}

impl Remove {
    /// Those in the trash.
    const TRASHED: Self = Self::Due(i64::MAX);

    pub(crate) fn is_any(self) -> bool {
        self == Self::Any
    }

    /// Latest due time [us].
    pub(crate) fn until(self) -> i64 {
        match self {
            Self::Any => i64::MAX,
            Self::Due(until) => until,
        }
    }
}

/// Refuses a row of a resource that is in the trash.
///
/// # Errors
/// [`Error::InTrash`].
pub(crate) fn refuse(
    name: impl Display,
    trashed_at: Option<i64>,
    purge_at: Option<i64>,
) -> Result<()> {
    match trashed_at {
        None => Ok(()),
        Some(trashed_at) => {
            // Whole seconds: it is for people.
            let until = purge_at.unwrap_or(trashed_at).div_euclid(1_000_000);
            let until = from_micros(until.saturating_mul(1_000_000));
            Err(Error::InTrash { name: name.to_string(), until })
        }
    }
}

row! {
    struct Row {
        id: String,
        display_name: String,
        owner: String,
        created_at: i64,
        request_id: Option<String>,
        size_bytes: i64,
        trashed_at: Option<i64>,
        purge_at: Option<i64>,
        trashed_by: Option<String>,
    }
}

impl Row {
    fn read(self, collection: Collection) -> Result<Trashed> {
        let id = crate::sql::row::id(collection.name(), &self.id)?;
        let deleted = self.trashed_at.unwrap_or_default();
        Ok(Trashed {
            resource: Resource::new(collection, id),
            display_name: self.display_name,
            owner: self.owner,
            created: from_micros(self.created_at),
            deleted: from_micros(deleted),
            purged: from_micros(self.purge_at.unwrap_or(deleted)),
            deleted_by: self.trashed_by.unwrap_or_default(),
            size_bytes: self.size_bytes.max(0) as u64,
        })
    }
}

/// The beginning of a statement for rows of a collection, in the trash or not.
fn select(collection: Collection) -> Builder {
    let mut sql = Builder::new(
        "select id, display_name, owner, created_at, request_id, trashed_at, purge_at, trashed_by, ",
    );
    let (size, only) = match collection {
        Collection::Captures | Collection::Twins => ("size_bytes", "true"),
        Collection::Fits => ("cast(0 as bigint) as size_bytes", "kind = 'fit'"),
    };
    sql.push(format_args!("{size} from {} where {only}", collection.table()));
    sql
}

/// The row of a resource, in the trash or not.
async fn fetch(tx: &mut Transaction, resource: Resource) -> Result<Row> {
    let mut sql = select(resource.collection());
    sql.push(" and id = ").push_bind(resource.key());
    let row: Option<Row> = sql.build().fetch_optional(tx).await?;
    row.ok_or_else(|| Error::NotFound { name: resource.to_string() })
}

impl Trash<'_> {
    /// Moves a resource to the trash: a capture with its ingest, what ingests made of it and its
    /// supplements. A job that is queued waits no more; a running ingest ends. Returns the time from
    /// which it is purged.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::InTrash`]; [`Error::CaptureInUse`] while fits of a capture are
    /// queued or running; [`Error::FitRunning`].
    pub async fn put(
        &self,
        resource: impl Into<Resource>,
        deletion: &Deletion,
    ) -> Result<Timestamp> {
        let tx = self.store.inner.database.write().await?;
        self.put_within(tx, resource.into(), deletion).await
    }

    /// Moves a resource to the trash within a transaction, which it commits.
    pub(crate) async fn put_within(
        &self,
        mut tx: Transaction,
        resource: Resource,
        deletion: &Deletion,
    ) -> Result<Timestamp> {
        let row = fetch(&mut tx, resource).await?;
        refuse(resource, row.trashed_at, row.purge_at)?;
        let purge_at = self.put_row(&mut tx, resource, row, deletion).await?;
        let suspended = match resource {
            Resource::Capture(id) => self.store.jobs().suspend_ingest(&mut tx, id).await?,
            Resource::Fit(id) => Some(self.store.jobs().suspend_fit(&mut tx, id).await?),
            Resource::Twin(_) => None,
        };
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        if let Some(job) = suspended {
            // Watchers of the capture, and the worker of an ingest, learn that it is gone.
            let _ = self.store.inner.changes.send(job);
        }
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(from_micros(purge_at))
    }

    /// Marks a row. Returns the time from which it is purged [us].
    async fn put_row(
        &self,
        tx: &mut Transaction,
        resource: Resource,
        row: Row,
        deletion: &Deletion,
    ) -> Result<i64> {
        if let Resource::Capture(id) = resource {
            let fits = fits_under_way(tx, &resource.key()).await?;
            if fits > 0 {
                return Err(Error::CaptureInUse { name: id.to_string(), fits });
            }
        }
        let stored = row.request_id.as_deref();
        let request = stored.map(|stored| RequestId::of_row(stored, &row.owner));
        let kind = resource.requests();
        self.store.keep_request_id(tx, kind, request, &resource.to_string()).await?;
        let trashed_at = self.store.lease_until(tx, Duration::ZERO);
        let purge_at = self.store.lease_until(tx, deletion.kept);
        let mut sql = Builder::new("update ");
        sql.push(resource.collection().table()).push(" set request_id = null, trashed_at = ");
        sql.push_bind(trashed_at).push(", purge_at = ").push_bind(purge_at);
        sql.push(", trashed_by = ").push_bind(deletion.by.as_str());
        sql.push(" where id = ").push_bind(resource.key());
        sql.build().execute(tx).await?;
        Ok(purge_at)
    }

    /// Deletes a resource for good, in the trash or not.
    ///
    /// # Errors
    /// [`Error::NotFound`]; [`Error::CaptureInUse`] while fits of a capture are queued or running;
    /// [`Error::FitRunning`].
    pub async fn delete(&self, resource: impl Into<Resource>) -> Result<()> {
        match resource.into() {
            Resource::Capture(id) => self.store.captures().delete(id).await,
            Resource::Fit(id) => self.store.jobs().delete(id).await,
            Resource::Twin(id) => self.store.twins().delete(id).await,
        }
    }

    /// Takes a resource out of the trash, as it was. A job that was queued or an ingest that ran is
    /// queued again, at the expense of `creator`; a fit whose capture is gone is cancelled instead.
    /// What is not in the trash does not change.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::QuotaJobs`].
    pub async fn restore(&self, resource: impl Into<Resource>, creator: &Creator) -> Result<()> {
        let resource = resource.into();
        let mut tx = self.store.inner.database.write().await?;
        let row = fetch(&mut tx, resource).await?;
        if row.trashed_at.is_none() {
            return Ok(());
        }
        let name = resource.to_string();
        let kept = deleted_requests::take_back(&mut tx, resource.requests(), &name).await?;
        let request = kept.as_deref().map(|kept| RequestId::of_row(kept, &row.owner));
        let table = resource.collection().table();
        let request_id = request_ids::text_in(request, &mut tx, table).await?;
        let mut sql = Builder::new("update ");
        sql.push(table);
        sql.push(" set trashed_at = null, purge_at = null, trashed_by = null, request_id = ");
        sql.push_bind(request_id).push(" where id = ").push_bind(resource.key());
        sql.build().execute(&mut tx).await?;
        let resumed = match resource {
            Resource::Capture(id) => self.store.jobs().resume_ingest(&mut tx, id, creator).await?,
            Resource::Fit(id) => Some(self.store.jobs().resume_fit(&mut tx, id, creator).await?),
            Resource::Twin(_) => None,
        };
        self.store.pass(Failpoint::BeforeCommit)?;
        tx.commit().await?;
        if let Some(job) = resumed {
            self.store.jobs().changed(&job);
        }
        self.store.pass(Failpoint::AfterCommit)?;
        Ok(())
    }

    /// A resource in the trash.
    ///
    /// # Errors
    /// [`Error::NotFound`] if it is not in the trash.
    pub async fn get(&self, resource: impl Into<Resource>) -> Result<Trashed> {
        let resource = resource.into();
        let mut sql = select(resource.collection());
        sql.push(" and trashed_at is not null and id = ").push_bind(resource.key());
        let row: Option<Row> = sql.build().fetch_optional(self.store.inner.database.read()).await?;
        let row =
            row.ok_or_else(|| Error::NotFound { name: format!("{resource} in the trash") })?;
        row.read(resource.collection())
    }

    /// A page of what is in the trash of a collection, deleted last first; `owner` is an owner, or
    /// empty for any. `shared_with` confines it to what that owner and the members of its projects
    /// have.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(
        &self,
        collection: Collection,
        owner: &str,
        shared_with: Option<&str>,
        page: &PageRequest,
    ) -> Result<Page<Trashed>> {
        let listing = format!("trash of {} {owner:?} {shared_with:?}", collection.name());
        let mut sql = select(collection);
        sql.push(" and trashed_at is not null");
        if !owner.is_empty() {
            sql.push(" and owner = ").push_bind(owner);
        }
        if let Some(shared_with) = shared_with {
            projects::push_shared_with(&mut sql, "owner", shared_with);
        }
        if let Some(place) = page.place(&listing)? {
            let at: i64 = place.key.parse().map_err(|_| Error::InvalidPageToken)?;
            sql.push(" and (trashed_at, id) < (").push_bind(at).push(", ");
            sql.push_bind(place.id).push(")");
        }
        sql.push(" order by trashed_at desc, id desc limit ").push_bind(page.fetch());
        let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        let items = rows.into_iter().map(|row| row.read(collection)).collect::<Result<_>>()?;
        Ok(Page::cut(items, page, &listing, |trashed: &Trashed| {
            (trashed.resource.uuid(), trashed.deleted.as_microsecond().to_string())
        }))
    }
}

#[cfg(test)]
mod tests;

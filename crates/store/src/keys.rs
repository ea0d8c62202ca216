//! Keys with which clients identify themselves. Only a hash of each is stored. The meaning of its
//! scopes is for others to decide.

pub(crate) mod quotas;
mod shares;
mod sign_ins;
pub(crate) mod usage;

pub use shares::{NewShare, Share};
pub use sign_ins::SignedIn;

use bendtwin_core::ids::KeyId;
use jiff::Timestamp;
use uuid::Uuid;

use crate::{
    Digest, Error, Page, PageRequest, Quotas, Result, Store,
    sql::{Transaction, query, row::row},
    store::clock::{from_micros, micros},
};

/// A stored key.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Id, which is a part of the key.
    pub id: KeyId,
    /// Display name.
    pub display_name: String,
    /// Name recorded with resources made with the key.
    pub owner: String,
    /// BLAKE3 of the whole key.
    pub hash: Digest,
    /// Scopes of the key, sorted.
    pub scopes: Vec<String>,
    /// Bounds on what its owner may have.
    pub quotas: Quotas,
    /// Time of creation.
    pub created: Timestamp,
    /// Time from which it is not accepted any more, if there is one.
    pub expires: Option<Timestamp>,
    /// Time of its revocation.
    pub revoked: Option<Timestamp>,
    /// Time of its last use, to about a minute.
    pub used: Option<Timestamp>,
    /// The person who got it by signing in; none for a key that somebody made.
    pub signed_in_as: Option<String>,
    /// The twin that it is limited to, if it is a share.
    pub share: Option<Share>,
}

/// A key to be stored.
#[derive(Clone, Debug)]
pub struct NewKey {
    /// Id of the key.
    pub id: KeyId,
    /// Display name.
    pub display_name: String,
    /// Name recorded with resources made with the key.
    pub owner: String,
    /// BLAKE3 of the whole key.
    pub hash: Digest,
    /// Scopes of the key.
    pub scopes: Vec<String>,
    /// Bounds on what its owner may have.
    pub quotas: Quotas,
    /// Time from which it is not accepted any more, if there is one.
    pub expires: Option<Timestamp>,
    /// The person who signs in, as the identity provider names them; none for other keys.
    pub signed_in_as: Option<String>,
}

/// The keys of a store.
#[derive(Clone, Copy, Debug)]
pub struct Keys<'a> {
    pub(crate) store: &'a Store,
}

row! {
    struct Row {
        id: String,
        display_name: String,
        owner: String,
        hash: String,
        scopes: String,
        created_at: i64,
        expires_at: Option<i64>,
        revoked_at: Option<i64>,
        used_at: Option<i64>,
        max_queued_jobs: Option<i64>,
        max_stored_bytes: Option<i64>,
        max_rollouts: Option<i64>,
        max_running_jobs: Option<i64>,
        max_fit_run_s: Option<i64>,
        max_priority: Option<i64>,
        signed_in_as: Option<String>,
        twin: Option<String>,
        shared_by: Option<String>,
    }
}

impl TryFrom<Row> for Key {
    type Error = Error;
    fn try_from(row: Row) -> Result<Self> {
        let corrupt = |fault: &str| Error::CorruptRow {
            name: format!("keys/{}", row.id),
            fault: fault.to_owned(),
        };
        let bound = |n: Option<i64>| n.map(|n| n.max(0) as u64);
        let share = row.twin.as_deref().map(|twin| {
            let twin = Uuid::try_parse(twin).map_err(|_| corrupt("twin"))?.into();
            Ok::<_, Error>(Share { twin, by: row.shared_by.clone() })
        });
        Ok(Self {
            id: Uuid::try_parse(&row.id).map_err(|_| corrupt("id"))?.into(),
            hash: Digest::from_hex(&row.hash).map_err(|_| corrupt("hash"))?,
            scopes: serde_json::from_str(&row.scopes).map_err(|_| corrupt("scopes"))?,
            quotas: Quotas {
                queued_jobs: bound(row.max_queued_jobs),
                stored_bytes: bound(row.max_stored_bytes),
                rollouts: bound(row.max_rollouts),
                running_jobs: bound(row.max_running_jobs),
                fit_run_s: bound(row.max_fit_run_s),
                priority: row.max_priority.and_then(|n| u32::try_from(n).ok()),
            },
            created: from_micros(row.created_at),
            expires: row.expires_at.map(from_micros),
            revoked: row.revoked_at.map(from_micros),
            used: row.used_at.map(from_micros),
            share: share.transpose()?,
            signed_in_as: row.signed_in_as,
            display_name: row.display_name,
            owner: row.owner,
        })
    }
}

impl Keys<'_> {
    /// Stores a key.
    ///
    /// # Errors
    /// [`Error::DiskFull`], database errors.
    pub async fn create(&self, new: NewKey) -> Result<Key> {
        self.store.admit()?;
        let mut tx = self.store.inner.database.write().await?;
        let key = insert(&mut tx, new, None, self.store.now_micros()).await?;
        tx.commit().await?;
        Ok(key)
    }

    /// Returns a key.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: KeyId) -> Result<Key> {
        let row: Option<Row> = query("select * from keys where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        row.ok_or_else(|| Error::NotFound { name: id.to_string() })?.try_into()
    }

    /// A page of keys, newest first; revoked and expired ones are among them.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(&self, page: &PageRequest) -> Result<Page<Key>> {
        const LISTING: &str = "keys";
        let rows: Vec<Row> = query("select * from keys where id < $1 order by id desc limit $2")
            .bind(page.before(LISTING)?)
            .bind(page.fetch())
            .fetch_all(self.store.inner.database.read())
            .await?;
        let items = rows.into_iter().map(Key::try_from).collect::<Result<_>>()?;
        Ok(Page::cut(items, page, LISTING, |key: &Key| (key.id.uuid(), String::new())))
    }

    /// All keys. A row that cannot be read is left out, so that it does not keep the others out.
    ///
    /// # Errors
    /// Database errors.
    pub async fn all(&self) -> Result<Vec<Key>> {
        let rows: Vec<Row> = query("select * from keys order by id")
            .fetch_all(self.store.inner.database.read())
            .await?;
        let read = rows.into_iter().map(Key::try_from);
        Ok(read
            .filter_map(|key| key.inspect_err(|error| tracing::error!(%error, "a key")).ok())
            .collect())
    }

    /// Revokes a key. One that is revoked already keeps the time of that. The shares that were made
    /// with it stay.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn revoke(&self, id: KeyId) -> Result<Key> {
        let now = self.store.now_micros();
        let mut tx = self.store.inner.database.write().await?;
        let row = revoke(&mut tx, id, now).await?;
        tx.commit().await?;
        row.try_into()
    }

    /// Records when keys were used last.
    ///
    /// # Errors
    /// Database errors.
    pub async fn used(&self, uses: &[(KeyId, Timestamp)]) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        for (id, time) in uses {
            record_use(&mut tx, *id, *time).await?;
        }
        tx.commit().await?;
        Ok(())
    }
}

/// Revokes a key, unless it is revoked already.
async fn revoke(tx: &mut Transaction, id: KeyId, now: i64) -> Result<Row> {
    let row: Option<Row> =
        query("update keys set revoked_at = coalesce(revoked_at, $2) where id = $1 returning *")
            .bind(id.uuid().to_string())
            .bind(now)
            .fetch_optional(&mut *tx)
            .await?;
    row.ok_or_else(|| Error::NotFound { name: id.to_string() })
}

/// Stores a key, or a share, with this time of creation.
async fn insert(tx: &mut Transaction, new: NewKey, share: Option<Share>, now: i64) -> Result<Key> {
    let (twin, shared_by) = match share {
        Some(Share { twin, by }) => (Some(twin.uuid().to_string()), by),
        None => (None, None),
    };
    let bound = |n: Option<u64>| n.map(quotas::as_integer);
    let row: Row = query(
        "insert into keys (id, display_name, owner, hash, scopes, created_at, expires_at,
             max_queued_jobs, max_stored_bytes, max_rollouts, max_running_jobs, max_fit_run_s,
             max_priority, signed_in_as, twin, shared_by)
         values ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16) returning *",
    )
    .bind(new.id.uuid().to_string())
    .bind(new.display_name)
    .bind(new.owner)
    .bind(new.hash.to_hex().as_str())
    .bind(stored_scopes(new.scopes))
    .bind(now)
    .bind(new.expires.map(micros))
    .bind(bound(new.quotas.queued_jobs))
    .bind(bound(new.quotas.stored_bytes))
    .bind(bound(new.quotas.rollouts))
    .bind(bound(new.quotas.running_jobs))
    .bind(bound(new.quotas.fit_run_s))
    .bind(new.quotas.priority.map(i64::from))
    .bind(new.signed_in_as)
    .bind(twin)
    .bind(shared_by)
    .fetch_one(&mut *tx)
    .await?;
    row.try_into()
}

/// Text of a set of scopes in its column, which is equal for equal sets.
fn stored_scopes(mut scopes: Vec<String>) -> String {
    scopes.sort();
    scopes.dedup();
    // A list of words always serialises.
    serde_json::to_string(&scopes).unwrap_or_default()
}

/// Records a use, unless a later one is recorded.
async fn record_use(tx: &mut Transaction, id: KeyId, time: Timestamp) -> Result<()> {
    query("update keys set used_at = $2 where id = $1 and (used_at is null or used_at < $2)")
        .bind(id.uuid().to_string())
        .bind(micros(time))
        .execute(&mut *tx)
        .await?;
    Ok(())
}

#[cfg(test)]
mod tests;

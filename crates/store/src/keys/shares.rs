//! Shares: keys that are limited to one twin, for those to whom its link is sent. Each ends by itself, and
//! with the key that made it.

use bendtwin_core::ids::{KeyId, ShareId, TwinId};

use super::{Key, Keys, NewKey, Row, insert, revoke};
use crate::{
    Error, Page, PageRequest, Result,
    sql::{Transaction, query, query_scalar},
};

/// Most shares of a twin that are valid.
pub(super) const MOST_SHARES: i64 = 100;
/// Most that are stored, with those that have ended; a further one takes the place of the oldest of these.
pub(super) const MOST_STORED: i64 = 300;

/// What makes a key a share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Share {
    /// The twin that it is limited to.
    pub twin: TwinId,
    /// The key that made it, as its UUID, or the person who had signed in; none with the client token.
    pub by: Option<String>,
}

/// A share to be stored.
#[derive(Clone, Debug)]
pub struct NewShare {
    /// The key of the share.
    pub key: NewKey,
    /// The twin.
    pub twin: TwinId,
    /// Key of the caller; none with the client token.
    pub by: Option<KeyId>,
}

/// The key of a share.
fn key_of(share: ShareId) -> KeyId {
    share.uuid().into()
}

impl Keys<'_> {
    /// Stores a share, unless the key that makes it has been revoked meanwhile.
    ///
    /// # Errors
    /// [`Error::TooManyShares`]; [`Error::NotFound`] for the key that makes it; [`Error::DiskFull`].
    pub async fn share(&self, new: NewShare) -> Result<Key> {
        self.store.admit()?;
        let NewShare { key, twin, by } = new;
        let now = self.store.now_micros();
        let mut tx = self.store.inner.database.write().await?;
        let by = match by {
            Some(by) => Some(sharer(&mut tx, by).await?),
            None => None,
        };
        let valid: i64 = query_scalar(
            "select count(*) from keys where twin = $1 and revoked_at is null and expires_at > $2",
        )
        .bind(twin.uuid().to_string())
        .bind(now)
        .fetch_one(&mut tx)
        .await?;
        if valid >= MOST_SHARES {
            return Err(Error::TooManyShares { twin, limit: MOST_SHARES });
        }
        let key = insert(&mut tx, key, Some(Share { twin, by }), now).await?;
        query(
            "delete from keys where twin = $1 and (revoked_at is not null or expires_at <= $2)
                 and id not in
                 (select id from keys where twin = $1 order by created_at desc, id desc limit $3)",
        )
        .bind(twin.uuid().to_string())
        .bind(now)
        .bind(MOST_STORED)
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        Ok(key)
    }

    /// Returns a share.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get_share(&self, id: ShareId) -> Result<(Key, Share)> {
        let missing = || Error::NotFound { name: id.to_string() };
        let key = match self.get(key_of(id)).await {
            Err(Error::NotFound { .. }) => return Err(missing()),
            key => key?,
        };
        let share = key.share.clone().ok_or_else(missing)?;
        Ok((key, share))
    }

    /// A page of the shares of a twin, newest first; revoked and expired ones are among them.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn shares_of(&self, twin: TwinId, page: &PageRequest) -> Result<Page<Key>> {
        let listing = format!("shares of {}", twin.uuid());
        let rows: Vec<Row> =
            query("select * from keys where twin = $1 and id < $2 order by id desc limit $3")
                .bind(twin.uuid().to_string())
                .bind(page.before(&listing)?)
                .bind(page.fetch())
                .fetch_all(self.store.inner.database.read())
                .await?;
        let items = rows.into_iter().map(Key::try_from).collect::<Result<_>>()?;
        Ok(Page::cut(items, page, &listing, |key: &Key| (key.id.uuid(), String::new())))
    }

    /// Revokes a key and all shares that were made with it, or, if it is of a sign-in, by its person.
    /// The key comes first.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn revoke_with_shares(&self, id: KeyId) -> Result<Vec<Key>> {
        let now = self.store.now_micros();
        let mut tx = self.store.inner.database.write().await?;
        let row = revoke(&mut tx, id, now).await?;
        let by = row.signed_in_as.clone().unwrap_or_else(|| row.id.clone());
        let shares = revoke_all_by(&mut tx, &by, now).await?;
        tx.commit().await?;
        let mut revoked = vec![Key::try_from(row)?];
        // A row that cannot be read admits nobody either.
        revoked.extend(shares.into_iter().filter_map(|row| Key::try_from(row).ok()));
        Ok(revoked)
    }
}

/// Revokes the shares of a key or a person.
pub(super) async fn revoke_all_by(tx: &mut Transaction, by: &str, now: i64) -> Result<Vec<Row>> {
    query("update keys set revoked_at = $2 where shared_by = $1 and revoked_at is null returning *")
        .bind(by)
        .bind(now)
        .fetch_all(&mut *tx)
        .await
}

/// What the shares of a key end with.
async fn sharer(tx: &mut Transaction, by: KeyId) -> Result<String> {
    let row: Option<Row> = query("select * from keys where id = $1 and revoked_at is null")
        .bind(by.uuid().to_string())
        .fetch_optional(&mut *tx)
        .await?;
    let row = row.ok_or_else(|| Error::NotFound { name: by.to_string() })?;
    Ok(row.signed_in_as.unwrap_or(row.id))
}

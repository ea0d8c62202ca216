//! Keys that people get by signing in. Each ends by itself, and those of a person are bounded, so that
//! the table does not grow with the number of times that somebody signs in. Shares end by themselves as
//! well, and are forgotten together with them.

use jiff::Timestamp;

use super::{Key, Keys, NewKey, Row, insert, shares, stored_scopes};
use crate::{Result, sql::query, store::clock::micros};

/// Most sign-ins of a person that are valid; a further one ends the oldest.
pub(super) const MOST_SIGN_INS: i64 = 32;
/// Most that are stored, with those that have ended, whose holders are asked to sign in again.
pub(super) const MOST_STORED: i64 = 256;

/// What a sign-in has changed.
#[derive(Clone, Debug, PartialEq)]
pub struct SignedIn {
    /// Key of the person.
    pub key: Key,
    /// Earlier ones of the same person that end with it, as revoked keys, and shares made with them.
    pub ended: Vec<Key>,
}

impl Keys<'_> {
    /// Stores the key of a sign-in. It ends earlier ones of the person with another owner or other
    /// scopes, since the provider now says something else, with all shares of the person, and the
    /// oldest if there are too many.
    ///
    /// # Errors
    /// [`Error::DiskFull`](crate::Error::DiskFull), database errors.
    pub async fn sign_in(&self, new: NewKey) -> Result<SignedIn> {
        self.store.admit()?;
        let (person, owner) = (new.signed_in_as.clone(), new.owner.clone());
        let scopes = stored_scopes(new.scopes.clone());
        let now = self.store.now_micros();
        let mut tx = self.store.inner.database.write().await?;
        let key = insert(&mut tx, new, None, now).await?;
        let mut ended: Vec<Row> = query(
            "update keys set revoked_at = $4 where signed_in_as = $1 and revoked_at is null
                 and (owner <> $2 or scopes <> $3) returning *",
        )
        .bind(person.clone())
        .bind(owner)
        .bind(scopes)
        .bind(now)
        .fetch_all(&mut tx)
        .await?;
        if !ended.is_empty()
            && let Some(person) = &person
        {
            ended.extend(shares::revoke_all_by(&mut tx, person, now).await?);
        }
        let replaced: Vec<Row> = query(
            "update keys set revoked_at = $3 where signed_in_as = $1 and revoked_at is null and id not in
                 (select id from keys where signed_in_as = $1 and revoked_at is null
                  order by created_at desc, id desc limit $2)
             returning *",
        )
        .bind(person.clone())
        .bind(MOST_SIGN_INS)
        .bind(now)
        .fetch_all(&mut tx)
        .await?;
        query(
            "delete from keys where signed_in_as = $1 and id not in
                 (select id from keys where signed_in_as = $1 order by created_at desc, id desc limit $2)",
        )
        .bind(person)
        .bind(MOST_STORED)
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        ended.extend(replaced);
        // A row that cannot be read admits nobody either.
        let ended = ended.into_iter().filter_map(|row| Key::try_from(row).ok()).collect();
        Ok(SignedIn { key, ended })
    }

    /// Deletes sign-ins and shares that ended before a time. Returns how many.
    ///
    /// # Errors
    /// Database errors.
    pub async fn forget_ended(&self, ended_before: Timestamp) -> Result<u64> {
        let mut tx = self.store.inner.database.write().await?;
        let forgotten = query(
            "delete from keys where (signed_in_as is not null or twin is not null)
                 and expires_at < $1",
        )
        .bind(micros(ended_before))
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        Ok(forgotten)
    }
}

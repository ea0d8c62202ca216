//! Keys that people get by signing in. Each ends by itself, and those of a person are bounded, so that
//! the table does not grow with the number of times that somebody signs in.

use jiff::Timestamp;

use super::{Key, Keys, NewKey, insert};
use crate::{Result, sql::query, store::clock::micros};

/// Most sign-ins of a person; a further one takes the place of the oldest.
pub(super) const MOST_SIGN_INS: i64 = 32;

impl Keys<'_> {
    /// Stores the key of a sign-in.
    ///
    /// # Errors
    /// [`Error::DiskFull`](crate::Error::DiskFull), database errors.
    pub async fn sign_in(&self, new: NewKey) -> Result<Key> {
        self.store.admit()?;
        let person = new.signed_in_as.clone();
        let mut tx = self.store.inner.database.write().await?;
        let key = insert(&mut tx, new, self.store.now_micros()).await?;
        query(
            "delete from keys where signed_in_as = $1 and id not in
                 (select id from keys where signed_in_as = $1 order by created_at desc, id desc limit $2)",
        )
        .bind(person)
        .bind(MOST_SIGN_INS)
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        Ok(key)
    }

    /// Revokes all sign-ins of an owner. Returns how many of them were valid.
    ///
    /// # Errors
    /// Database errors.
    pub async fn revoke_sign_ins(&self, owner: &str) -> Result<u64> {
        let mut tx = self.store.inner.database.write().await?;
        let revoked = query(
            "update keys set revoked_at = $2 where owner = $1 and signed_in_as is not null
                 and revoked_at is null and expires_at > $2",
        )
        .bind(owner)
        .bind(self.store.now_micros())
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        Ok(revoked)
    }

    /// Deletes sign-ins that ended before a time. Returns how many.
    ///
    /// # Errors
    /// Database errors.
    pub async fn forget_sign_ins(&self, ended_before: Timestamp) -> Result<u64> {
        let mut tx = self.store.inner.database.write().await?;
        let forgotten =
            query("delete from keys where signed_in_as is not null and expires_at < $1")
                .bind(micros(ended_before))
                .execute(&mut tx)
                .await?;
        tx.commit().await?;
        Ok(forgotten)
    }
}

//! Bytes set aside for content that arrives in one request. Each is a row that every server counts,
//! from before the first byte until the transaction that makes a resource of the content. The server
//! that receives the content renews the row; without that it counts no more after a while.

use std::time::{Duration, Instant};

use uuid::Uuid;

use super::{Creator, More};
use crate::{
    Result, Store, Upload,
    sql::{Transaction, query},
};

/// Smallest and largest step in which bytes are set aside for content of unknown size: as much as
/// has arrived, between these. An owner may have all of its quota, but others of its uploads cannot
/// have what was set aside.
const FIRST_STEP: u64 = 1 << 20;
const LARGEST_STEP: u64 = 32 << 20;

/// Content of a client to be received in one request.
#[derive(Clone, Debug)]
pub struct Incoming {
    /// The one who sends it.
    pub creator: Creator,
    /// Number of jobs that it makes.
    pub jobs: u64,
    /// Size of the content, if the request declares it [bytes].
    pub size_bytes: Option<u64>,
    /// Most that is accepted [bytes].
    pub limit: u64,
    /// Longest silence between two chunks. Without any news of it for longer, the bytes set aside
    /// are free again.
    pub silence: Duration,
    /// True if a resource was made under its request id before. Then it is compared with that
    /// alone, and not written anywhere.
    pub is_repetition: bool,
}

/// Bytes set aside. Dropped, they are free again.
#[derive(Debug)]
pub(crate) struct Reservation {
    store: Store,
    id: Uuid,
    creator: Creator,
    bytes: u64,
    keep: Duration,
    renewed: Instant,
    is_settled: bool,
}

/// Bytes to be set aside for content of unknown size of which `needed` have arrived or are about to.
pub(crate) fn with_step(needed: u64) -> u64 {
    needed.saturating_add(needed.clamp(FIRST_STEP, LARGEST_STEP))
}

impl Store {
    /// Prepares to receive content of a client: refuses what its owner has no room for, and sets the
    /// bytes aside, all of them if their number is declared.
    ///
    /// # Errors
    /// [`Error::TooLarge`], [`Error::QuotaBytes`], [`Error::QuotaJobs`], [`Error::DiskFull`]; database
    /// and file errors.
    ///
    /// [`Error::TooLarge`]: crate::Error::TooLarge
    /// [`Error::QuotaBytes`]: crate::Error::QuotaBytes
    /// [`Error::QuotaJobs`]: crate::Error::QuotaJobs
    /// [`Error::DiskFull`]: crate::Error::DiskFull
    pub async fn receive(&self, incoming: Incoming) -> Result<Upload> {
        self.admit()?;
        let limit = incoming.limit;
        if incoming.size_bytes.is_some_and(|size| size > limit) {
            return Err(crate::Error::TooLarge { limit });
        }
        if incoming.is_repetition {
            return Ok(self.blobs().comparison(limit));
        }
        let reservation = Reservation::begin(self, incoming).await?;
        Ok(self.blobs().upload(limit).await?.within(reservation))
    }

    /// Ends reservations that nobody renews: of servers that have died.
    ///
    /// # Errors
    /// Database errors.
    pub(crate) async fn sweep_reservations(&self) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        let now = self.lease_until(&tx, Duration::ZERO);
        let gone = "delete from reservations where until_at < $1";
        query(gone).bind(now).execute(&mut tx).await?;
        tx.commit().await
    }

    /// Ends all reservations: a store that nobody else has open begins without any.
    pub(crate) async fn forget_reservations(&self) -> Result<()> {
        let mut tx = self.inner.database.write().await?;
        query("delete from reservations").execute(&mut tx).await?;
        tx.commit().await
    }
}

impl Reservation {
    async fn begin(store: &Store, incoming: Incoming) -> Result<Self> {
        let Incoming { creator, jobs, size_bytes, silence, .. } = incoming;
        let mut reservation = Self {
            store: store.clone(),
            id: Uuid::new_v4(),
            creator,
            bytes: 0,
            keep: 2 * silence + Duration::from_secs(60),
            renewed: Instant::now(),
            is_settled: false,
        };
        let mut tx = store.inner.database.write().await?;
        let more = More { jobs, ..More::default() };
        super::require(&mut tx, &reservation.creator, more).await?;
        let bytes = size_bytes.map_or_else(|| 1..=with_step(0), |size| size..=size);
        reservation.write(tx, bytes).await?;
        Ok(reservation)
    }

    /// Sets bytes aside before they are received, so that there are `total` in all.
    ///
    /// # Errors
    /// [`Error::QuotaBytes`](crate::Error::QuotaBytes), database errors.
    pub(crate) async fn cover(&mut self, total: u64) -> Result<()> {
        let bytes = if total > self.bytes {
            total..=with_step(total)
        } else if self.renewed.elapsed() > self.keep / 4 {
            self.bytes..=self.bytes
        } else {
            return Ok(());
        };
        let tx = self.store.inner.database.write().await?;
        self.write(tx, bytes).await
    }

    async fn write(
        &mut self,
        mut tx: Transaction,
        bytes: std::ops::RangeInclusive<u64>,
    ) -> Result<()> {
        let id = self.held();
        // What is set aside already stays so, also if other things have been stored meanwhile.
        let bytes = match *bytes.end() <= self.bytes {
            true => self.bytes,
            false => super::grant(&mut tx, &self.creator, Some(&id), bytes).await?,
        };
        query(
            "insert into reservations (id, owner, size_bytes, until_at) values ($1, $2, $3, $4)
             on conflict (id) do update
                 set size_bytes = excluded.size_bytes, until_at = excluded.until_at",
        )
        .bind(id)
        .bind(&self.creator.owner)
        .bind(i64::try_from(bytes).unwrap_or(i64::MAX))
        .bind(self.store.lease_until(&tx, self.keep))
        .execute(&mut tx)
        .await?;
        tx.commit().await?;
        (self.bytes, self.renewed) = (bytes, Instant::now());
        Ok(())
    }

    /// The id of its row.
    pub(crate) fn held(&self) -> String {
        self.id.to_string()
    }

    /// Ends it within the transaction that makes a resource of the content.
    pub(crate) async fn settle(&self, tx: &mut Transaction) -> Result<()> {
        query("delete from reservations where id = $1").bind(self.held()).execute(tx).await?;
        Ok(())
    }

    /// After that transaction: there is nothing left to end.
    pub(crate) fn settled(mut self) {
        self.is_settled = true;
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        let Ok(runtime) = tokio::runtime::Handle::try_current() else { return };
        if self.is_settled {
            return;
        }
        let (store, id) = (self.store.clone(), self.held());
        runtime.spawn(async move {
            let released = async {
                let mut tx = store.inner.database.write().await?;
                query("delete from reservations where id = $1").bind(&id).execute(&mut tx).await?;
                tx.commit().await
            };
            if let Err(error) = released.await {
                tracing::debug!(%error, reservation = id, "it ends when nobody renews it");
            }
        });
    }
}

//! One writer per upload among several servers: a lease in its row, which the holder renews while
//! it runs. Each claim adds 1 to the epoch of the row; a writer with an older epoch changes
//! nothing. A waiting server says so in the row, and the holder saves what has arrived and releases
//! it.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use bendtwin_core::ids::UploadId;
use futures::future::{Either, select};
use tokio::{sync::watch, task::AbortHandle};

use super::seat::SeatGuard;
use crate::{Error, Result, Store, sql::query};

/// Time for which a server holds an upload without renewing it.
const LEASE: Duration = Duration::from_secs(10);
/// Interval at which a holder looks whether another waits, and number of looks for a renewal.
const LOOK: Duration = Duration::from_secs(1);
const LOOKS: u32 = 3;
/// Interval at which one who waits tries again.
const TRY_AGAIN: Duration = Duration::from_millis(150);

/// The right to write to an upload; dropping it admits the next writer, wherever it is.
#[derive(Debug)]
pub(crate) struct WriteLease {
    lease: Option<Lease>,
    sitting: SeatGuard,
}

#[derive(Debug)]
struct Lease {
    store: Store,
    id: UploadId,
    epoch: i64,
    is_lost: Arc<AtomicBool>,
    wanted: watch::Receiver<bool>,
    renewing: AbortHandle,
}

impl WriteLease {
    /// Waits up to that long for other servers. None if it is not free in time.
    pub(super) async fn among_servers(
        store: &Store,
        id: UploadId,
        sitting: SeatGuard,
        patience: Duration,
    ) -> Result<Option<Self>> {
        if !store.inner.database.is_remote() {
            return Ok(Some(Self { lease: None, sitting }));
        }
        let began = Instant::now();
        loop {
            if let Some(epoch) = claim(store, id).await? {
                let lease = Some(Lease::new(store.clone(), id, epoch));
                return Ok(Some(Self { lease, sitting }));
            }
            if began.elapsed() >= patience {
                return Ok(None);
            }
            tokio::time::sleep(TRY_AGAIN).await;
        }
    }

    /// Waits until another writer waits for the upload, here or elsewhere.
    pub(crate) fn wanted(&self) -> impl Future<Output = ()> + Send + use<> {
        let here = self.sitting.wanted();
        let elsewhere = self.lease.as_ref().map(|lease| lease.wanted.clone());
        async move {
            let Some(mut elsewhere) = elsewhere else { return here.await };
            let elsewhere = async move {
                if elsewhere.wait_for(|wanted| *wanted).await.is_err() {
                    std::future::pending::<()>().await;
                }
            };
            match select(Box::pin(here), Box::pin(elsewhere)).await {
                Either::Left(_) | Either::Right(_) => {}
            }
        }
    }

    /// True if another server may write to the upload by now.
    pub(crate) fn is_lost(&self) -> bool {
        self.lease.as_ref().is_some_and(|lease| lease.is_lost.load(Ordering::SeqCst))
    }
}

impl Lease {
    fn new(store: Store, id: UploadId, epoch: i64) -> Self {
        let (wants, wanted) = watch::channel(false);
        let is_lost = Arc::new(AtomicBool::new(false));
        let task = renew(store.clone(), id, epoch, is_lost.clone(), wants);
        let renewing = tokio::spawn(task).abort_handle();
        Self { store, id, epoch, is_lost, wanted, renewing }
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        self.renewing.abort();
        let Ok(runtime) = tokio::runtime::Handle::try_current() else { return };
        let (store, id, epoch) = (self.store.clone(), self.id, self.epoch);
        runtime.spawn(async move {
            if let Err(error) = release(&store, id, epoch).await {
                tracing::debug!(%error, upload = %id, "it is free when its lease ends");
            }
        });
    }
}

/// Claims an upload that no other server holds; else says that it is wanted. Returns its epoch.
async fn claim(store: &Store, id: UploadId) -> Result<Option<i64>> {
    let key = id.uuid().to_string();
    let mut tx = store.inner.database.write().await?;
    let now = store.lease_until(&tx, Duration::ZERO);
    let epoch: Option<(i64,)> = query(
        "update uploads set holder = $2, lease_until = $3, lease_epoch = lease_epoch + 1,
             is_wanted = false
         where id = $1 and (holder is null or holder = $2 or lease_until < $4)
         returning lease_epoch",
    )
    .bind(&key)
    .bind(&store.inner.instance)
    .bind(store.lease_until(&tx, LEASE))
    .bind(now)
    .fetch_optional(&mut tx)
    .await?;
    if epoch.is_none() {
        let wanted = "update uploads set is_wanted = true where id = $1 and not is_wanted";
        query(wanted).bind(&key).execute(&mut tx).await?;
    }
    tx.commit().await?;
    Ok(epoch.map(|(epoch,)| epoch))
}

/// Renews a lease until it is lost, and notifies its holder when another waits.
async fn renew(
    store: Store,
    id: UploadId,
    epoch: i64,
    is_lost: Arc<AtomicBool>,
    wants: watch::Sender<bool>,
) {
    let mut renewed = Instant::now();
    for look in 1_u32.. {
        tokio::time::sleep(LOOK).await;
        let began = Instant::now();
        let state = match look % LOOKS {
            0 => extend(&store, id, epoch).await,
            _ => is_wanted(&store, id, epoch).await,
        };
        match state {
            Ok(Some(wanted)) => {
                if look % LOOKS == 0 {
                    renewed = began;
                }
                wants.send_if_modified(|before| std::mem::replace(before, wanted) != wanted);
            }
            Ok(None) => return is_lost.store(true, Ordering::SeqCst),
            Err(error) => tracing::debug!(%error, upload = %id, "its lease is not renewed now"),
        }
        if renewed.elapsed() >= LEASE {
            return is_lost.store(true, Ordering::SeqCst);
        }
    }
}

/// True if another waits; none if the lease is another's.
async fn is_wanted(store: &Store, id: UploadId, epoch: i64) -> Result<Option<bool>> {
    let wanted: Option<(bool,)> =
        query("select is_wanted from uploads where id = $1 and lease_epoch = $2")
            .bind(id.uuid().to_string())
            .bind(epoch)
            .fetch_optional(store.inner.database.read())
            .await?;
    Ok(wanted.map(|(wanted,)| wanted))
}

/// [`is_wanted`], and extends the lease.
async fn extend(store: &Store, id: UploadId, epoch: i64) -> Result<Option<bool>> {
    let mut tx = store.inner.database.write().await?;
    let wanted: Option<(bool,)> = query(
        "update uploads set lease_until = $3 where id = $1 and lease_epoch = $2
         returning is_wanted",
    )
    .bind(id.uuid().to_string())
    .bind(epoch)
    .bind(store.lease_until(&tx, LEASE))
    .fetch_optional(&mut tx)
    .await?;
    tx.commit().await?;
    Ok(wanted.map(|(wanted,)| wanted))
}

async fn release(store: &Store, id: UploadId, epoch: i64) -> Result<()> {
    let mut tx = store.inner.database.write().await?;
    let released = "update uploads set holder = null, lease_until = null
                    where id = $1 and lease_epoch = $2";
    query(released).bind(id.uuid().to_string()).bind(epoch).execute(&mut tx).await?;
    tx.commit().await
}

/// The error that another has the upload.
pub(super) fn locked(id: UploadId) -> Error {
    Error::UploadLocked { name: id.to_string() }
}

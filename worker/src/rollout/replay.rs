//! Initial states that a simulation leads to, and the recordings of captures. Observations are large
//! and frames are asked for again and again, so controls and replayed states are kept, not
//! observations.

use std::{
    fmt::Display,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use bendtwin_budget::Share;
use bendtwin_core::{
    CancelToken, Capture,
    ids::{CaptureId, TwinId},
};
use bendtwin_rollout::{CaptureFrame, Motions, Start, Still, Warm, replay, settle};
use tempfile::NamedTempFile;

use super::{error::Error, lru::Lru};
use crate::{
    Limits, artifact,
    budget::{self, Memory},
    device::QueuedBackend,
    observation,
    server_client::ServerClient,
};

/// Captures whose controls are kept, and replayed states that are kept.
const KEPT_MOTIONS: usize = 8;
const KEPT_STARTS: usize = 64;
/// Memory of either, at most [bytes].
const KEPT_BYTES: u64 = 128 << 20;

/// Replays captures, and remembers.
pub(crate) struct Replays {
    server: ServerClient,
    dir: PathBuf,
    limits: Limits,
    memory: Memory,
    motions: Mutex<Lru<(TwinId, CaptureId), Arc<Motions>>>,
    starts: Mutex<Lru<(TwinId, CaptureFrame), Start>>,
    /// Settled states by twin and world.
    settled: Mutex<Lru<(TwinId, [u8; 32]), Start>>,
    /// Held while a twin comes to rest, so that a hundred calls for it simulate that once.
    settling: tokio::sync::Mutex<()>,
    /// Held while a capture is read: one at a time keeps memory within its limit.
    reading: tokio::sync::Mutex<()>,
}

impl Replays {
    pub(crate) fn new(server: ServerClient, dir: PathBuf, limits: Limits, memory: Memory) -> Self {
        let kept = KEPT_BYTES.min(memory.kept_bytes);
        Self {
            server,
            dir,
            limits,
            memory,
            motions: Mutex::new(Lru::new(KEPT_MOTIONS, kept)),
            starts: Mutex::new(Lru::new(KEPT_STARTS, kept)),
            settled: Mutex::new(Lru::new(KEPT_STARTS, kept)),
            settling: tokio::sync::Mutex::default(),
            reading: tokio::sync::Mutex::default(),
        }
    }

    /// The twin's state in a frame of a capture.
    pub(super) async fn start(
        &self,
        warm: &Arc<Warm>,
        at: CaptureFrame,
        backend: &Arc<QueuedBackend>,
        cancel: &CancelToken,
        work_limit: u64,
    ) -> Result<Start, Error> {
        if let Some(start) = lock(&self.starts).get(&(warm.id(), at)) {
            return Ok(start);
        }
        let motions = self.motions(warm, at.capture).await?;
        let (warm, backend, cancel) = (Arc::clone(warm), Arc::clone(backend), cancel.clone());
        let id = warm.id();
        let share = self.take(motions.replay_bytes()).await?;
        let start = tokio::task::spawn_blocking(move || {
            let _share = share;
            replay(&warm, &motions, at, work_limit, &*backend, &cancel)
        })
        .await
        .map_err(|_| Error::Panicked)??;
        lock(&self.starts).insert((id, at), start.clone(), start.bytes());
        Ok(start)
    }

    /// The twin's shape where it comes to rest in a world.
    pub(super) async fn settled(
        &self,
        warm: &Arc<Warm>,
        world: Still,
        backend: &Arc<QueuedBackend>,
        cancel: &CancelToken,
        work_limit: u64,
    ) -> Result<Start, Error> {
        let key = (warm.id(), world.key());
        if let Some(start) = lock(&self.settled).get(&key) {
            return Ok(start);
        }
        let _settling = self.settling.lock().await;
        if let Some(start) = lock(&self.settled).get(&key) {
            return Ok(start);
        }
        let (warm, backend, cancel) = (Arc::clone(warm), Arc::clone(backend), cancel.clone());
        let settle = move || settle(&warm, &world, work_limit, backend.as_ref(), &cancel);
        let start = tokio::task::spawn_blocking(settle).await.map_err(|_| Error::Panicked)??;
        lock(&self.settled).insert(key, start.clone(), start.bytes());
        Ok(start)
    }

    async fn take(&self, bytes: u64) -> Result<Share, Error> {
        budget::take(&self.memory.rollouts, bytes, "a recording beside the twin").await
    }

    /// A recording, and the memory that it takes.
    pub(super) async fn recording(&self, id: CaptureId) -> Result<(Capture, Share), Error> {
        let _reading = self.reading.lock().await;
        let (file, limits, share) = self.fetch(id).await?;
        let read = tokio::task::spawn_blocking(move || {
            let read = observation::read(file.path(), &limits);
            read.map(|capture| (capture, share)).map_err(unreadable)
        });
        read.await.map_err(|_| Error::Panicked)?
    }

    /// The observation of a capture as a file, limits for reading it, and memory for it and what is
    /// made of it.
    async fn fetch(&self, id: CaptureId) -> Result<(NamedTempFile, Limits, Share), Error> {
        let name = observation::name(&id.to_string());
        let file = artifact::fetch_file(&self.server, &name, None, &self.dir).await?;
        let most = self.memory.rollouts.most() / 2;
        let limits = Limits { capture_bytes: self.limits.capture_bytes.min(most), ..self.limits };
        let share = self.take(2 * limits.capture_bytes).await?;
        Ok((file, limits, share))
    }

    async fn motions(&self, warm: &Arc<Warm>, id: CaptureId) -> Result<Arc<Motions>, Error> {
        let key = (warm.id(), id);
        if let Some(motions) = lock(&self.motions).get(&key) {
            return Ok(motions);
        }
        let _reading = self.reading.lock().await;
        if let Some(motions) = lock(&self.motions).get(&key) {
            return Ok(motions);
        }
        let (file, limits, share) = self.fetch(id).await?;
        let warm = Arc::clone(warm);
        let motions = tokio::task::spawn_blocking(move || {
            let _share = share;
            let capture = observation::read(file.path(), &limits).map_err(unreadable)?;
            Ok::<_, Error>(Motions::new(warm.twin(), &capture)?)
        })
        .await
        .map_err(|_| Error::Panicked)??;
        let motions = Arc::new(motions);
        lock(&self.motions).insert(key, Arc::clone(&motions), motions.bytes());
        Ok(motions)
    }
}

/// The refusal of a capture that cannot be read.
fn unreadable(error: impl Display) -> Error {
    bendtwin_rollout::Error::Capture(error.to_string()).into()
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

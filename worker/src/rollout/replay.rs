//! Initial states that a simulation leads to. In a frame of a capture the twin follows the capture's own controls up to
//! that frame, as its ingest observed them. Observations are large and frames are asked for again
//! and again, so controls and replayed states are kept, not observations.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use bendtwin_budget::Share;
use bendtwin_contract::rollout;
use bendtwin_core::{
    CancelToken, Capture, Point, Twin,
    ids::{CaptureId, TwinId},
};
use bendtwin_engine::{
    Backend as _, Objective,
    backend::{Instance, Outputs},
    model::State,
};
use bendtwin_eval::{check_capture, initial_state};
use tempfile::NamedTempFile;

use super::{
    error::Error,
    initial::{CaptureFrame, Start},
    lru::Lru,
    settle::settle,
    warm::Warm,
    world::Still,
};
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
/// Memory of a control point in a frame of a replay: as it is kept, and as the engine reads it.
const REPLAYED: u64 = 40;

/// The part of a capture's sequence that a twin needs.
struct Motion {
    start_frame: usize,
    start: Arc<State>,
    /// Control points [m], shape [T, C, 3].
    controls: Vec<Point>,
    frame_count: usize,
}

/// All sequences of a capture.
type Motions = Arc<Vec<Motion>>;

/// Replays captures, and remembers.
pub(crate) struct Replays {
    server: ServerClient,
    dir: PathBuf,
    limits: Limits,
    memory: Memory,
    motions: Mutex<Lru<(TwinId, CaptureId), Motions>>,
    starts: Mutex<Lru<(TwinId, CaptureFrame), Start>>,
    /// By twin and world.
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
        if let Some(start) = lock(&self.starts).get(&(warm.id, at)) {
            return Ok(start);
        }
        let motions = self.motions(warm, at.capture).await?;
        let (warm, backend, cancel) = (Arc::clone(warm), Arc::clone(backend), cancel.clone());
        let id = warm.id;
        let controls = motions.iter().map(|m| m.controls.len() as u64).max().unwrap_or(0);
        let share = self.take(controls.saturating_mul(REPLAYED)).await?;
        let start = tokio::task::spawn_blocking(move || {
            let _share = share;
            replay(&warm, &motions, at, work_limit, &backend, &cancel)
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
        let key = (warm.id, world.key());
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
            read.map(|capture| (capture, share)).map_err(|e| Error::Capture(e.to_string()))
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

    async fn motions(&self, warm: &Arc<Warm>, id: CaptureId) -> Result<Motions, Error> {
        let key = (warm.id, id);
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
            let capture = observation::read(file.path(), &limits)
                .map_err(|e| Error::Capture(e.to_string()))?;
            motions_of(&warm.twin, &capture)
        })
        .await
        .map_err(|_| Error::Panicked)??;
        let motions = Arc::new(motions);
        let size = motions.iter().map(|m| 12 * m.controls.len() + 24 * m.start.positions.len());
        lock(&self.motions).insert(key, Arc::clone(&motions), size.sum::<usize>() as u64);
        Ok(motions)
    }
}

fn motions_of(twin: &Twin, capture: &Capture) -> Result<Vec<Motion>, Error> {
    check_capture(capture).map_err(|e| Error::Capture(e.to_string()))?;
    if (twin.timing.fps - capture.fps).abs() > 1e-6 * capture.fps {
        return Err(Error::Capture(format!(
            "it has {} frames a second, the twin {}",
            capture.fps, twin.timing.fps
        )));
    }
    let controls = twin.graph.control_count();
    let sequences = capture.sequences.iter().map(|sequence| {
        if sequence.control_count() != controls {
            return Err(Error::Capture(format!(
                "sequence `{}` has {} control points, the twin has {controls}",
                sequence.name,
                sequence.control_count()
            )));
        }
        Ok(Motion {
            start_frame: sequence.start_frame(),
            start: Arc::new(initial_state(&twin.graph, capture.fps, sequence)),
            controls: sequence.controls.clone(),
            frame_count: sequence.frame_count,
        })
    });
    sequences.collect()
}

fn replay(
    warm: &Warm,
    motions: &[Motion],
    at: CaptureFrame,
    work_limit: u64,
    backend: &QueuedBackend,
    cancel: &CancelToken,
) -> Result<Start, Error> {
    let Some(motion) = motions.get(at.sequence) else {
        let fault = format!(
            "is {}: the capture has {} sequences (counted from 0)",
            at.sequence,
            motions.len()
        );
        return Err(Error::field("initial.capture_frame.sequence", fault));
    };
    if !(motion.start_frame..motion.frame_count).contains(&at.frame) {
        let fault = format!(
            "is {}: the sequence can be entered in frames {}..={}",
            at.frame,
            motion.start_frame,
            motion.frame_count.saturating_sub(1)
        );
        return Err(Error::field("initial.capture_frame.frame", fault));
    }
    let frames = at.frame - motion.start_frame;
    let (graph, timing) = (&warm.twin.graph, warm.twin.timing);
    let elements = (graph.node_count() + graph.springs.len() + graph.triplets.len()) as u128;
    let work = frames as u128 * u128::from(timing.substeps) * elements;
    if work > u128::from(work_limit) {
        return Err(Error::Request(rollout::Error::TooLarge {
            what: "the work of the replay",
            asked: u64::try_from(work).unwrap_or(u64::MAX),
            limit: work_limit,
            advice: "start at an earlier frame",
        }));
    }
    let width = graph.control_count();
    let row = |frame: usize| &motion.controls[frame * width..(frame + 1) * width];
    let controls = Arc::new(row(at.frame).to_vec());
    if frames == 0 {
        return Ok(Start::new(Arc::clone(&motion.start), controls));
    }
    let instance = Instance {
        model: warm.loaded.clone(),
        initial: Arc::clone(&motion.start),
        controls: Arc::new(
            motion.controls[motion.start_frame * width..(at.frame + 1) * width].to_vec(),
        ),
        frames,
        objective: Objective::default(),
        world: Arc::default(),
        motion: Arc::default(),
    };
    let outputs = Outputs { final_state: true, ..Outputs::default() };
    let rollout = backend.roll_out(&[instance], &outputs, cancel)?.into_iter().next();
    let rollout = rollout.unwrap_or_default();
    if let Some(divergence) = rollout.diverged {
        return Err(Error::ReplayDiverged { frame: motion.start_frame + divergence.frame });
    }
    match rollout.final_state {
        Some(state) => Ok(Start::new(Arc::new(state), controls)),
        None => {
            Err(bendtwin_engine::Error::Device("no final state was returned".to_owned()).into())
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

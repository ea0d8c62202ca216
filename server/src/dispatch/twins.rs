//! Facts of twins that rollouts need, at hand. Twins never change, so the hot path asks the
//! database once for each, or not at all: the facts of twins that workers have loaded are read
//! beforehand, so that these rollouts are answered while the database is away.

use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use bendtwin_contract::rollout::{PlannerShape, TwinShape};
use bendtwin_core::{
    Category, Problem as _,
    ids::{CaptureId, TwinId},
};
use bendtwin_store::{Store, Twin};

use crate::app::Result;

/// Largest number of twins whose facts are kept at hand.
const REMEMBERED: usize = 1024;

/// Facts of a twin.
#[derive(Clone, Debug)]
pub(super) struct TwinSummary {
    pub(super) owner: Arc<str>,
    /// The capture that it was fitted to, unless it was imported.
    pub(super) capture: Option<CaptureId>,
    pub(super) shape: TwinShape,
    /// Seconds from frame to frame.
    pub(super) frame_s: f64,
}

/// The twins that were asked for lately. Clones share them.
#[derive(Clone, Debug, Default)]
pub(super) struct Twins {
    known: Arc<Mutex<HashMap<TwinId, TwinSummary>>>,
    /// True while facts are read beforehand.
    is_preparing: Arc<AtomicBool>,
}

impl Twins {
    /// The facts of a twin, from the database if need be.
    pub(super) async fn get(&self, store: &Store, id: TwinId) -> Result<TwinSummary> {
        if let Some(known) = self.lock().get(&id) {
            return Ok(known.clone());
        }
        let known = TwinSummary::from(&store.twins().get(id).await?);
        let mut twins = self.lock();
        if twins.len() >= REMEMBERED
            && let Some(any) = twins.keys().next().copied()
        {
            twins.remove(&any);
        }
        twins.insert(id, known.clone());
        Ok(known)
    }

    /// Reads the facts of those of these twins that are not known, in a separate task, unless others
    /// are being read.
    pub(super) fn prepare(&self, store: &Store, twins: &[TwinId]) {
        let mut unknown: Vec<TwinId> = {
            let known = self.lock();
            twins.iter().filter(|id| !known.contains_key(id)).copied().collect()
        };
        unknown.truncate(REMEMBERED);
        if unknown.is_empty() || self.is_preparing.swap(true, Ordering::SeqCst) {
            return;
        }
        let (twins, store) = (self.clone(), store.clone());
        tokio::spawn(async move {
            for id in unknown {
                // A rollout that needs it reports what is wrong.
                if let Err(error) = twins.get(&store, id).await {
                    tracing::debug!(twin = %id, %error, "a loaded twin cannot be read");
                    if error.category() == Category::Unavailable {
                        break;
                    }
                }
            }
            twins.is_preparing.store(false, Ordering::SeqCst);
        });
    }

    pub(super) fn forget(&self, id: TwinId) {
        self.lock().remove(&id);
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<TwinId, TwinSummary>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl From<&Twin> for TwinSummary {
    fn from(twin: &Twin) -> Self {
        let facts = &twin.facts;
        let shape = TwinShape {
            nodes: u64::from(facts.node_count),
            springs: u64::from(facts.spring_count),
            triplets: u64::from(facts.triplet_count),
            controls: u64::from(facts.control_count),
            skin_points: facts.skin_point_count.map(u64::from),
            rods: None,
            substeps: facts.substeps,
            fast_substeps: fast_substeps(&facts.quality),
            planner: planner(&facts.quality),
            has_capture: twin.capture.is_some(),
        };
        Self {
            owner: twin.owner.as_str().into(),
            capture: twin.capture,
            shape,
            frame_s: facts.fps.recip(),
        }
    }
}

/// Substeps of the fast variant in a quality table. Only that is read of it: a worker of a newer
/// build may have written more than this server knows.
fn fast_substeps(quality: &str) -> Option<u32> {
    let quality: serde_json::Value = serde_json::from_str(quality).ok()?;
    u32::try_from(quality.pointer("/fast/substeps")?.as_u64()?).ok()
}

/// Size of the planner's twin in a quality table, read as substeps of the fast variant are.
fn planner(quality: &str) -> Option<PlannerShape> {
    let quality: serde_json::Value = serde_json::from_str(quality).ok()?;
    let number = |name: &str| quality.pointer("/planner")?.get(name)?.as_u64();
    Some(PlannerShape {
        nodes: number("nodes")?,
        springs: number("springs")?,
        triplets: number("triplets")?,
        substeps: u32::try_from(number("substeps")?).ok()?,
    })
}

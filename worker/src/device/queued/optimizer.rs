//! An [`Optimizer`] that lives on the device thread; its batches are cut into slices like those of
//! the backend.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bendtwin_core::{CancelToken, Timing};
use bendtwin_engine::{
    Backend, Loaded,
    backend::{Error, GradientRequest},
    optimizer::{Decay, GradientNorm, GradientSample, Optimizer, OptimizerInit, Position},
};

use super::{Pass, Shared, all, instance_work};

/// The backend's own optimizer; only tasks on the device thread open the slot.
type Slot = Arc<Mutex<Option<Box<dyn Optimizer>>>>;

/// Handle of the optimizer for its owner.
pub(super) struct QueuedOptimizer {
    shared: Arc<Shared>,
    slot: Slot,
}

impl QueuedOptimizer {
    pub(super) fn new(
        shared: Arc<Shared>,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Self, Error> {
        let (optimizer, _) = shared.call(move |backend| backend.optimizer(inits.clone(), decay))?;
        Ok(Self { shared, slot: Arc::new(Mutex::new(Some(optimizer))) })
    }

    fn call<R: Send + 'static>(
        &self,
        task: impl FnOnce(&mut dyn Optimizer) -> Result<R, Error> + Send + 'static,
    ) -> Result<R, Error> {
        Ok(self.shared.call_once(on(&self.slot, task))?.0)
    }
}

fn open(slot: &Slot) -> MutexGuard<'_, Option<Box<dyn Optimizer>>> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A task for the device thread that opens the slot.
fn on<R, J: FnOnce(&mut dyn Optimizer) -> Result<R, Error> + Send>(
    slot: &Slot,
    task: J,
) -> impl FnOnce(&dyn Backend) -> Result<R, Error> + Send + use<R, J> {
    let slot = Arc::clone(slot);
    move |_: &dyn Backend| match open(&slot).as_mut() {
        Some(optimizer) => task(&mut **optimizer),
        None => Err(Error::Device("the optimizer has ended".into())),
    }
}

impl Drop for QueuedOptimizer {
    /// Frees the optimizer on the device's thread, to which it belongs, without waiting.
    fn drop(&mut self) {
        let slot = self.slot.clone();
        let free = move |_: &dyn Backend| {
            drop(open(&slot).take());
            Ok(())
        };
        let flow = &self.shared.flow;
        self.shared.device.queue(flow.priority).push(flow, Box::new(free));
    }
}

impl Optimizer for QueuedOptimizer {
    fn loaded(&mut self, walk: usize) -> Result<Loaded, Error> {
        self.call(move |optimizer| optimizer.loaded(walk))
    }

    /// Slices keep the batch's order, for it is the order in which gradients wait.
    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        let work: Vec<f64> = batch.iter().map(|p| instance_work(&p.instance)).collect();
        let order: Vec<usize> = (0..batch.len()).collect();
        let results =
            self.shared.in_slices(batch, &work, &order, Pass::Backward, cancel, |slice| {
                let (request, token) = (request.clone(), self.shared.token(cancel));
                let task =
                    on(&self.slot, move |optimizer| optimizer.measure(&slice, &request, &token));
                // Never twice: after an error some of the slice's gradients may wait.
                let result = self.shared.call_once(task);
                if let Err(Error::OutOfMemory { .. }) = result {
                    // The next attempt at the fit resumes from its checkpoint, and finds memory.
                    self.shared.device.reclaim(u64::MAX);
                }
                result
            })?;
        all(results)
    }

    fn step(&mut self, walk: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        let weights = weights.to_vec();
        self.call(move |optimizer| optimizer.step(walk, &weights, rate))
    }

    fn discard(&mut self, walk: usize) -> Result<(), Error> {
        self.call(move |optimizer| optimizer.discard(walk))
    }

    fn position(&self, walk: usize) -> Result<Position, Error> {
        self.call(move |optimizer| optimizer.position(walk))
    }

    fn move_to(&mut self, walk: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        let position = position.clone();
        self.call(move |optimizer| optimizer.move_to(walk, &position, timing))
    }
}

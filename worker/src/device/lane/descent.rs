//! A [`Descent`] that lives on the device thread; its batches are cut into slices like a lane's.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bendtwin_core::{CancelToken, Timing};
use bendtwin_engine::{
    Backend, Loaded,
    backend::{Error, GradientRequest},
    descent::{Decay, Descent, Position, Probe, Slope, Start},
};

use super::{Access, Way, instance_work};

/// The backend's own descent; only jobs on the device thread open the slot.
type Slot = Arc<Mutex<Option<Box<dyn Descent>>>>;

/// The descent as its owner sees it.
pub(super) struct LaneDescent {
    access: Arc<Access>,
    slot: Slot,
}

impl LaneDescent {
    pub(super) fn new(
        access: Arc<Access>,
        starts: Vec<Start>,
        decay: Decay,
    ) -> Result<Self, Error> {
        let (descent, _) = access.call(move |backend| backend.descent(starts.clone(), decay))?;
        Ok(Self { access, slot: Arc::new(Mutex::new(Some(descent))) })
    }

    fn call<R: Send + 'static>(
        &self,
        job: impl FnOnce(&mut dyn Descent) -> Result<R, Error> + Send + 'static,
    ) -> Result<R, Error> {
        Ok(self.access.call_once(on(&self.slot, job))?.0)
    }
}

fn open(slot: &Slot) -> MutexGuard<'_, Option<Box<dyn Descent>>> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A job for the device thread that opens the slot.
fn on<R, J: FnOnce(&mut dyn Descent) -> Result<R, Error> + Send>(
    slot: &Slot,
    job: J,
) -> impl FnOnce(&dyn Backend) -> Result<R, Error> + Send + use<R, J> {
    let slot = Arc::clone(slot);
    move |_: &dyn Backend| match open(&slot).as_mut() {
        Some(descent) => job(&mut **descent),
        None => Err(Error::Device("the descent has ended".into())),
    }
}

impl Drop for LaneDescent {
    /// What belongs to the device is freed on its thread; nobody waits for it.
    fn drop(&mut self) {
        let slot = self.slot.clone();
        let free = move |_: &dyn Backend| {
            drop(open(&slot).take());
            Ok(())
        };
        self.access.device.queue(self.access.priority).push(self.access.priority, Box::new(free));
    }
}

impl Descent for LaneDescent {
    fn loaded(&mut self, walk: usize) -> Result<Loaded, Error> {
        self.call(move |descent| descent.loaded(walk))
    }

    /// Slices keep the batch's order, for it is the order in which gradients wait.
    fn measure(
        &mut self,
        batch: &[Probe],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Slope>, Error> {
        let work: Vec<f64> = batch.iter().map(|p| instance_work(&p.instance)).collect();
        let order: Vec<usize> = (0..batch.len()).collect();
        self.access.in_slices(batch, &work, &order, Way::Backward, cancel, |slice| {
            let (request, token) = (request.clone(), cancel.clone());
            let job = on(&self.slot, move |descent| descent.measure(&slice, &request, &token));
            // Never twice: after an error some of the slice's gradients may wait.
            let result = self.access.call_once(job);
            if let Err(Error::OutOfMemory { .. }) = result {
                // The next attempt at the fit goes on from its checkpoint, and finds room.
                self.access.device.reclaim(u64::MAX);
            }
            result
        })
    }

    fn step(&mut self, walk: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        let weights = weights.to_vec();
        self.call(move |descent| descent.step(walk, &weights, rate))
    }

    fn discard(&mut self, walk: usize) -> Result<(), Error> {
        self.call(move |descent| descent.discard(walk))
    }

    fn position(&self, walk: usize) -> Result<Position, Error> {
        self.call(move |descent| descent.position(walk))
    }

    fn move_to(&mut self, walk: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        let position = position.clone();
        self.call(move |descent| descent.move_to(walk, &position, timing))
    }
}

//! A [`Descent`] that lives on the device thread; its batches are cut into slices like a lane's.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bendtwin_core::Timing;
use bendtwin_engine::{
    Loaded,
    backend::{CancelToken, Error, GradientRequest},
    descent::{Decay, Descent, Position, Probe, Slope, Start},
};

use super::{Access, instance_work};

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
        let descent = access.call(move |backend| backend.descent(starts, decay))?;
        Ok(Self { access, slot: Arc::new(Mutex::new(Some(descent))) })
    }

    fn call<R: Send + 'static>(
        &self,
        job: impl FnOnce(&mut dyn Descent) -> Result<R, Error> + Send + 'static,
    ) -> Result<R, Error> {
        let slot = self.slot.clone();
        self.access.call(move |_| with(&slot, job))
    }
}

fn open(slot: &Slot) -> MutexGuard<'_, Option<Box<dyn Descent>>> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

fn with<R>(
    slot: &Slot,
    job: impl FnOnce(&mut dyn Descent) -> Result<R, Error>,
) -> Result<R, Error> {
    match open(slot).as_mut() {
        Some(descent) => job(&mut **descent),
        None => Err(Error::Device("the descent has ended".into())),
    }
}

impl Drop for LaneDescent {
    /// What belongs to the device is freed on its thread; nobody waits for it.
    fn drop(&mut self) {
        let slot = self.slot.clone();
        let free = move |_: &dyn bendtwin_engine::Backend| {
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
        let (slot, request, token) = (self.slot.clone(), request.clone(), cancel.clone());
        let usage = &self.access.backward;
        self.access.in_slices(batch, &work, &order, usage, cancel, move |_, slice| {
            with(&slot, |descent| descent.measure(slice, &request, &token))
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

//! Things that are on a device once, by the host's: models with the same graph share it, and so do
//! those with the same skin.

use std::sync::{Arc, Mutex, Weak};

use crate::device::memo::lock;

/// The device's copies of the host's things while they are in use.
pub(crate) struct Shared<Host, Copied>(Mutex<Vec<(Weak<Host>, Slot<Copied>)>>);

/// A slot for each of them, so that only those who want the same one wait for it.
type Slot<Copied> = Arc<Mutex<Weak<Copied>>>;

impl<Host, Copied> Default for Shared<Host, Copied> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<Host, Copied> Shared<Host, Copied> {
    /// The device's copy of a thing, made by the first who asks.
    pub(crate) fn get_or_make<E>(
        &self,
        host: &Arc<Host>,
        make: impl FnOnce() -> Result<Copied, E>,
    ) -> Result<Arc<Copied>, E> {
        let slot = self.slot_of(host);
        let mut slot = lock(&slot);
        if let Some(known) = slot.upgrade() {
            return Ok(known);
        }
        let made = Arc::new(make()?);
        *slot = Arc::downgrade(&made);
        Ok(made)
    }

    fn slot_of(&self, host: &Arc<Host>) -> Slot<Copied> {
        let mut slots = lock(&self.0);
        slots.retain(|(host, _)| host.strong_count() > 0);
        // A weak reference keeps the address: nothing else can have it.
        let same = |known: &Weak<Host>| std::ptr::eq(known.as_ptr(), Arc::as_ptr(host));
        if let Some((_, slot)) = slots.iter().find(|(known, _)| same(known)) {
            return slot.clone();
        }
        let slot = Slot::default();
        slots.push((Arc::downgrade(host), slot.clone()));
        slot
    }
}

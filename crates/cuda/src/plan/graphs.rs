//! Graphs that are on a device, by the host's: models with the same graph share it.

use std::sync::{Arc, Mutex, Weak};

use bendtwin_core::Graph;
use bendtwin_engine::Error;

use crate::{
    device::{Device, memo::lock},
    plan::graph::DeviceGraph,
};

/// Graphs while they are in use.
#[derive(Default)]
pub(crate) struct Graphs(Mutex<Vec<(Weak<Graph>, Slot)>>);

/// A slot for each graph, so that only those who want the same one wait for it.
type Slot = Arc<Mutex<Weak<DeviceGraph>>>;

impl Graphs {
    /// A graph on the device, put there by the first who asks.
    pub(crate) fn get(
        &self,
        device: &Device,
        graph: &Arc<Graph>,
    ) -> Result<Arc<DeviceGraph>, Error> {
        let slot = self.slot_of(graph);
        let mut slot = lock(&slot);
        if let Some(known) = slot.upgrade() {
            return Ok(known);
        }
        let made = Arc::new(DeviceGraph::new(device, graph)?);
        *slot = Arc::downgrade(&made);
        Ok(made)
    }

    fn slot_of(&self, graph: &Arc<Graph>) -> Slot {
        let mut graphs = lock(&self.0);
        graphs.retain(|(host, _)| host.strong_count() > 0);
        // A weak reference keeps the address: no other graph can have it.
        let same = |host: &Weak<Graph>| std::ptr::eq(host.as_ptr(), Arc::as_ptr(graph));
        if let Some((_, slot)) = graphs.iter().find(|(host, _)| same(host)) {
            return slot.clone();
        }
        let slot = Slot::default();
        graphs.push((Arc::downgrade(graph), slot.clone()));
        slot
    }
}

//! Memory that a measurement took.

use std::sync::Arc;

use bendtwin_engine::Backend;

/// Probe of the memory that work takes.
pub trait MemoryProbe {
    /// Resets the peak. Called before a scene is loaded; without effect on probes that measure no
    /// peak.
    fn reset(&self);

    /// Bytes in use now, or at most in use since [`MemoryProbe::reset`]; `None` if unknown.
    fn used_bytes(&self) -> Option<u64>;
}

/// No-op probe.
impl MemoryProbe for () {
    fn reset(&self) {}

    fn used_bytes(&self) -> Option<u64> {
        None
    }
}

/// Memory of a device beyond what was in use when the probe was made, which was before anything was
/// loaded: its runtime's own share does not count, nor that of others as long as it stays the same.
pub struct DeviceMemory {
    backend: Arc<dyn Backend>,
    before: u64,
}

impl DeviceMemory {
    /// A probe of the backend's device; `None` if its memory is not known.
    pub fn new(backend: &Arc<dyn Backend>) -> Option<Self> {
        let before = backend.memory()?.used;
        Some(Self { backend: backend.clone(), before })
    }
}

impl MemoryProbe for DeviceMemory {
    fn reset(&self) {}

    fn used_bytes(&self) -> Option<u64> {
        self.backend.memory().map(|m| m.used.saturating_sub(self.before))
    }
}

//! Memory that a measurement took.

use std::sync::Arc;

use bendtwin_engine::Backend;

/// Knows how much memory the work takes.
pub trait MemoryProbe {
    /// Called before a scene is loaded: what was used at most before no longer counts, where that can be told apart.
    fn reset(&self);

    /// Bytes in use now, or at most in use since [`MemoryProbe::reset`]; `None` if unknown.
    fn used_bytes(&self) -> Option<u64>;
}

/// A probe that knows nothing.
impl MemoryProbe for () {
    fn reset(&self) {}

    fn used_bytes(&self) -> Option<u64> {
        None
    }
}

/// Memory of a device beyond what was in use when the probe was made, which was before anything was loaded: its
/// runtime's own share does not count, nor that of others as long as it stays the same.
pub struct DeviceMemory {
    backend: Arc<dyn Backend>,
    before: u64,
}

impl DeviceMemory {
    /// A probe of the backend's device; `None` if that cannot tell.
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

//! A stream with what its work shares: launches in order, staging memory for what comes back.

use std::sync::Arc;

use bendtwin_engine::Error;
use cudarc::driver::{CudaEvent, CudaStream};

use crate::{
    device::Device,
    fault,
    kernel::{Source, Variant},
    launch::Arguments,
    objective::Objectives,
    staging::Staging,
};

/// One of a device's two queues.
pub(crate) struct Queue {
    pub(crate) device: Arc<Device>,
    pub(crate) stream: Arc<CudaStream>,
    pub(crate) objectives: Objectives,
    pub(crate) staging: Staging,
}

impl Queue {
    pub(crate) fn new(device: &Arc<Device>, stream: &Arc<CudaStream>) -> Self {
        let (device, stream) = (device.clone(), stream.clone());
        Self { device, stream, objectives: Objectives::default(), staging: Staging::default() }
    }

    /// Launches a kernel that is not specialised.
    ///
    /// # Safety
    /// As [`crate::launch::Function::launch`].
    pub(crate) unsafe fn launch(
        &self,
        source: Source,
        name: &'static str,
        grid: (u32, u32, u32),
        arguments: &Arguments,
    ) -> Result<(), Error> {
        let function = self.device.function(&Variant::small(source), name)?;
        // SAFETY: the caller's promise.
        unsafe { function.launch(&self.stream, grid, 0, arguments) }
    }

    /// Waits for all work.
    pub(crate) fn synchronize(&self) -> Result<(), Error> {
        crate::synchronize(&self.stream)
    }

    /// Marks what has been launched so far.
    pub(crate) fn mark(&self) -> Result<CudaEvent, Error> {
        self.stream.record_event(None).map_err(|e| fault("recording an event", e))
    }
}

//! A stream with what its work shares: launches in order, staging memory for results.

use std::sync::Arc;

use bendtwin_engine::Error;
use cudarc::driver::{CudaEvent, CudaStream};

use super::{
    Device, fault,
    launch::Launch,
    staging::Staging,
    synchronize,
    team::{Team, TeamShape},
    wait,
};

/// Times after which the host lets others have their turn [us]. What waits for a fit waits for two of
/// its stretches at most: one that runs, one that is launched. Rollouts pause for fits alone, which
/// can wait longer.
const STRETCH_US: f64 = 1_000.0;
const URGENT_STRETCH_US: f64 = 10_000.0;

/// A queue of a device, of which there are two.
pub(crate) struct Queue {
    pub(crate) device: Arc<Device>,
    pub(crate) stream: Arc<CudaStream>,
    pub(crate) staging: Staging,
    /// Callers never wait for others' work, not even on the host.
    pub(crate) is_urgent: bool,
    concurrent: Vec<Arc<CudaStream>>,
}

/// Streams on which kernels run concurrently, forked off the queue's and joined to it again.
pub(crate) struct ForkedStreams<'a> {
    queue: &'a Queue,
    used: &'a [Arc<CudaStream>],
}

impl ForkedStreams<'_> {
    /// The stream of the k-th kernel, which is a team's. A grid has its barriers on the queue's own
    /// stream.
    pub(crate) fn of(&self, k: usize, team: &Team) -> &CudaStream {
        match self.used.len() {
            0 => &self.queue.stream,
            _ if team.shape == TeamShape::Grid => &self.queue.stream,
            count => &self.used[k % count],
        }
    }
}

impl Queue {
    pub(crate) fn normal(device: &Arc<Device>) -> Self {
        Self::new(device, &device.normal, &device.concurrent_normal, false)
    }

    pub(crate) fn urgent(device: &Arc<Device>) -> Self {
        Self::new(device, &device.urgent, &device.concurrent_urgent, true)
    }

    fn new(
        device: &Arc<Device>,
        stream: &Arc<CudaStream>,
        concurrent: &[Arc<CudaStream>],
        is_urgent: bool,
    ) -> Self {
        Self {
            device: device.clone(),
            stream: stream.clone(),
            concurrent: concurrent.to_vec(),
            staging: Staging::default(),
            is_urgent,
        }
    }

    /// Launches `count` kernels on concurrent streams: after everything launched before, and before
    /// everything launched later.
    pub(crate) fn launch_concurrently(
        &self,
        kernels: usize,
        mut launch: impl FnMut(usize, &ForkedStreams<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let count = if kernels > 1 { kernels.min(self.concurrent.len()) } else { 0 };
        let streams = ForkedStreams { queue: self, used: &self.concurrent[..count] };
        if count > 0 {
            let mark = self.mark()?;
            for stream in streams.used {
                stream.wait(&mark).map_err(|e| fault("forking a stream", e))?;
            }
        }
        let launched = (0..kernels).try_for_each(|k| launch(k, &streams));
        // Even if one failed: memory that the others use is freed behind what the queue has.
        let joined = streams.used.iter().map(|stream| self.join(stream)).fold(Ok(()), Result::and);
        launched.and(joined)
    }

    /// Orders later work of the queue after that of a forked stream; if that fails, waits for it.
    fn join(&self, stream: &CudaStream) -> Result<(), Error> {
        let joined = stream.record_event(None).and_then(|mark| self.stream.wait(&mark));
        joined.map_err(|e| {
            let _ = stream.synchronize();
            fault("joining a stream", e)
        })
    }

    /// A grid for a kernel without specialization, behind all that has been launched.
    pub(crate) fn grid(&self, x: u32, y: u32, z: u32) -> Launch<'_> {
        Launch::new(&self.device, &self.stream, [x, y, z])
    }

    /// Longest time of a launch, as far as it can be cut, and of what is launched between two waits
    /// [us].
    pub(crate) fn stretch_us(&self) -> f64 {
        if self.is_urgent { URGENT_STRETCH_US } else { STRETCH_US }
    }

    /// Waits for all work.
    pub(crate) fn synchronize(&self) -> Result<(), Error> {
        synchronize(&self.stream)
    }

    /// Waits for a mark of this queue.
    pub(crate) fn wait_for(&self, mark: &CudaEvent) -> Result<(), Error> {
        wait::for_event(mark, &self.stream).map_err(|e| fault("the device's work", e))
    }

    /// Marks the launches so far.
    pub(crate) fn mark(&self) -> Result<CudaEvent, Error> {
        self.stream.record_event(None).map_err(|e| fault("recording an event", e))
    }
}

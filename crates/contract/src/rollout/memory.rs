//! Memory of a rollout at a worker.

/// Memory of a request as it came, and its tensors unpacked once or twice [times its size].
const REQUEST: u64 = 3;

/// Memory of a rollout at a worker [bytes], an upper bound for the CPU; on a GPU the state of a
/// simulation is in the device's memory, and counted there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// The request.
    pub request: u64,
    /// The parts of it that are unpacked for all instances, and the reply.
    pub fixed: u64,
    /// An instance that is prepared.
    pub prepared: u64,
    /// An instance that runs, beyond that.
    pub running: u64,
}

impl Memory {
    /// Bytes beside the request, with `prepared` instances prepared together, on a device that runs
    /// `lanes` concurrently.
    pub fn bytes(&self, prepared: usize, lanes: usize) -> u64 {
        let prepared = prepared as u64;
        let running = prepared.min(lanes as u64);
        self.fixed
            .saturating_add(self.prepared.saturating_mul(prepared))
            .saturating_add(self.running.saturating_mul(running))
    }

    /// The least that the rollout can do with, request included: one instance after another.
    pub fn least(&self) -> u64 {
        self.request.saturating_add(self.bytes(1, 1))
    }
}

/// Memory of an encoded request of `encoded` bytes.
pub fn request_bytes(encoded: u64) -> u64 {
    encoded.saturating_mul(REQUEST)
}

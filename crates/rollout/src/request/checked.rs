//! A request that has passed the check, and the memory that it takes.

use bendtwin_contract::rollout::{self, Batch, Limits};
use bendtwin_proto::v1::RollOutRequest;

use crate::{cut, error::Error, run::plan::shape, twin::serve::Served};

/// Divisor of the memory for the part that one rollout takes if that is enough.
const PART: u64 = 4;

/// Room of a rollout at this worker.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Most bytes that one rollout is given.
    pub bytes: u64,
    /// Instances that the device runs concurrently.
    pub lanes: usize,
}

/// A request that has passed the check, the model that answers it, and what that takes.
pub struct Checked {
    pub(crate) request: RollOutRequest,
    pub(crate) batch: Batch,
    /// The model that answers it.
    pub(crate) served: Served,
    /// Instances of one message of the reply; 0: all in one.
    pub(crate) part_instances: u32,
    /// Instances prepared together.
    pub(crate) prepared: usize,
    /// Memory beside the request [bytes].
    pub(crate) bytes: u64,
}

impl Checked {
    /// Checks a request to a twin, whose own capture is named or empty; nothing is unpacked. The reply
    /// comes with `part_instances` instances to a message, 0 meaning all in one.
    ///
    /// # Errors
    /// If the request is wrong, does not fit the twin, or takes more than a limit allows.
    pub fn new(
        request: RollOutRequest,
        own_capture: &str,
        part_instances: u32,
        served: Served,
        limits: &Limits,
        room: Room,
    ) -> Result<Self, Error> {
        let twin = shape(served.twin(), !own_capture.is_empty());
        let batch = rollout::check_for(&request, &twin, limits, part_instances)?;
        let mut memory = rollout::memory(&request, &batch, &twin, part_instances);
        let models = rollout::models_bytes(&request, served.distinct_rests() as u64, &twin);
        memory.fixed = memory.fixed.saturating_add(models);
        let instances = usize::try_from(batch.instances).unwrap_or(usize::MAX);
        let mut prepared = cut::prepared(memory.prepared).min(instances).max(1);
        let bytes = |prepared| memory.bytes(prepared, room.lanes);
        while prepared > 1 && bytes(prepared) > room.bytes / PART && prepared / 2 >= room.lanes {
            prepared /= 2;
        }
        while prepared > 1 && bytes(prepared) > room.bytes {
            prepared /= 2;
        }
        let bytes = bytes(prepared);
        if bytes > room.bytes {
            return Err(Error::Request(rollout::too_much_memory(bytes, room.bytes)));
        }
        Ok(Self { request, batch, served, part_instances, prepared, bytes })
    }

    /// The request.
    pub fn request(&self) -> &RollOutRequest {
        &self.request
    }

    /// Memory that the rollout takes beside the request [bytes].
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

//! Bounds on what one rollout request may ask for.

use bendtwin_proto::worker::v1;
use serde::{Deserialize, Serialize};

/// Bytes that the messages between server and worker add to those of the public API, at most.
pub const ENVELOPE_BYTES: u64 = 64 << 10;

/// Bounds on what one rollout request may ask for. A server's options set them; workers receive
/// them when they register.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Size of a request [bytes].
    pub request_bytes: u64,
    /// Size of a request in JSON [bytes]. Its numbers take several times the memory of its text, so
    /// this is less than `request_bytes`: larger requests are sent as protobuf.
    pub json_bytes: u64,
    /// Size of a reply, or of one part of a streamed reply [bytes].
    pub reply_bytes: u64,
    /// Size of a reply that is written as nested lists of JSON [bytes, as protobuf]. Written out it
    /// is several times as large: larger replies are sent as base64 or as protobuf.
    pub json_reply_bytes: u64,
    /// Memory that a rollout may take at a worker, by [`memory`](super::memory()) [bytes].
    pub memory_bytes: u64,
    /// Number of instances.
    pub instances: u64,
    /// Horizon [frames].
    pub frames: u64,
    /// Number of costs.
    pub costs: u64,
    /// Length of the name of a cost [bytes].
    pub name_bytes: u64,
    /// Number of target points, summed over the frames in which they count and over all costs. They
    /// are held in memory; every cost counts for 16 more in each of its frames.
    pub targets: u64,
    /// Work in element substeps: instances x frames x substeps x (nodes + springs + triplets).
    pub work: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            request_bytes: 256 << 20,
            json_bytes: 16 << 20,
            reply_bytes: 256 << 20,
            json_reply_bytes: 16 << 20,
            memory_bytes: 2 << 30,
            instances: 65_536,
            frames: 100_000,
            costs: 256,
            name_bytes: 128,
            targets: 8_000_000,
            // About seven hours of one core at 40 million elements a second.
            work: 1_000_000_000_000,
        }
    }
}

impl Limits {
    /// Most bytes of a request on its way from the server to a worker.
    pub fn sent_request_bytes(&self) -> usize {
        usize::try_from(self.request_bytes.saturating_add(ENVELOPE_BYTES)).unwrap_or(usize::MAX)
    }

    /// Most bytes of a message of the reply on its way from a worker to the server.
    pub fn sent_reply_bytes(&self) -> usize {
        usize::try_from(self.reply_bytes.saturating_add(ENVELOPE_BYTES)).unwrap_or(usize::MAX)
    }
}

impl From<&Limits> for v1::RolloutLimits {
    fn from(limits: &Limits) -> Self {
        Self {
            request_bytes: limits.request_bytes,
            reply_bytes: limits.reply_bytes,
            instances: limits.instances,
            frames: limits.frames,
            costs: limits.costs,
            name_bytes: limits.name_bytes,
            targets: limits.targets,
            work: limits.work,
            memory_bytes: limits.memory_bytes,
        }
    }
}

/// A limit of zero is one that the sender does not know: the default holds.
impl From<&v1::RolloutLimits> for Limits {
    fn from(wire: &v1::RolloutLimits) -> Self {
        let known = |sent: u64, default: u64| if sent == 0 { default } else { sent };
        let default = Self::default();
        Self {
            request_bytes: known(wire.request_bytes, default.request_bytes),
            reply_bytes: known(wire.reply_bytes, default.reply_bytes),
            instances: known(wire.instances, default.instances),
            frames: known(wire.frames, default.frames),
            costs: known(wire.costs, default.costs),
            name_bytes: known(wire.name_bytes, default.name_bytes),
            targets: known(wire.targets, default.targets),
            work: known(wire.work, default.work),
            memory_bytes: known(wire.memory_bytes, default.memory_bytes),
            // Workers see no JSON.
            json_bytes: default.json_bytes,
            json_reply_bytes: default.json_reply_bytes,
        }
    }
}

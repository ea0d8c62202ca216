//! The wire contract: `bendtwin.v1` is public, `bendtwin.worker.v1` private
//! between server and workers. Generated types, plus the one place where
//! tensors and faults are packed and unpacked, and where rollouts and registrations are checked.

pub mod deadline;
pub mod fault;
mod job;
pub mod json;
pub mod registration;
pub mod rollout;
pub mod tensor;
pub mod worker_key;

/// The public API.
#[allow(missing_docs, unreachable_pub, clippy::all, clippy::pedantic)]
pub mod v1 {
    include!("generated/bendtwin.v1.rs");
}

/// The private contract between server and workers.
pub mod worker {
    /// Version 1.
    #[allow(missing_docs, unreachable_pub, clippy::all, clippy::pedantic)]
    pub mod v1 {
        include!("generated/bendtwin.worker.v1.rs");
    }
}

/// The encoded `FileDescriptorSet` of all services, for reflection and for descriptions of
/// messages.
pub const DESCRIPTORS: &[u8] = include_bytes!("generated/descriptors.bin");

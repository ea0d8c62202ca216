//! The wire contract: `bendtwin.v1` is public, `bendtwin.worker.v1` private
//! between server and workers. Generated types, plus the one place where
//! tensors, faults, deadlines and JSON are packed and unpacked. Rules of what a message may hold are
//! in `bendtwin_contract`.

pub mod deadline;
pub mod fault;
mod job;
pub mod json;
pub mod routes;
pub mod tensor;

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

/// The description of the HTTP API, OpenAPI 3.1 as JSON.
pub const OPENAPI: &str = include_str!("generated/openapi.json");

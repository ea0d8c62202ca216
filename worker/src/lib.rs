//! Data plane: leases jobs, owns the compute device, answers rollouts.
//! Knows no database. One process per device; the server may start it, but it
//! needs nothing from the server's process apart from its address and token.
//!
//! ```text
//!   fits ──► fit thread ────┐ background
//!                           ├──► device thread ──► backend
//!   rollout calls ──────────┘ interactive
//!   ingests ──► a child process each: captures are strangers' files
//! ```
//!
//! Everything that computes goes through the [`device`] in slices, so a rollout waits for one slice of a
//! fit at most; where the backend has a second, urgent queue, rollouts have a thread of their own and
//! run beside fits. Whatever happens to this
//! process, the server's lease runs out and another worker goes on from the
//! last checkpoint.

mod artifact;
mod device;
mod error;
#[cfg(test)]
mod faulty;
mod fit;
mod ingest;
mod job;
mod leasing;
mod link;
mod observation;
mod options;
mod presence;
mod rollout;
mod run;
mod scratch;

pub use error::Error;
pub use ingest::ingest_capture;
pub use options::{Limits, Options};
pub use run::run;

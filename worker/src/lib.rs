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
//! Everything that computes goes through the [`device`] in slices, so a rollout waits for one slice
//! of a fit at most. If the backend has a second, urgent queue, rollouts have their own
//! thread and run beside fits. If this process dies, its leases run out and another worker resumes
//! from the last checkpoint.

mod artifact;
mod budget;
mod device;
mod error;
#[cfg(test)]
mod faulty;
mod fit;
mod health;
mod ingest;
mod job;
mod leasing;
mod observation;
mod options;
mod priority;
mod registration;
mod rollout;
mod run;
mod scratch;
mod server_client;
mod tls;

pub use error::Error;
pub use health::{Health, health};
pub use ingest::{Enforced, Layer, Resources, Sandbox, available, confine, ingest_capture};
pub use options::{FIT_SHARE, LISTEN, Limits, Options};
pub use run::run;

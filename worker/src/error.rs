//! Why a worker process ends.

use bendtwin_core::{Category, Problem};
use bendtwin_engine as engine;

/// Why a worker could not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An option cannot work.
    #[error("{0}")]
    Options(String),
    /// The server's address is none.
    #[error("`{url}` is not a server address: give one like http://127.0.0.1:7070")]
    Address {
        /// What was given.
        url: String,
    },
    /// The address for rollouts cannot be bound.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The address.
        address: String,
        /// Why.
        source: std::io::Error,
    },
    /// The compute device cannot be opened.
    #[error("cannot open the compute device: {0}")]
    Device(#[from] engine::Error),
    /// A thread or directory cannot be made.
    #[error("cannot {what}: {source}")]
    System {
        /// What was tried.
        what: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// The server refuses this worker.
    #[error("the server refuses this worker: {0}")]
    Refused(String),
    /// A job panicked; the process must restart, for a device's state cannot be trusted after that.
    #[error("a job panicked ({0}); this worker ends so that a fresh one can start")]
    Panicked(String),
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Options(_) | Self::Address { .. } => Category::InvalidArgument,
            Self::Listen { .. } | Self::System { .. } => Category::Unavailable,
            Self::Device(e) => e.category(),
            Self::Refused(_) => Category::PermissionDenied,
            Self::Panicked(_) => Category::Internal,
        }
    }
    fn reason(&self) -> &'static str {
        match self {
            Self::Options(_) => "INVALID_OPTIONS",
            Self::Address { .. } => "INVALID_SERVER_ADDRESS",
            Self::Listen { .. } => "CANNOT_LISTEN",
            Self::System { .. } => "SYSTEM_REFUSED",
            Self::Device(e) => e.reason(),
            Self::Refused(_) => "WORKER_REFUSED",
            Self::Panicked(_) => "JOB_PANICKED",
        }
    }
}

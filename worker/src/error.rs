//! Errors that end a worker process.

use bendtwin_core::{Category, Problem};

/// Reason why a worker could not start or had to stop.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An option cannot work.
    #[error("{0}")]
    Options(String),
    /// The server's address is not a URL.
    #[error("`{url}` is not a server address: give one like http://127.0.0.1:7070")]
    Address {
        /// The address as given.
        url: String,
    },
    /// The files of its certificate cannot be used.
    #[error("no TLS: {0}")]
    Certificate(#[from] bendtwin_tls::FileError),
    /// The address for rollouts cannot be bound.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The address.
        address: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// The chosen backend cannot be opened.
    #[error(transparent)]
    Backend(#[from] bendtwin_backends::Error),
    /// The compute device failed. A device that has failed once may fail or lie from then on, so
    /// the process must restart.
    #[error("the compute device failed ({0}); this worker ends so that a fresh one can start")]
    DeviceFailed(String),
    /// A thread or directory cannot be made.
    #[error("cannot {what}: {source}")]
    System {
        /// The operation that failed.
        what: &'static str,
        /// The system's error.
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
            Self::Certificate(e) => e.category(),
            Self::Backend(e) => e.category(),
            Self::Refused(_) => Category::PermissionDenied,
            Self::DeviceFailed(_) | Self::Panicked(_) => Category::Internal,
        }
    }
    fn reason(&self) -> &'static str {
        match self {
            Self::Options(_) => "INVALID_OPTIONS",
            Self::Address { .. } => "INVALID_SERVER_ADDRESS",
            Self::Listen { .. } => "CANNOT_LISTEN",
            Self::System { .. } => "SYSTEM_REFUSED",
            Self::Certificate(e) => e.reason(),
            Self::Backend(e) => e.reason(),
            Self::DeviceFailed(_) => "DEVICE_FAILED",
            Self::Refused(_) => "WORKER_REFUSED",
            Self::Panicked(_) => "JOB_PANICKED",
        }
    }
}

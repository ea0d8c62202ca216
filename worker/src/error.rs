//! Errors that end a worker process.

use bendtwin_core::Problem;

/// Reason why a worker could not start or had to stop.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// An option cannot work.
    #[error("{0}")]
    #[problem(InvalidArgument, "INVALID_OPTIONS")]
    Options(String),
    /// The server's address is not a URL.
    #[error("`{url}` is not a server address: give one like http://127.0.0.1:7070")]
    #[problem(InvalidArgument, "INVALID_SERVER_ADDRESS")]
    Address {
        /// The address as given.
        url: String,
    },
    /// The files of its certificate cannot be used.
    #[error("no TLS: {0}")]
    #[problem(transparent)]
    Certificate(#[from] bendtwin_tls::FileError),
    /// The address for rollouts cannot be bound.
    #[error("cannot listen on {address}: {source}")]
    #[problem(Unavailable, "CANNOT_LISTEN")]
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
    #[problem(Internal, "DEVICE_FAILED")]
    DeviceFailed(String),
    /// A thread or directory cannot be made.
    #[error("cannot {what}: {source}")]
    #[problem(Unavailable, "SYSTEM_REFUSED")]
    System {
        /// The operation that failed.
        what: &'static str,
        /// The system's error.
        source: std::io::Error,
    },
    /// The server refuses this worker.
    #[error("the server refuses this worker: {0}")]
    #[problem(PermissionDenied, "WORKER_REFUSED")]
    Refused(String),
    /// A job panicked; the process must restart, for a device's state cannot be trusted after that.
    #[error("a job panicked ({0}); this worker ends so that a fresh one can start")]
    #[problem(Internal, "JOB_PANICKED")]
    Panicked(String),
}

//! Control plane: HTTP and gRPC on one port, the queue of fits, routing of
//! rollouts to workers, and the worker processes themselves. Knows no physics.
//!
//! ```no_run
//! # async fn run() -> Result<(), bendtwin_server::StartError> {
//! use bendtwin_server::{Options, Service};
//! let handle = Service::start(Options::default()).await?;
//! println!("http://{}", handle.local_addr());
//! handle.shutdown().await;
//! # Ok(())
//! # }
//! ```
//!
//! `app/` has the use cases and knows no transport; `http/` and `grpc/` turn
//! them into two APIs over one error table (`refusal.rs`), and call nothing else; `access/` says who
//! may call what, `sign_in/` who a person is; `dispatch/` knows the workers and routes rollouts;
//! `supervise.rs` keeps worker processes alive. Plays, which advance sessions in real time, are
//! `bendtwin_play`, whose host is `app/plays.rs`.

pub mod access;
mod app;
mod audit;
mod context;
mod deadline;
mod dispatch;
mod error;
mod grpc;
mod http;
mod listen;
mod memory;
mod metrics;
mod options;
mod refusal;
mod service;
mod sign_in;
mod supervise;
mod tls;
mod twin_page;

/// Check, repair and backup of a data folder.
pub use bendtwin_store::{DatabaseUrl, ObjectsUrl, maintenance};
#[doc(hidden)]
pub use http::uploads::read_upload_headers;
pub use options::{
    ClientTokenPolicy, DefaultQuotas, Limits, Options, Queue, RetentionRule, SignIn, Tls,
    WorkerPolicy, WorkerTls,
};
pub use refusal::http_status;
pub use service::{Handle, Service, StartError};
pub use supervise::{
    BACKEND_VARIABLE, DEVICE_VARIABLE, MEMORY_VARIABLE, SCRATCH_VARIABLE, SERVER_VARIABLE,
    TOKEN_VARIABLE,
};
pub use twin_page::twin_page_template;

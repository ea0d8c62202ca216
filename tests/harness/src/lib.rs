//! A test cluster: real processes in a temporary folder, and typed calls to them. For tests: what
//! fails here panics, and so fails the test.

pub mod api;
pub mod cluster;
pub mod command;
pub mod fleet;
pub mod http;
pub mod play;
pub mod postgres;
pub mod process;
pub mod raw;
pub mod reference;
pub mod stalling_proxy;
pub mod waiting;

pub use api::Api;
pub use cluster::{Isolation, Setup, TestCluster};
pub use fleet::Fleet;
pub use postgres::Postgres;
pub use waiting::{until, within};

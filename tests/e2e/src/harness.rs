//! A test cluster: real processes in a temporary folder, and typed calls to them.

pub(crate) mod api;
pub(crate) mod cluster;
pub(crate) mod command;
pub(crate) mod http;
pub(crate) mod process;
pub(crate) mod raw;
pub(crate) mod reference;
pub(crate) mod stalling_proxy;
pub(crate) mod waiting;

pub(crate) use api::Api;
pub(crate) use cluster::{Isolation, Setup, TestCluster};
pub(crate) use waiting::{until, within};

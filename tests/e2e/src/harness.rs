//! A small world for a story: real processes in a temporary folder, and typed calls to them.

pub(crate) mod api;
pub(crate) mod command;
pub(crate) mod http;
pub(crate) mod pace;
pub(crate) mod process;
pub(crate) mod raw;
pub(crate) mod reference;
pub(crate) mod server;
pub(crate) mod wire;

pub(crate) use api::Api;
pub(crate) use pace::{until, within};
pub(crate) use server::{Company, Server, Setup};

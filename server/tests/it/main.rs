//! The server as its clients and workers see it: over real sockets, with a
//! worker played by the tests. `worker.rs` doubles as an example of the
//! protocol between server and workers.

mod captures;
mod fits;
mod harness;
mod ingests;
mod leases;
mod malformed;
mod operations;
mod rollouts;
mod tus;
mod twins;
mod worker;
mod workers;

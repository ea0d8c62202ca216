//! The server as its clients and workers see it: over real sockets, with a fake worker. `worker.rs`
//! is also an example of the protocol between server and workers.

mod access;
mod captures;
mod connections;
mod console;
mod fairness;
mod fits;
mod harness;
mod labels;
mod leases;
mod malformed;
mod operations;
mod outages;
mod readiness;
mod results;
mod samples;
mod simulation;
mod trash;
mod twins;
mod worker;
mod workers;

//! The server as its clients and workers see it: over real sockets, with a fake worker. `worker.rs`
//! is also an example of the protocol between server and workers.

mod access;
mod audit;
mod captures;
mod connections;
mod console;
mod evaluations;
mod fits;
mod harness;
mod ingests;
mod keys;
mod labels;
mod leases;
mod malformed;
mod operations;
mod plans;
mod readiness;
mod registrations;
mod results;
mod rollouts;
mod samples;
mod sessions;
mod sharing;
mod steps;
mod streams;
mod tls;
mod tus;
mod twins;
mod worker;
mod workers;

//! End-to-end tests with real processes, one module for each use of the system, and tests of rules
//! for the whole source tree.

#[cfg(test)]
mod architecture;
#[cfg(test)]
mod broken_captures;
#[cfg(test)]
mod doc_comments;
#[cfg(test)]
mod doctor;
#[cfg(test)]
mod documents;
#[cfg(test)]
mod first_five_minutes;
#[cfg(test)]
mod fits;
#[cfg(test)]
mod fleet;
#[cfg(test)]
mod idioms;
#[cfg(test)]
mod ingests;
#[cfg(test)]
mod labels;
#[cfg(test)]
mod local_access;
#[cfg(test)]
mod looks;
#[cfg(test)]
mod malformed;
#[cfg(test)]
mod memory;
#[cfg(test)]
mod on_postgres;
#[cfg(test)]
mod on_s3;
#[cfg(test)]
mod over_http;
#[cfg(test)]
mod plays;
#[cfg(test)]
mod reasons;
#[cfg(test)]
mod replicas;
#[cfg(test)]
mod resumable;
#[cfg(test)]
mod revocation;
#[cfg(test)]
mod rollouts;
#[cfg(test)]
mod rust_code;
#[cfg(test)]
mod sentences;
#[cfg(test)]
mod sessions;
#[cfg(test)]
mod several_recordings;
#[cfg(test)]
mod stores;
#[cfg(test)]
mod survival;
#[cfg(test)]
mod tidy;
#[cfg(test)]
mod tls_terminator;
#[cfg(test)]
mod traces;
#[cfg(test)]
mod upgrades;
#[cfg(test)]
mod uploads;
#[cfg(test)]
mod workspace;

#[cfg(test)]
use bendtwin_harness as harness;

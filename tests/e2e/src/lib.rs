//! End-to-end tests with real processes, one module for each use of the system, and tests of rules
//! for the whole source tree.

#![cfg(test)]

mod first_five_minutes;
mod fits;
mod labels;
mod looks;
mod malformed;
mod memory;
mod old;
mod operation;
mod over_http;
mod plays;
mod recordings;
mod rollouts;
mod rules;
mod sessions;
mod survival;

use bendtwin_harness as harness;

//! The command line as a whole: shared options and the list of commands.

pub(crate) mod completions;

use clap::{Parser, Subcommand};

use crate::{
    bench, ca, capture, demo, doctor, eval, fit, global::Global, key, logging, rollout, server,
    store, twin, worker,
};

/// Turns recordings of soft objects into physical twins, and predicts what robot actions do to
/// them.
///
/// Start with `bendtwin demo`.
#[derive(Debug, Parser)]
#[command(name = "bendtwin", version, propagate_version = true, arg_required_else_help = true)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(flatten)]
    pub(crate) logging: logging::Options,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Show the whole system at work in seconds: server, fit, comparison, rollouts, picture
    Demo(demo::Demo),
    /// Run the server, with its own workers
    Server(server::Server),
    /// Run a worker process for a server
    Worker(worker::Worker),
    /// Read a capture; workers start this themselves
    #[command(hide = true)]
    IngestCapture(worker::IngestCapture),
    /// Make, check, upload and list captures
    Capture(capture::Capture),
    /// Fit captures: start, watch, list, cancel
    Fit(fit::Fit),
    /// List, show, export, import and delete twins
    Twin(twin::Twin),
    /// Predict the motion of a twin under actions
    Rollout(rollout::Rollout),
    /// Sign in at a server with your organisation's identity provider
    Login(key::login::Login),
    /// Sign out of a server
    Logout,
    /// Show who you are to a server, and what you may do there
    Whoami,
    /// Make, list and revoke the keys of a server
    Key(key::Key),
    /// Issue certificates for servers and workers with a private authority
    Ca(ca::Ca),
    /// Fit and score captures on this machine, without a server
    Eval(eval::Eval),
    /// Time a twin on this machine, as planners use it
    Bench(bench::Bench),
    /// Check, repair and back up the data folder of a server
    Store(store::Store),
    /// Check this machine, the data folder and the server, and report problems
    Doctor(doctor::Doctor),
    /// Print the completion script for a shell
    Completions(completions::Completions),
}

#[cfg(test)]
mod tests;

//! The command line as a whole: shared options and the list of commands.

pub(crate) mod completions;
pub(crate) mod licenses;
pub(crate) mod requirements;

use clap::{Parser, Subcommand};

use crate::{
    access::{admin, console, key, login, project},
    bench, ca, capture, demo, doctor, eval, fit,
    global::Global,
    logging, rollout,
    server::{self, healthcheck},
    store, trash, twin, worker,
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
    Server(Box<server::Server>),
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
    /// List, restore and purge what was deleted
    Trash(trash::Trash),
    /// Rules by which the server deletes by itself: list, make, delete, preview
    Retention(trash::retention::Retention),
    /// Open the console of a server in a browser, logged in
    Console(console::Console),
    /// Sign in at a server with your organisation's identity provider
    Login(login::Login),
    /// Sign out of a server
    Logout,
    /// Show who you are to a server, and what you may do there
    Whoami,
    /// Make, list and revoke the keys of a server
    Key(key::Key),
    /// Make and change projects, whose members share what they have
    Project(project::Project),
    /// Show usage by owner
    Admin(admin::Admin),
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
    /// Ask the server or the worker of this machine whether it is healthy, for the health checks of
    /// containers
    Healthcheck(healthcheck::Healthcheck),
    /// Print the completion script for a shell
    Completions(completions::Completions),
    /// Print the licence of this program, and the notices of the software in it
    Licenses(licenses::Licenses),
}

#[cfg(test)]
mod tests;

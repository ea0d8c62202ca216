//! The arguments that all commands share, and the list of commands.

use bendtwin_client::Client;
use clap::{Args, Parser, Subcommand};

use crate::{bench, capture, demo, eval, fit, logging, rollout, server, suite, twin, worker};

/// Where a server listens unless told otherwise.
pub(crate) const DEFAULT_SERVER: &str = "http://127.0.0.1:7070";

/// Turns recordings of soft objects into physical twins, and predicts what robot actions do to them.
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

/// What every command understands.
#[derive(Clone, Debug, Args)]
pub(crate) struct Global {
    /// Address of the server
    #[arg(long, global = true, env = "BENDTWIN_SERVER", value_name = "URL", default_value = DEFAULT_SERVER)]
    pub(crate) server: String,
    /// Print results as JSON, for scripts
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

impl Global {
    /// Connects to the server.
    pub(crate) async fn connect(&self) -> anyhow::Result<Client> {
        Ok(Client::connect(&self.server).await?)
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// See the whole system at work in a few minutes: server, fit, comparison, rollouts, picture
    Demo(demo::Demo),
    /// Run the server, with its own workers
    Server(server::Server),
    /// Run a worker process for a server
    Worker(worker::Worker),
    /// Read a capture for a worker, which starts this itself
    #[command(hide = true)]
    IngestCapture(worker::IngestCapture),
    /// Make, check, upload and list captures
    Capture(capture::Capture),
    /// Fit captures: start, watch, list, cancel
    Fit(fit::Fit),
    /// List, inspect, export and import twins
    Twin(twin::Twin),
    /// Predict what actions do to a twin
    Rollout(rollout::Rollout),
    /// Fit and score captures here, without a server
    Eval(eval::Eval),
    /// Fit and compare a whole list of captures and configurations, without a server
    Suite(suite::SuiteArgs),
    /// Time the physics on this machine, on named scenes
    Bench(bench::Bench),
}

#[cfg(test)]
mod tests;

//! The command line as a whole: shared options and the list of commands.

use bendtwin_terminal::{global::Global, logging};
use clap::{Parser, Subcommand};

use crate::{bench, boards, corrections, suite};

/// Measures BendTwin, for its developers: accuracy of fits in suites, speed of the physics and of
/// servers, poses of cameras from boards, and what corrections of states bring.
///
/// Users install `bendtwin`; `bendtwin bench` times a twin of theirs.
#[derive(Debug, Parser)]
#[command(name = "bendtwin-lab", version, propagate_version = true, arg_required_else_help = true)]
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
    /// Fit and compare a list of captures and configurations, without a server
    Suite(suite::SuiteArgs),
    /// Time the physics on this machine, on named scenes; a server under load; a database
    Bench(bench::Bench),
    /// Film boards with made cameras and measure errors of the poses that they give
    Boards(boards::Boards),
    /// Compare predictions of a twin from states that are corrected by observed points
    Corrections(corrections::Corrections),
}

#[cfg(test)]
mod tests;

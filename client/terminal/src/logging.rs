//! Logs go to stderr, never to stdout: that is for results.

use std::io::IsTerminal as _;

use bendtwin_telemetry::Exporter;
use clap::{Args, ValueEnum};
use tracing_subscriber::{
    filter::{LevelFilter, Targets},
    fmt,
    prelude::*,
};

/// The environment variables of the options.
const LOG: &str = "BENDTWIN_LOG";
const LOG_FORMAT: &str = "BENDTWIN_LOG_FORMAT";

/// Format of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text for people
    Text,
    /// A JSON document per line
    Json,
}

/// Options of logging.
#[derive(Clone, Debug, Args)]
pub struct Options {
    /// Log filter, for example `warn` or `bendtwin_worker=debug,info` [default: info for server and
    /// worker, else warn]
    #[arg(
        long,
        global = true,
        env = LOG,
        value_name = "FILTER",
        hide_short_help = true
    )]
    log: Option<String>,
    /// Format of the log
    #[arg(
        long,
        global = true,
        env = LOG_FORMAT,
        value_enum,
        default_value = "text",
        hide_short_help = true
    )]
    log_format: Format,
}

impl Options {
    /// Variables of the environment with which a process of this program logs in the same way.
    pub fn environment(&self) -> Vec<(&'static str, String)> {
        let format = match self.log_format {
            Format::Text => "text",
            Format::Json => "json",
        };
        let filter = self.log.clone().map(|filter| (LOG, filter));
        filter.into_iter().chain([(LOG_FORMAT, format.to_owned())]).collect()
    }
}

/// Starts logging: at level info for a process that runs as a service, at level warn for other
/// commands. Panics are logged, too, and `traces` get its spans.
pub fn start(options: &Options, is_service: bool, traces: Option<&Exporter>) {
    let standard = if is_service { LevelFilter::INFO } else { LevelFilter::WARN };
    let filter = filter(options.log.as_deref(), standard);
    let registry = tracing_subscriber::registry().with(filter).with(traces.map(Exporter::layer));
    let started = match options.log_format {
        Format::Text => {
            let ansi = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            let lines = fmt::layer().with_writer(std::io::stderr).with_ansi(ansi);
            registry.with(lines).try_init()
        }
        Format::Json => registry.with(fmt::layer().json().with_writer(std::io::stderr)).try_init(),
    };
    if let Err(error) = started {
        eprintln!("warning: no logs: {error}");
    }
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map(ToString::to_string).unwrap_or_default();
        let message = panic.payload_as_str().unwrap_or("no message");
        tracing::error!(place, "panic: {message}");
    }));
}

/// The filter that was asked for; without one, or with a warning if it cannot be read, a level for all.
fn filter(asked: Option<&str>, standard: LevelFilter) -> Targets {
    let everything = Targets::new().with_default(standard);
    let Some(text) = asked else { return everything };
    text.parse().unwrap_or_else(|error| {
        eprintln!("warning: --log {text}: {error}; taking `{standard}`");
        everything
    })
}

#[cfg(test)]
mod tests;

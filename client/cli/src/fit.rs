//! `bendtwin fit`: start, watch, list, cancel.

mod start;
mod watch;

use bendtwin_client::{CaptureId, FitId};
use clap::{Args, Subcommand};

pub(crate) use self::watch::{ended_well, watch};
use crate::{global::Global, output, quality, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Fit {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Queue a fit of a capture
    Start(start::Start),
    /// Follow a fit until it has ended
    Watch {
        /// fits/{uuid}
        name: FitId,
    },
    /// List fits
    List {
        /// List only fits of this capture
        #[arg(long, value_name = "NAME")]
        capture: Option<CaptureId>,
    },
    /// Show one fit
    Show {
        /// fits/{uuid}
        name: FitId,
    },
    /// Stop fits
    Cancel {
        /// fits/{uuid}
        #[arg(required = true)]
        names: Vec<FitId>,
    },
    /// Delete fits that have ended; their twins stay
    Delete {
        /// fits/{uuid}
        #[arg(required = true)]
        names: Vec<FitId>,
    },
}

pub(crate) async fn run(args: Fit, global: &Global) -> anyhow::Result<()> {
    if let Command::Start(args) = args.command {
        return start::run(args, global).await;
    }
    let client = global.connect().await?;
    match args.command {
        Command::Start(_) => Ok(()),
        Command::Watch { name } => {
            let fit = watch(&client, name, global.json).await?;
            print_ended(&client, &fit, global).await?;
            ended_well(&fit)
        }
        Command::List { capture } => {
            let fits = client.fits().all(capture).await?;
            output::print(global, &fits, || {
                let mut table = Table::new(["NAME", "STATE", "DONE", "STARTED", "RESULT"]);
                for fit in &fits {
                    table.row(columns(fit));
                }
                table.text()
            })
        }
        Command::Show { name } => {
            let fit = client.fits().get(name).await?;
            output::print(global, &fit, || shown(&fit))
        }
        Command::Cancel { names } => {
            let mut fits = Vec::new();
            for name in names {
                fits.push(client.fits().cancel(name).await?);
            }
            output::print(global, &fits, || {
                let lines = fits.iter().map(|f| {
                    if f.job.state.has_ended() {
                        format!("{} has ended ({})\n", f.name, f.job.state.as_str())
                    } else {
                        format!("{} stops\n", f.name)
                    }
                });
                lines.collect()
            })
        }
        Command::Delete { names } => {
            for name in &names {
                client.fits().delete(*name).await?;
            }
            output::print(global, &names, || format!("deleted {}", names.len()))
        }
    }
}

fn columns(fit: &bendtwin_client::Fit) -> [String; 5] {
    let done = fit.job.progress.as_ref().map(|p| format!("{:.0}%", 100.0 * p.fraction));
    let started = fit.job.start_time.map(|t| format!("{t:.0}"));
    let result = match (&fit.twin, &fit.job.fault) {
        (Some(twin), _) => twin.to_string(),
        (None, Some(fault)) => fault.message.clone(),
        (None, None) => String::new(),
    };
    [
        fit.name.to_string(),
        fit.job.state.as_str().to_owned(),
        done.unwrap_or_default(),
        started.unwrap_or_default(),
        result,
    ]
}

/// Prints a fit that has ended; for people with the assessment of its twin.
async fn print_ended(
    client: &bendtwin_client::Client,
    fit: &bendtwin_client::Fit,
    global: &Global,
) -> anyhow::Result<()> {
    let mut text = shown(fit);
    if let Some(name) = fit.twin.filter(|_| !global.json) {
        // The fit has ended well, whatever became of its twin since.
        match quality::of_stored(client, name).await {
            Ok(assessment) => text += &format!("\n{assessment}"),
            Err(error) => text += &format!("\nits twin cannot be assessed: {error}"),
        }
    }
    output::print(global, fit, || text)
}

/// A fit for people.
fn shown(fit: &bendtwin_client::Fit) -> String {
    let mut text = format!(
        "{}\n  capture   {}\n  state     {}\n  attempts  {}",
        fit.name,
        fit.capture,
        fit.job.state.as_str(),
        fit.job.attempts
    );
    if let (Some(progress), false) = (&fit.job.progress, fit.job.state.has_ended()) {
        text += &format!(
            "\n  progress  {:.0}% ({} {}/{})",
            100.0 * progress.fraction,
            progress.stage,
            progress.iteration,
            progress.iterations
        );
    }
    if let (Some(start), Some(end)) = (fit.job.start_time, fit.job.end_time) {
        let took = end.duration_since(start).as_secs_f64();
        text += &format!("\n  took      {}", output::duration(took));
    }
    for fault in &fit.job.attempt_faults {
        text += &format!("\n  earlier   {} ({})", fault.message, fault.reason);
    }
    if let Some(fault) = &fit.job.fault {
        text += &format!("\n  fault     {} ({})", fault.message, fault.reason);
    }
    if let Some(twin) = &fit.twin {
        text += &format!("\n  twin      {twin}\nnext: bendtwin twin show {twin}");
    }
    text
}

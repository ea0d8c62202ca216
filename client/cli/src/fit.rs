//! `bendtwin fit`: start, watch, list, show, compare, edit, cancel.

mod compare;
mod losses;
mod settings;
mod show;
mod start;
mod watch;

use bendtwin_client::{CaptureId, FitId, JobState, ListQuery};
use clap::{Args, Subcommand};

use self::watch::watch_here;
pub(crate) use self::watch::{ended_well, watch};
use crate::{
    global::Global,
    labels::{self, Changes, Choice},
    output,
    quality::{self, identifiability},
    table::Table,
};

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
        /// List only fits in this state: queued, running, succeeded, failed or cancelled
        #[arg(long, value_name = "STATE", value_parser = state)]
        state: Option<JobState>,
        #[command(flatten)]
        choice: Choice,
    },
    /// Show one fit with its settings, its losses and the errors of its twin
    Show {
        /// fits/{uuid}
        name: FitId,
    },
    /// Compare fits: settings that differ, losses and errors
    Compare {
        /// fits/{uuid}, two or more
        #[arg(required = true, num_args = 2..)]
        names: Vec<FitId>,
    },
    /// Change name, note and tags of a fit
    Edit {
        /// fits/{uuid}
        name: FitId,
        #[command(flatten)]
        changes: Changes,
    },
    /// Stop fits
    Cancel {
        /// fits/{uuid}
        #[arg(required = true)]
        names: Vec<FitId>,
    },
    /// Move fits to the trash; their twins stay
    Delete {
        /// fits/{uuid}
        #[arg(required = true)]
        names: Vec<FitId>,
        /// Delete them for good: nothing can restore them
        #[arg(long)]
        purge: bool,
    },
}

pub(crate) async fn run(args: Fit, global: &Global) -> anyhow::Result<()> {
    if let Command::Start(args) = args.command {
        return start::run(args, global).await;
    }
    if let Command::Compare { names } = args.command {
        return compare::run(names, global).await;
    }
    let client = global.connect().await?;
    match args.command {
        Command::Start(_) | Command::Compare { .. } => Ok(()),
        Command::Watch { name } => {
            let fit = watch_here(&client, name, global.json).await?;
            print_ended(&client, &fit, global).await?;
            ended_well(&fit)
        }
        Command::List { capture, state, choice } => {
            let query = ListQuery { capture, state, ..choice.query() };
            let fits = client.fits().all(&query).await?;
            output::print(global, &fits, || {
                let header =
                    ["NAME", "STATE", "DONE", "STARTED", "ERROR", "OWNER", "WHAT", "RESULT"];
                let mut table = Table::new(header);
                for fit in &fits {
                    table.row(columns(fit));
                }
                table.text()
            })
        }
        Command::Show { name } => show::run(name, global).await,
        Command::Edit { name, changes } => {
            let fit = client.fits().update(name, &labels::update(changes)?).await?;
            output::print(global, &fit, || shown(&fit, None))
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
        Command::Delete { names, purge } => {
            for name in &names {
                match purge {
                    true => client.fits().purge(*name).await?,
                    false => client.fits().delete(*name).await?,
                }
            }
            output::print(global, &names, || format!("deleted {}", names.len()))
        }
    }
}

/// A state by its word.
fn state(text: &str) -> Result<JobState, String> {
    use JobState::{Cancelled, Failed, Queued, Running, Succeeded};
    let states = [Queued, Running, Succeeded, Failed, Cancelled];
    let found = states.into_iter().find(|state| state.as_str() == text);
    found.ok_or_else(|| "use queued, running, succeeded, failed or cancelled".to_owned())
}

fn columns(fit: &bendtwin_client::Fit) -> [String; 8] {
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
        labels::millimetres(fit.error_m),
        fit.owner.clone(),
        labels::what(&fit.display_name, &fit.tags),
        result,
    ]
}

/// Prints a fit that has ended; for people with the assessment of its twin.
async fn print_ended(
    client: &bendtwin_client::Client,
    fit: &bendtwin_client::Fit,
    global: &Global,
) -> anyhow::Result<()> {
    let mut text = shown(fit, None);
    if let Some(name) = fit.twin.filter(|_| !global.json) {
        text += &format!("\nnext: bendtwin twin show {name}");
        // The fit has ended well, even if its twin has been deleted since.
        match quality::of_stored(client, name).await {
            Ok(assessment) => text += &format!("\n{assessment}"),
            Err(error) => text += &format!("\nits twin cannot be assessed: {error}"),
        }
        if let Ok(twin) = client.twins().get(name).await
            && let Some(sentences) = identifiability::sentences(&twin.quality)
        {
            text += &format!("\n{sentences}");
        }
    }
    output::print(global, fit, || text)
}

/// Requirements in words; none if any worker will do.
fn wanted(requirements: &bendtwin_client::Requirements) -> Option<String> {
    let bendtwin_client::Requirements { backend, memory_bytes, labels } = requirements;
    let mut words = labels.clone();
    if *memory_bytes > 0 {
        words.insert(0, format!("{} MiB", memory_bytes >> 20));
    }
    if !backend.is_empty() {
        words.insert(0, backend.clone());
    }
    (!words.is_empty()).then(|| words.join(", "))
}

/// A fit for people, with the name of its capture if that is known.
fn shown(fit: &bendtwin_client::Fit, capture: Option<&str>) -> String {
    let mut text = format!(
        "{}\n  what      {}{}\n  capture   {}{}\n  state     {}\n  attempts  {}",
        fit.name,
        fit.display_name,
        labels::lines(&fit.note, &fit.tags, 10),
        fit.capture,
        capture.map(|name| format!(" ({name})")).unwrap_or_default(),
        fit.job.state.as_str(),
        fit.job.attempts
    );
    if let Some(wanted) = wanted(&fit.requirements) {
        text += &format!("\n  worker    {wanted}");
    }
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
        text += &format!("\n  twin      {twin}");
    }
    text
}

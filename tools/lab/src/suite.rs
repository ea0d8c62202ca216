//! `bendtwin-lab suite`: fits every capture of a list under every configuration, and compares.

mod devices;
mod progress;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use bendtwin_core::{CancelToken, Category, Fault};
use bendtwin_study::{
    Devices, Folder, Invocation, Plan, PlanOptions, Selection, Suite, Summary, Table, draw_figure,
    draw_pictures,
};
use bendtwin_terminal::{
    backend::BackendArgs,
    failure::{self, Failed},
    global::Global,
    observation, output, signals,
};
use clap::{Args, builder::RangedU64ValueParser};

use self::progress::{SuiteProgress, run_count};

#[derive(Debug, Args)]
#[command(after_help = "\
A run whose result is in the folder is not repeated, unless its capture, its settings or this program changed; a fit that
was interrupted resumes from its checkpoint. Ctrl-C keeps finished runs. docs/develop/suites.md describes the file and the table.")]
pub(crate) struct SuiteArgs {
    /// The suite, a JSON file
    suite: PathBuf,
    /// Folder for results: table.md, table.json, figure.png, runs/, twins/, pictures/
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Folder of the captures, found by their paths in the suite or by their file names [default:
    /// the suite's folder]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Run only these; `*` and omitted trailing parts match all; may be repeated
    #[arg(long, value_name = "CAPTURE/CONFIGURATION/SEED")]
    only: Vec<Selection>,
    /// Number of runs side by side. On the CPU they share the cores [default: number of cores]. On
    /// a GPU each has its own queues and share of memory, as far as there is room [default: 4]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=256))]
    jobs: Option<usize>,
    #[command(flatten)]
    backend: BackendArgs,
    /// Also keep results of other builds
    #[arg(long)]
    any_build: bool,
    /// Run nothing; write the table and the pictures of the existing results
    #[arg(long)]
    table_only: bool,
    /// Draw no pictures
    #[arg(long)]
    no_pictures: bool,
    /// Shortest time between two checkpoints of a fit [s]
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(0..=86_400))]
    checkpoint_every: u64,
}

pub(crate) async fn run(args: SuiteArgs, global: &Global) -> anyhow::Result<()> {
    let cancel = signals::cancellation();
    let (args, quiet) = (Arc::new(args), global.json);
    let working = Arc::clone(&args);
    let (table, failed, left) =
        tokio::task::spawn_blocking(move || work(&working, &cancel, quiet)).await??;
    output::print(global, &table, || table.to_markdown())?;
    verdict(failed, left, &args)
}

/// Executes the pending runs. Returns the table of all results, and the numbers of failed and
/// unfinished runs.
fn work(
    args: &SuiteArgs,
    cancel: &CancelToken,
    quiet: bool,
) -> anyhow::Result<(Table, usize, usize)> {
    let suite = Suite::read(&args.suite).map_err(failure::failed)?;
    let folder = Folder::open(&args.out).map_err(failure::failed)?;
    let options = PlanOptions {
        data: args.data.clone(),
        only: args.only.clone(),
        build: build(),
        any_build: args.any_build,
        checkpoint_every: Duration::from_secs(args.checkpoint_every),
    };
    let read = |path: &Path| observation::read(path, cancel, quiet);
    let mut plan = Plan::new(&suite, &folder, options, &read).map_err(failure::failed)?;
    let work = if args.table_only { 0 } else { plan.pending() };
    let backends = devices::open(&args.backend, args.jobs, work)?;
    let result = if args.table_only {
        Ok(Summary::default())
    } else {
        let mut bar = SuiteProgress::new(&plan, &backends, quiet);
        let rasteriser = args.backend.rasteriser();
        let devices = Devices { backends: backends.clone(), rasteriser };
        let result = plan.run(&devices, cancel, &mut |event| bar.show(&event));
        bar.finish();
        result
    };
    // Results from before a failure are reported, too.
    let invocation =
        Invocation { suite: args.suite.clone(), data: args.data.clone(), out: args.out.clone() };
    let table = Table::new(&plan, &invocation);
    let json = table.to_json().map_err(failure::failed)?;
    folder.write("table.json", json.as_bytes()).map_err(failure::failed)?;
    folder.write("table.md", table.to_markdown().as_bytes()).map_err(failure::failed)?;
    let left = result.map_err(failure::failed)?.left;
    if let (Some(gains), false) = (&table.gains, args.no_pictures) {
        let png = draw_figure(gains).map_err(failure::failed)?;
        folder.write("figure.png", &png).map_err(failure::failed)?;
    }
    if let (Some(backend), false) = (backends.first(), args.no_pictures) {
        let complaints = draw_pictures(&plan, &**backend, cancel).map_err(failure::failed)?;
        complaints.iter().for_each(|complaint| eprintln!("warning: {complaint}"));
    }
    Ok((table, plan.failed(), left))
}

/// Version and content of this program: results hold as long as it does not change.
fn build() -> String {
    let digest = || {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(std::fs::File::open(std::env::current_exe()?)?)?;
        std::io::Result::Ok(hasher.finalize().to_hex())
    };
    match digest() {
        Ok(digest) => format!("{} ({})", bendtwin_core::BUILD, &digest[..12]),
        Err(_) => bendtwin_core::BUILD.to_owned(),
    }
}

fn verdict(failed: usize, left: usize, args: &SuiteArgs) -> anyhow::Result<()> {
    let failed_with = |category, reason: &str, message| {
        Err(Failed(Fault { category, reason: reason.to_owned(), message }).into())
    };
    match (failed, left) {
        (0, 0) => Ok(()),
        (0, _) => {
            let message = format!("{} left: repeat the command to continue", run_count(left));
            failed_with(Category::Cancelled, "CANCELLED", message)
        }
        _ => {
            let place = args.out.join("table.md").display().to_string();
            failed_with(
                Category::Aborted,
                "RUNS_FAILED",
                format!("{} failed: see {place} for the reasons", run_count(failed)),
            )
        }
    }
}

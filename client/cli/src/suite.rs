//! `bendtwin suite`: fits every capture of a list under every configuration, and compares.

mod board;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use bendtwin_core::{Category, Fault};
use bendtwin_engine::backend::CancelToken;
use bendtwin_study::{
    Folder, Invocation, Plan, PlanOptions, Selection, Suite, Summary, Table, draw_pictures,
};
use clap::{Args, builder::RangedU64ValueParser};

use self::board::{Board, counted};
use crate::{
    args::Global,
    backend::BackendArgs,
    failure::{self, Failed},
    observation, output, signals,
};

#[derive(Debug, Args)]
#[command(after_help = "\
A run whose result is in the folder is not repeated, unless its capture, its settings or this program changed; a fit that
was interrupted goes on from its checkpoint. Ctrl-C keeps what is finished. docs/accuracy.md describes the file and the table.")]
pub(crate) struct SuiteArgs {
    /// The suite, a JSON file
    suite: PathBuf,
    /// The folder for results: table.md, table.json, runs/, twins/, pictures/
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Where captures lie, by their paths in the suite or by their file names alone [default: beside the suite]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Only these runs; `*` and what is left out at the end stand for all; may be repeated
    #[arg(long, value_name = "CAPTURE/CONFIGURATION/SEED")]
    only: Vec<Selection>,
    /// Runs side by side. On the CPU they share the cores [default: as many as there are cores]; on a GPU each has queues
    /// and a share of the memory of its own, and they run at once as far as the device has room [default: 4]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=256))]
    jobs: Option<usize>,
    #[command(flatten)]
    backend: BackendArgs,
    /// Keep results of other builds too
    #[arg(long)]
    any_build: bool,
    /// Run nothing: write the table and the pictures of what there is
    #[arg(long)]
    table_only: bool,
    /// Draw no pictures
    #[arg(long)]
    no_pictures: bool,
    /// Least time between two checkpoints of a fit [s]
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(0..=86_400))]
    checkpoint_every: u64,
}

pub(crate) async fn run(args: SuiteArgs, global: &Global) -> anyhow::Result<()> {
    let cancel = CancelToken::default();
    let (shutdown, token) = (signals::shutdown(), cancel.clone());
    tokio::spawn(async move {
        shutdown.cancelled().await;
        token.cancel();
    });
    let (args, quiet) = (Arc::new(args), global.json);
    let working = Arc::clone(&args);
    let (table, failed, left) =
        tokio::task::spawn_blocking(move || work(&working, &cancel, quiet)).await??;
    output::print(global, &table, || table.to_markdown())?;
    verdict(failed, left, &args)
}

/// Runs what is to be done; returns the table of all there is, and how many runs failed and are left.
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
    let backends = args.backend.open_several(args.jobs, work)?;
    let result = if args.table_only {
        Ok(Summary::default())
    } else {
        let mut board = Board::new(&plan, &backends, quiet);
        let result = plan.run(&backends, cancel, &mut |event| board.show(&event));
        board.finish();
        result
    };
    // What was found before a failure is told too.
    let invocation =
        Invocation { suite: args.suite.clone(), data: args.data.clone(), out: args.out.clone() };
    let table = Table::new(&plan, &invocation);
    let json = table.to_json().map_err(failure::failed)?;
    folder.write("table.json", json.as_bytes()).map_err(failure::failed)?;
    folder.write("table.md", table.to_markdown().as_bytes()).map_err(failure::failed)?;
    let left = result.map_err(failure::failed)?.left;
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
        Ok(digest) => format!("{} ({})", bendtwin_fit::BUILD, &digest[..12]),
        Err(_) => bendtwin_fit::BUILD.to_owned(),
    }
}

fn verdict(failed: usize, left: usize, args: &SuiteArgs) -> anyhow::Result<()> {
    let told = |category, reason: &str, message| {
        Err(Failed(Fault { category, reason: reason.to_owned(), message }).into())
    };
    match (failed, left) {
        (0, 0) => Ok(()),
        (0, _) => {
            let message =
                format!("not all is done, {} left: the same command goes on", counted(left));
            told(Category::Cancelled, "CANCELLED", message)
        }
        _ => {
            let place = args.out.join("table.md").display().to_string();
            told(
                Category::Aborted,
                "RUNS_FAILED",
                format!("{} failed: {place} says why", counted(failed)),
            )
        }
    }
}

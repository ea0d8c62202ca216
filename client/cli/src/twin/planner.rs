//! `bendtwin twin planner`: a small twin beside a twin, with which plans are made.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bendtwin_core::{
    CancelToken, Twin,
    settings::{
        MOST_PLANNER_NODES, MOST_PLANNER_SUBSTEPS,
        defaults::{PLANNER_NODES, PLANNER_SUBSTEPS},
    },
};
use bendtwin_fit::{Budget, Choice, Distillation};
use clap::Args;
use serde_json::json;

use super::source::Source;
use crate::{
    backend::BackendArgs,
    failure::{self, Failed, Usage},
    global::Global,
    observation, output, quality, signals,
};

#[derive(Debug, Args)]
pub(super) struct Planner {
    /// twins/{uuid}, beside which a new twin with a planner's twin is stored, or a twin file on
    /// this machine, which needs no server
    twin: Source,
    /// The twin file to write [required for a twin file]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Capture that the twin was fitted to: actions are then as fast as its hands, instead of a
    /// quarter of a metre a second
    #[arg(long, value_name = "PATH")]
    capture: Option<PathBuf>,
    /// Number of nodes
    #[arg(long, value_name = "N", default_value_t = PLANNER_NODES, conflicts_with = "budget",
          value_parser = clap::value_parser!(u32).range(4..=i64::from(MOST_PLANNER_NODES)))]
    nodes: u32,
    /// Largest number of substeps per frame
    #[arg(long, value_name = "N", default_value_t = PLANNER_SUBSTEPS, conflicts_with = "budget",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PLANNER_SUBSTEPS)))]
    substeps: u32,
    /// Choose nodes and substeps for plans of SAMPLESxFRAMES@PLANS a second on this machine,
    /// for example 48x15@10
    #[arg(long, value_name = "BUDGET")]
    budget: Option<Budget>,
    /// Seed of the sampled actions
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    backend: BackendArgs,
}

pub(super) async fn run(args: Planner, global: &Global) -> anyhow::Result<()> {
    if args.out.is_none() && matches!(args.twin, Source::File(_)) {
        return Err(Usage::error("name the twin file to write with --out"));
    }
    let (name, content) = args.twin.read(global).await?;
    let cancel = signals::cancellation();
    let (out, quiet) = (args.out.clone(), global.json);
    let (twin, choice) =
        tokio::task::spawn_blocking(move || make(&args, &content, &cancel, quiet)).await??;
    let file = twin.encode().map_err(failure::failed)?;
    let written = match &out {
        Some(path) => {
            write(path, &file)?;
            path.display().to_string()
        }
        None => global.connect().await?.twins().import(file, &name).await?.name.to_string(),
    };
    let chosen = choice.map(|c| {
        json!({ "nodes": c.nodes, "substeps": c.substeps, "measured_s": c.measured_s, "fits": c.fits })
    });
    let document = json!({ "twin": written, "planner": twin.quality.planner, "budget": chosen });
    output::print(global, &document, || {
        let line = quality::planner(&twin.quality).unwrap_or_default();
        let budget = choice.map_or_else(String::new, |choice| format!("\n{}", described(&choice)));
        format!("{written}\n{line}{budget}")
    })
}

fn write(path: &Path, file: &[u8]) -> anyhow::Result<()> {
    std::fs::write(path, file).with_context(|| format!("cannot write {}", path.display()))
}

/// The twin with its planner's twin, and the size that the budget selected.
fn make(
    args: &Planner,
    content: &[u8],
    cancel: &CancelToken,
    quiet: bool,
) -> anyhow::Result<(Twin, Option<Choice>)> {
    let twin = Twin::decode(content).map_err(failure::failed)?;
    let backend = args.backend.open()?;
    let captured = args.capture.as_deref().map(|path| observation::read(path, cancel, quiet));
    let captured = captured.transpose().map_err(Failed)?;
    let choice = args.budget.map(|budget| budget.choose(&twin, &*backend, cancel));
    let choice = choice.transpose().map_err(failure::failed)?;
    let (nodes, substeps) =
        choice.map_or((args.nodes as usize, args.substeps), |c| (c.nodes, c.substeps));
    let wanted = Distillation { nodes, substeps, seed: args.seed };
    let capture = captured.as_ref().map(|(capture, _)| capture);
    let twin = wanted.of(&twin, capture, &backend, cancel).map_err(failure::failed)?;
    Ok((twin, choice))
}

/// A choice in a line.
fn described(choice: &Choice) -> String {
    let ms = 1e3 * choice.measured_s;
    match choice.fits {
        true => format!("The rollouts of a plan took {ms:.1} ms here."),
        false => format!(
            "The rollouts of a plan took {ms:.1} ms here, which is more than the budget allows: no smaller planner's twin is made."
        ),
    }
}

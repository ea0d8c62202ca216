//! `bendtwin-lab bench`: speed of the physics on this machine, on named scenes; what load on a server
//! leaves to others; and speed of a database.

mod load;
mod memory;
mod store;
mod tables;

use std::{path::PathBuf, sync::Arc, time::Duration};

use bendtwin_bench::{FitPlan, Plan, Report, SceneName, Scheme, Setup};
use bendtwin_core::CancelToken;
use bendtwin_engine::Backend;
use bendtwin_terminal::{
    backend::BackendArgs, failure, global::Global, measurement::seconds, output, signals,
};
use clap::{Args, Subcommand, ValueEnum, builder::RangedU64ValueParser};

/// Most instances of a batch, more than planners use.
const MOST_INSTANCES: u64 = 16_384;

#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
The defaults are for a data centre's GPU. On a laptop, choose scenes and sizes:
  cargo lab bench n500 --batches 1,16 --quick
A whole fit takes minutes on a GPU and hours on a CPU; it is measured only on request:
  cargo lab bench n2000 --bending without --fit frame,pass,cut"
)]
pub(crate) struct Bench {
    #[command(subcommand)]
    command: Option<Command>,
    /// Scenes [default: all; with --quick: rope and n500]
    scenes: Vec<SceneName>,
    /// List the scenes and exit
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    backend: BackendArgs,
    /// Scenes without bending triplets, with them, or both
    #[arg(long, value_enum, default_value_t = Bending::Both)]
    bending: Bending,
    /// Numbers of instances of the rollout batches
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "1,100,132,1000",
          value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_INSTANCES))]
    batches: Vec<usize>,
    /// Numbers of windows of the gradient batches, each window one frame long [default: that of
    /// --batches]
    #[arg(long, value_name = "N,...", value_delimiter = ',',
          value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_INSTANCES))]
    windows: Vec<usize>,
    /// Most frames of a rollout; a slow device gets fewer
    #[arg(long, value_name = "FRAMES", default_value_t = 30, value_parser = RangedU64ValueParser::<usize>::new().range(1..=300))]
    horizon: usize,
    /// Time for the repeats of one measurement [s] [default: 1; with --quick: 0.1]
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    /// Skip measurements whose single call would take longer than this [s] [default: 20; with
    /// --quick: 2]
    #[arg(long, value_name = "S", value_parser = seconds)]
    patience: Option<f64>,
    /// Also time whole fits: `frame` steps once a frame, as PhysTwin does, `pass` once a pass,
    /// `cut` once a pass with gradients that end at each frame's start
    #[arg(long, value_name = "SCHEME,...", value_enum, value_delimiter = ',')]
    fit: Vec<FitScheme>,
    /// Generations of a fit, of 11 candidates each [default: 20; with --quick: 2]
    #[arg(long, requires = "fit", value_parser = clap::value_parser!(u32).range(0..=10_000))]
    generations: Option<u32>,
    /// Passes of a fit [default: 200; with --quick: 2]
    #[arg(long, requires = "fit", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    passes: Option<u32>,
    /// Frames of a fit's capture [default: 100; with --quick: 4]
    #[arg(long, requires = "fit", value_parser = RangedU64ValueParser::<usize>::new().range(2..=10_000))]
    frames: Option<usize>,
    /// Measure only briefly, as a test that it works
    #[arg(long)]
    quick: bool,
    /// Also write the report as JSON to this file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Time small rollouts and a fit on a running server, alone and beside greedy clients
    Load(load::Load),
    /// Time the queue and the list of captures of a database
    Store(store::Store),
}

/// Choice between scenes without bending triplets and with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Bending {
    Without,
    With,
    Both,
}

/// [`Scheme`] as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FitScheme {
    Frame,
    Pass,
    Cut,
}

impl Bench {
    fn plan(&self) -> Plan {
        let usual =
            if self.quick { &[SceneName::Rope, SceneName::N500][..] } else { &SceneName::ALL[..] };
        let names = if self.scenes.is_empty() { usual } else { &self.scenes };
        let variants: &[bool] = match self.bending {
            Bending::Without => &[false],
            Bending::With => &[true],
            Bending::Both => &[false, true],
        };
        let pick = |quick: f64, usual: f64| if self.quick { quick } else { usual };
        let duration = |given: Option<f64>, quick, usual| {
            Duration::from_secs_f64(given.unwrap_or_else(|| pick(quick, usual)))
        };
        Plan {
            scenes: names.iter().flat_map(|&n| variants.iter().map(move |&b| (n, b))).collect(),
            batches: self.batches.clone(),
            windows: if self.windows.is_empty() { &self.batches } else { &self.windows }.clone(),
            horizon: self.horizon,
            measurement: duration(self.seconds, 0.1, 1.0),
            patience: duration(self.patience, 2.0, 20.0),
            fits: self.fit.iter().map(|scheme| self.fit_plan(*scheme)).collect(),
        }
    }

    fn fit_plan(&self, scheme: FitScheme) -> FitPlan {
        let scheme = match scheme {
            FitScheme::Frame => Scheme::Frame,
            FitScheme::Pass => Scheme::Pass,
            FitScheme::Cut => Scheme::Cut,
        };
        let mut plan = FitPlan::phystwin(scheme);
        if self.quick {
            plan = FitPlan { frames: 4, generations: 2, passes: 2, ..plan };
        }
        FitPlan {
            frames: self.frames.unwrap_or(plan.frames),
            generations: self.generations.unwrap_or(plan.generations),
            passes: self.passes.unwrap_or(plan.passes),
            ..plan
        }
    }
}

pub(crate) async fn run(args: Bench, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Some(Command::Load(load)) => return load::run(load, global).await,
        Some(Command::Store(store)) => return store::run(store, global).await,
        None => {}
    }
    if args.list {
        let names = SceneName::ALL.map(|name| {
            serde_json::json!({
                "name": name.as_str(), "nodes": name.node_count(), "controls": name.control_count(),
            })
        });
        return output::print(global, &names, tables::names);
    }
    let cancel = signals::cancellation();
    let (plan, opening, quiet) = (args.plan(), args.backend.clone(), global.json);
    let (report, result) = tokio::task::spawn_blocking(move || {
        let backend = opening.open()?;
        anyhow::Ok(measure(&plan, &backend, &cancel, quiet))
    })
    .await??;
    // Measurements from before a failure are reported, too.
    output::write(args.out.as_deref(), &report)?;
    output::print(global, &report, || tables::report(&report))?;
    result.map_err(failure::failed)
}

/// Runs the measurements. Returns the report so far together with the error that ended them, if
/// any.
fn measure(
    plan: &Plan,
    backend: &Arc<dyn Backend>,
    cancel: &CancelToken,
    quiet: bool,
) -> (Report, Result<(), bendtwin_bench::Error>) {
    let mut report = Report::new(plan, &**backend);
    let memory = memory::probe(backend);
    let setup = Setup { backend: Arc::clone(backend), memory: &*memory, cancel };
    let mut say = |what: &str| {
        if !quiet {
            eprintln!("  {what}");
        }
    };
    let result = bendtwin_bench::run(plan, &setup, &mut report, &mut say);
    (report, result)
}

#[cfg(test)]
mod tests;

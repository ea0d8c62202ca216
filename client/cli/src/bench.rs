//! `bendtwin bench`: times a twin on this machine, so that a planner's machine can be chosen. Speed of
//! the physics on named scenes and of servers under load is measured by `bendtwin-lab bench`.

mod own;

use std::{path::PathBuf, time::Duration};

use bendtwin_terminal::measurement::{Size, seconds};
use clap::Args;

use crate::{backend::BackendArgs, global::Global, output, signals};

#[derive(Debug, Args)]
#[command(after_help = "\
A planner's batches, and a closed loop's:
  bendtwin bench --twin twin.safetensors
  bendtwin bench --twin twin.safetensors --sizes 1x1,48x15 --backend cpu")]
pub(crate) struct Bench {
    /// The twin file: its costs and gradients are timed, of the exact twin, of its fast variant and of
    /// its planner's twin
    #[arg(long, value_name = "FILE")]
    twin: PathBuf,
    /// Sizes of the batches: instances x frames
    #[arg(
        long,
        value_name = "BxF,...",
        value_delimiter = ',',
        default_value = "1x1,8x5,128x20,1000x30"
    )]
    sizes: Vec<Size>,
    #[command(flatten)]
    backend: BackendArgs,
    /// Time for the repeats of one measurement [s] [default: 1; with --quick: 0.1]
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    /// Skip measurements whose single call would take longer than this [s] [default: 20; with
    /// --quick: 2]
    #[arg(long, value_name = "S", value_parser = seconds)]
    patience: Option<f64>,
    /// Measure only briefly, as a test that it works
    #[arg(long)]
    quick: bool,
    /// Also write the report as JSON to this file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Bench {
    fn plan(&self) -> own::Plan {
        let [measurement, patience] = if self.quick { [0.1, 2.0] } else { [1.0, 20.0] };
        own::Plan {
            sizes: self.sizes.clone(),
            measurement: Duration::from_secs_f64(self.seconds.unwrap_or(measurement)),
            patience: Duration::from_secs_f64(self.patience.unwrap_or(patience)),
        }
    }
}

pub(crate) async fn run(args: Bench, global: &Global) -> anyhow::Result<()> {
    let cancel = signals::cancellation();
    let (plan, out, quiet) = (args.plan(), args.out.clone(), global.json);
    let report = tokio::task::spawn_blocking(move || {
        let backend = args.backend.open()?;
        let say = |what: &str| {
            if !quiet {
                eprintln!("  {what}");
            }
        };
        own::measure(&args.twin, &plan, &*backend, &cancel, say)
    })
    .await??;
    output::write(out.as_deref(), &report)?;
    output::print(global, &report, || own::text(&report))
}

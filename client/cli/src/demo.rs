//! `bendtwin demo`: the whole system at work, with the command for each step.

mod candidates;
mod closed_loop;
mod object;
mod playground;
mod server;
mod steps;
mod verdict;

use std::{
    path::PathBuf,
    sync::atomic::{AtomicBool, Ordering},
};

use clap::Args;
use tempfile::TempDir;

use self::{object::Object, steps::DemoRun};
use crate::{backend::BackendArgs, global::Global, signals};

#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// Keep the server's folder, the capture and the twins in this folder
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Picture to write
    #[arg(long, value_name = "FILE", default_value = "bendtwin-demo.png")]
    out: PathBuf,
    /// Show a closed loop instead, in less than half a minute: plan with a twin, move a rope that
    /// differs from it, and plan again from the state of the rope
    #[arg(long)]
    plan: bool,
    /// Fit a rope, open a browser in which it can be dragged, and stay until Ctrl-C
    #[arg(long, conflicts_with_all = ["plan", "out"])]
    open: bool,
    /// Seed of the capture, of the fits and of the plans
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    backend: BackendArgs,
}

pub(crate) async fn run(args: Demo, global: &Global) -> anyhow::Result<()> {
    let shutdown = signals::shutdown();
    let folder = Folder::new(args.keep)?;
    let object = if args.open || args.plan { Object::Rope } else { Object::Cable };
    let mut demo = DemoRun::new(global.json, args.seed, object, args.out, folder.path().to_owned());
    let mut server = demo.start_server(&args.backend).await?;
    let connection = server.connection.clone();
    let is_open = AtomicBool::new(false);
    let steps = async {
        match (args.open, args.plan) {
            (true, _) => {
                demo.open_playground(&connection).await?;
                is_open.store(true, Ordering::SeqCst);
                std::future::pending().await
            }
            (false, true) => demo.run_closed_loop(&connection).await,
            (false, false) => demo.run(&connection).await,
        }
    };
    let outcome = tokio::select! {
        // Ctrl-C also reaches the server: its end is no fault then.
        biased;
        () = shutdown.cancelled() => match is_open.load(Ordering::SeqCst) {
            true => Ok(()),
            false => Err(anyhow::anyhow!("interrupted; everything was stopped")),
        },
        outcome = steps => outcome,
        fault = server.ended() => Err(fault),
    };
    // An orderly end in every case: no process and no half-written folder stays behind.
    server.stop().await;
    outcome?;
    demo.conclude(folder.is_kept())
}

/// The demo's folder, removed afterwards unless the user keeps it.
enum Folder {
    Temporary(TempDir),
    Kept(PathBuf),
}

impl Folder {
    fn new(keep: Option<PathBuf>) -> anyhow::Result<Self> {
        match keep {
            Some(path) => {
                std::fs::create_dir_all(&path)?;
                // Child processes may have another idea of what a relative path means.
                Ok(Self::Kept(std::path::absolute(path)?))
            }
            None => {
                Ok(Self::Temporary(tempfile::Builder::new().prefix("bendtwin-demo-").tempdir()?))
            }
        }
    }

    fn path(&self) -> &std::path::Path {
        match self {
            Self::Temporary(folder) => folder.path(),
            Self::Kept(path) => path,
        }
    }

    fn is_kept(&self) -> bool {
        matches!(self, Self::Kept(_))
    }
}

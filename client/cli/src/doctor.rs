//! `bendtwin doctor`: what this machine, the data folder and the server have, and what is amiss.
//! It changes nothing, and works with or without a server.

mod certificate;
mod check;
mod folder;
mod machine;
mod network;

use std::path::PathBuf;

use bendtwin_core::{Category, Fault};
use bendtwin_server::Options;
use clap::Args;

use self::check::{Check, State};
use crate::{failure::Failed, global::Global, output, server::Server};

/// Options of the diagnosis: those of the server on this machine, from the same variables and the same file.
#[derive(Debug, Args)]
pub(crate) struct Doctor {
    /// Certificate of a worker on this machine
    #[arg(long, env = "BENDTWIN_WORKER_CERTIFICATE", value_name = "FILE")]
    worker_certificate: Option<PathBuf>,
    #[command(flatten)]
    server: Box<Server>,
}

pub(crate) async fn run(args: Doctor, global: &Global) -> anyhow::Result<()> {
    let mut checks = tokio::task::spawn_blocking(machine::checks).await?;
    let options = match args.server.options() {
        Ok(options) => options,
        Err(error) => {
            checks.push(Check::problem("options", format!("{error:#}")));
            args.server.put_place(Options::default())
        }
    };
    checks.push(folder::check(&options.data_dir, options.disk_floor_mib).await);
    checks.push(network::address(options.listen).await);
    let further: Vec<_> = args.worker_certificate.iter().chain(&global.ca).collect();
    checks.extend(certificate::checks(&options, &further));
    checks.extend(network::server(global, &options).await);
    output::print(global, &checks, || text(&checks))?;
    let problems = checks.iter().filter(|check| check.state == State::Problem).count();
    if problems == 0 {
        return Ok(());
    }
    let named = if problems == 1 { "problem, named above" } else { "problems, named above" };
    let fault = Fault {
        category: Category::FailedPrecondition,
        reason: "NOT_HEALTHY".to_owned(),
        message: format!("{problems} {named}"),
    };
    Err(Failed(fault).into())
}

fn text(checks: &[Check]) -> String {
    let width = checks.iter().map(|check| check.name.len()).max().unwrap_or_default();
    let line =
        |check: &Check| format!("{:<7}  {:<width$}  {}", check.state, check.name, check.message);
    checks.iter().map(line).collect::<Vec<_>>().join("\n")
}

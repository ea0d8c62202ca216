//! `bendtwin doctor`: what this machine, the data folder and the server have, and what is amiss.
//! It changes nothing, and works with or without a server.

mod check;
mod folder;
mod machine;
mod network;

use std::{net::SocketAddr, path::PathBuf};

use bendtwin_core::{Category, Fault};
use bendtwin_server::Options;
use clap::Args;

use self::check::{Check, State};
use crate::{failure::Failed, global::Global, output};

#[derive(Debug, Args)]
pub(crate) struct Doctor {
    /// Data folder of the server [default: bendtwin-data]
    #[arg(long, env = "BENDTWIN_DATA_DIR", value_name = "DIR")]
    data_dir: Option<PathBuf>,
    /// Address on which the server listens, or will listen [default: 127.0.0.1:7070]
    #[arg(long, env = "BENDTWIN_LISTEN", value_name = "ADDRESS")]
    listen: Option<SocketAddr>,
}

pub(crate) async fn run(args: Doctor, global: &Global) -> anyhow::Result<()> {
    let defaults = Options::default();
    let folder = args.data_dir.unwrap_or(defaults.data_dir);
    let mut checks = tokio::task::spawn_blocking(machine::checks).await?;
    checks.push(folder::check(&folder, defaults.disk_floor_mib).await);
    checks.push(network::address(args.listen.unwrap_or(defaults.listen)).await);
    checks.extend(network::server(global).await);
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

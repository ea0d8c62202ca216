//! `bendtwin admin`: what operators ask a server, with a key of the scope `admin` or the client token.

use std::cmp::Reverse;

use bendtwin_client::OwnerUsage;
use clap::{Args, Subcommand};

use crate::{global::Global, output, table::Table};

#[derive(Debug, Args)]
pub(crate) struct Admin {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show what is stored for each owner and what its jobs are, those with most bytes first
    Usage,
}

pub(crate) async fn run(args: Admin, global: &Global) -> anyhow::Result<()> {
    match args.command {
        Command::Usage => usage(global).await,
    }
}

async fn usage(global: &Global) -> anyhow::Result<()> {
    let mut owners = global.connect().await?.usage().all().await?;
    owners.sort_by_key(|owner| Reverse(owner.stored_bytes.total));
    output::print(global, &owners, || table(&owners).text())
}

fn table(owners: &[OwnerUsage]) -> Table {
    let mut table = Table::new([
        "OWNER",
        "STORED",
        "OF",
        "CAPTURES",
        "DERIVED",
        "TWINS",
        "CHECKPOINTS",
        "UPLOADS",
        "QUEUED",
        "RUNNING",
        "FITS",
    ]);
    let counted = |count: u64, bytes: u64| format!("{count}: {}", output::bytes(bytes));
    for owner in owners {
        let stored = &owner.stored_bytes;
        let bound = |bound: Option<u64>, count: u64| match bound {
            Some(bound) => format!("{count} of {bound}"),
            None => count.to_string(),
        };
        table.row([
            if owner.owner.is_empty() { "-".to_owned() } else { owner.owner.clone() },
            output::bytes(stored.total),
            owner.quotas.stored_bytes.map_or_else(|| "-".to_owned(), output::bytes),
            counted(owner.captures, stored.captures),
            output::bytes(stored.derived),
            counted(owner.twins, stored.twins),
            output::bytes(stored.checkpoints),
            output::bytes(stored.uploads),
            bound(owner.quotas.queued_jobs, owner.queued_jobs),
            owner.running_jobs.to_string(),
            owner.fits.to_string(),
        ]);
    }
    table
}

//! `bendtwin-lab bench store`: the queue and the list of captures, in SQLite or in PostgreSQL.

use std::{path::PathBuf, time::Duration};

use bendtwin_store::{
    DatabaseUrl,
    bench::{self, PageTime, QueueSpeed},
};
use bendtwin_terminal::{failure, global::Global, output, table::Table};
use clap::Args;
use serde::Serialize;

#[derive(Debug, Args)]
pub(super) struct Store {
    /// A new folder for the store, on the disk to be measured; it is not removed
    folder: PathBuf,
    /// An empty PostgreSQL database instead of SQLite in that folder; it is filled
    #[arg(long, env = "BENDTWIN_DATABASE_URL", value_name = "URL", hide_env_values = true)]
    database: Option<String>,
    /// Clients that claim and complete jobs
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=256))]
    clients: u16,
    /// Jobs in the queue at the start
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    queued: u32,
    /// Time for which they claim and complete jobs [s]
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=3600))]
    seconds: u16,
    /// Captures in the list
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(200..=10_000_000))]
    captures: u32,
}

#[derive(Debug, Serialize)]
struct Measured {
    database: String,
    queue: QueueSpeed,
    pages: Vec<PageTime>,
}

pub(super) async fn run(args: Store, global: &Global) -> anyhow::Result<()> {
    let url = args.database.as_deref().map(DatabaseUrl::parse).transpose();
    let url = url.map_err(failure::failed)?;
    let database = url.as_ref().map_or_else(|| "SQLite".to_owned(), ToString::to_string);
    let store = bench::open(&args.folder, url).await.map_err(failure::failed)?;
    let (clients, queued) = (usize::from(args.clients), args.queued as usize);
    let time = Duration::from_secs(u64::from(args.seconds));
    let queue = bench::queue(&store, clients, queued, time).await.map_err(failure::failed)?;
    let pages = bench::pages(&store, args.captures as usize).await.map_err(failure::failed)?;
    store.close().await;
    let measured = Measured { database, queue, pages };
    output::print(global, &measured, || text(&measured))
}

fn text(measured: &Measured) -> String {
    let Measured { database, queue, pages } = measured;
    let QueueSpeed { clients, queued, completed, jobs_per_s, lost } = queue;
    let mut table = Table::new(["ROWS BEFORE THE PAGE", "MEDIAN", "LONGEST"]);
    for PageTime { depth, median_ms, longest_ms } in pages {
        let ms = |time: &f64| format!("{time:.1} ms");
        table.row([depth.to_string(), ms(median_ms), ms(longest_ms)]);
    }
    format!(
        "{database}: {clients} clients claimed and completed {completed} of {queued} jobs, \
         {jobs_per_s:.0} a second; {lost} were lost.\n\nA page of 50 captures:\n{}",
        table.text()
    )
}

//! The check at the end, when all faults are over: everything acknowledged exists unchanged, once,
//! and nothing else.

mod content;
mod jobs;
mod log;

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use bendtwin_proto::v1::{
    Capture, Fit, ListCapturesRequest, ListFitsRequest, ListTwinsRequest, Twin,
};

use crate::{honest::Answer, load, run::Run, schedule::Victim, watch};

/// Most descriptors of an idle server.
const DESCRIPTORS: u64 = 160;
/// Time for connections to be given up.
const QUIET: Duration = Duration::from_secs(90);

/// Limits on memory [MiB].
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemoryLimits {
    pub(crate) server: u64,
    pub(crate) worker: u64,
}

/// Everything that a server lists, by name.
#[derive(Debug)]
struct Listed {
    captures: BTreeMap<String, Capture>,
    fits: BTreeMap<String, Fit>,
    twins: BTreeMap<String, Twin>,
}

/// Checks a system that runs.
pub(crate) async fn check(run: &Run, memory: MemoryLimits) -> anyhow::Result<()> {
    run.system.is_whole().await?;
    finish_uploads(run).await;
    let Some(listed) = jobs::settle(run).await else { return Ok(()) };
    content::captures(run, &listed).await;
    content::twins(run, &listed).await;
    jobs::fits(run, &listed);
    for number in 0..run.references.rollouts.len() {
        load::rollouts::over_grpc(run, number).await;
        load::rollouts::as_json(run, number).await;
    }
    load::sessions::walk(run).await;
    quiet(run).await;
    for (row, limit) in [(watch::SERVER, memory.server), (watch::WORKER, memory.worker)] {
        let peak = run.tally.largest(row);
        if peak > limit {
            run.tally.broken("memory stays within its bound", format_args!("{row}: {peak}"));
        }
    }
    Ok(())
}

/// Checks what a system left that has ended.
pub(crate) fn check_remains(run: &Run) -> anyhow::Result<()> {
    log::read(run)?;
    run.system.check_remains()
}

/// Continues the uploads that were left.
async fn finish_uploads(run: &Run) {
    let left: Vec<_> = run.ledger.things().uploads.clone().into_iter().collect();
    for (path, begun) in left {
        let length = run.references.archives[begun.archive].content.len() as u64;
        load::uploads::send_until(run, &path, length).await;
        run.tally.count("uploads that were continued at the end");
    }
}

/// Waits until the servers have given up the connections of others.
async fn quiet(run: &Run) {
    let began = Instant::now();
    for server in run.system.targets(Victim::Server) {
        loop {
            let count = watch::descriptors(server.pid).unwrap_or(0);
            if count <= DESCRIPTORS {
                break;
            }
            if began.elapsed() > QUIET {
                run.tally.broken("descriptors are given back", format_args!("{count} are open"));
                return;
            }
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
    }
}

impl Listed {
    /// All pages of all lists.
    async fn read(run: &Run) -> Option<Self> {
        let api = run.api();
        let read = async || -> Answer<Self> {
            let (page_size, mut token) = (1000, String::new());
            let mut captures = BTreeMap::new();
            loop {
                let request =
                    ListCapturesRequest { page_size, page_token: token, ..Default::default() };
                let page = api.captures().list_captures(request).await?.into_inner();
                captures.extend(page.captures.into_iter().map(|c| (c.name.clone(), c)));
                token = page.next_page_token;
                if token.is_empty() {
                    break;
                }
            }
            let mut fits = BTreeMap::new();
            loop {
                let request =
                    ListFitsRequest { page_size, page_token: token, ..Default::default() };
                let page = api.fits().list_fits(request).await?.into_inner();
                fits.extend(page.fits.into_iter().map(|f| (f.name.clone(), f)));
                token = page.next_page_token;
                if token.is_empty() {
                    break;
                }
            }
            let mut twins = BTreeMap::new();
            loop {
                let request =
                    ListTwinsRequest { page_size, page_token: token, ..Default::default() };
                let page = api.twins().list_twins(request).await?.into_inner();
                twins.extend(page.twins.into_iter().map(|t| (t.name.clone(), t)));
                token = page.next_page_token;
                if token.is_empty() {
                    break;
                }
            }
            Ok(Self { captures, fits, twins })
        };
        run.expect("the lists of everything", read).await
    }
}

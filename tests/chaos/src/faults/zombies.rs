//! Zombies: workers that stand still in the middle of a job until it has been taken from them, and go
//! on then as if nothing had happened. [`crate::fleet`] checks that nothing of that was written.

use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use bendtwin_proto::v1::Worker;
use tokio::{
    sync::Mutex,
    time::{sleep, timeout},
};

use super::processes::Stopped;
use crate::run::Run;

/// Time to wait for a worker with a job.
const WAIT: Duration = Duration::from_secs(30);
/// Longest time until a job is taken from a worker that stands still: other faults may be in the way.
const TAKEN: Duration = Duration::from_secs(60);
const INTERVAL: Duration = Duration::from_millis(100);
const CALL: Duration = Duration::from_secs(3);

/// Held while a worker stands still: the other workers have to take the job over.
static TURN: Mutex<()> = Mutex::const_new(());

pub(super) async fn make(run: &Run, chance: u64, beyond: Duration) -> anyhow::Result<()> {
    let _turn = TURN.lock().await;
    anyhow::ensure!(run.is_under_load(), "the load has ended");
    let fleet = run.system.fleet().context("there is one server")?;
    let (worker, supervised) = {
        let began = Instant::now();
        loop {
            let mut at_work = workers(run).await.unwrap_or_default();
            at_work.retain(|worker| !job(worker).is_empty());
            if !at_work.is_empty() {
                let worker = at_work.swap_remove((chance % at_work.len() as u64) as usize);
                let supervised = fleet.worker_with(&worker.labels)?;
                break (worker, supervised);
            }
            if began.elapsed() > WAIT {
                bail!("no worker has a job");
            }
            sleep(INTERVAL).await;
        }
    };
    let stopped = Stopped::new(vec![supervised.pid().context("it does not run")?]);
    let began = Instant::now();
    // Forgotten: no server has heard of it for a lease, and its jobs are free.
    while workers(run).await.is_none_or(|all| all.iter().any(|other| other.name == worker.name)) {
        if began.elapsed() > TAKEN {
            bail!("{} was not forgotten within {TAKEN:?}", worker.name);
        }
        sleep(INTERVAL).await;
    }
    run.tally.took("leases: longest until a zombie had lost its job", began.elapsed());
    sleep(beyond).await;
    drop(stopped);
    run.disturb();
    let kind = if worker.fit.is_empty() { "an ingest" } else { "a fit" };
    run.tally.count(format!("faults: zombies in {kind}"));
    run.tally.log(format_args!("{} woke up, it had {}", supervised.name(), job(&worker)));
    Ok(())
}

fn job(worker: &Worker) -> &str {
    if worker.fit.is_empty() { &worker.ingest } else { &worker.fit }
}

async fn workers(run: &Run) -> Option<Vec<Worker>> {
    let api = run.system.api();
    timeout(CALL, api.list_workers()).await.ok()?.ok()
}

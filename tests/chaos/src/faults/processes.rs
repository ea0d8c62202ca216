//! Processes that are killed, or stand still.

use std::time::{Duration, Instant};

use anyhow::Context as _;
use bendtwin_harness::process::signal;
use tokio::time::sleep;

use crate::{run::Run, schedule::Victim, system::Target};

/// Time to wait for a process to kill: readers live for moments.
const WAIT: Duration = Duration::from_secs(10);

/// kill -9.
pub(super) async fn kill_one(run: &Run, victim: Victim, chance: u64) -> anyhow::Result<()> {
    let target = find(run, victim, chance).await?;
    // Not at its first moment.
    if victim == Victim::Reader {
        sleep(Duration::from_millis(chance % 100)).await;
    }
    target.kill();
    run.disturb();
    run.tally.count(format!("faults: kills of a {}", name(victim)));
    Ok(())
}

/// SIGTERM for a server.
pub(super) async fn restart(run: &Run, chance: u64) -> anyhow::Result<()> {
    let target = find(run, Victim::Server, chance).await?;
    target.supervised.context("it is not supervised")?.restart().await?;
    run.disturb();
    run.tally.count("faults: orderly restarts of a server");
    Ok(())
}

/// SIGSTOP, and SIGCONT after a while.
pub(super) async fn pause(
    run: &Run,
    victim: Victim,
    chance: u64,
    held: Duration,
) -> anyhow::Result<()> {
    let pid = find(run, victim, chance).await?.pid;
    let stopped = Stopped::new(vec![pid]);
    sleep(held).await;
    drop(stopped);
    run.disturb();
    run.tally.count(format!("faults: pauses of a {}", name(victim)));
    Ok(())
}

/// Processes that stand still until this is dropped.
pub(super) struct Stopped(Vec<u32>);

impl Stopped {
    /// SIGSTOP.
    pub(super) fn new(pids: Vec<u32>) -> Self {
        pids.iter().for_each(|pid| signal(*pid, "STOP"));
        Self(pids)
    }
}

impl Drop for Stopped {
    fn drop(&mut self) {
        self.0.iter().for_each(|pid| signal(*pid, "CONT"));
    }
}

async fn find(run: &Run, victim: Victim, chance: u64) -> anyhow::Result<Target> {
    let began = Instant::now();
    loop {
        let mut targets = run.system.targets(victim);
        if !targets.is_empty() {
            return Ok(targets.swap_remove((chance % targets.len() as u64) as usize));
        }
        if began.elapsed() > WAIT {
            return Err(anyhow::anyhow!("none runs")).context(name(victim));
        }
        sleep(Duration::from_millis(5)).await;
    }
}

fn name(victim: Victim) -> &'static str {
    match victim {
        Victim::Server => "server",
        Victim::Worker => "worker",
        Victim::Reader => "reader",
    }
}

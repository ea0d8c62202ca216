//! Processes that are killed, or stand still.

use std::time::{Duration, Instant};

use anyhow::Context as _;
use bendtwin_harness::process::{kill, signal};
use tokio::time::sleep;

use crate::{run::Run, schedule::Victim};

/// Time to wait for a process to kill: readers live for moments.
const WAIT: Duration = Duration::from_secs(10);

/// kill -9.
pub(super) async fn kill_one(run: &Run, victim: Victim, chance: u64) -> anyhow::Result<()> {
    let pid = find(run, victim, chance).await?;
    // Not at its first moment.
    if victim == Victim::Reader {
        sleep(Duration::from_millis(chance % 100)).await;
    }
    match victim {
        Victim::Server => run.server.kill(),
        Victim::Worker | Victim::Reader => kill(pid),
    }
    run.disturb();
    run.tally.count(format!("faults: kills of a {}", name(victim)));
    Ok(())
}

/// SIGTERM for the server.
pub(super) async fn restart(run: &Run) -> anyhow::Result<()> {
    run.server.restart().await?;
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
    let pid = find(run, victim, chance).await?;
    signal(pid, "STOP");
    sleep(held).await;
    signal(pid, "CONT");
    run.disturb();
    run.tally.count(format!("faults: pauses of a {}", name(victim)));
    Ok(())
}

async fn find(run: &Run, victim: Victim, chance: u64) -> anyhow::Result<u32> {
    let began = Instant::now();
    loop {
        let pids = match victim {
            Victim::Server => run.server.pid().into_iter().collect(),
            Victim::Worker => run.server.workers(),
            Victim::Reader => run.server.readers(),
        };
        if !pids.is_empty() {
            return Ok(pids[(chance % pids.len() as u64) as usize]);
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

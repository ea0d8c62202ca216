//! Full disks: filled, held, freed; measured is the time until a write succeeds again.

use std::time::{Duration, Instant};

use anyhow::Context as _;
use reqwest::Method;
use tokio::{
    sync::Mutex,
    time::{sleep, timeout},
};

use super::processes;
use crate::{honest::send, ledger::Fate, run::Run};

/// Longest time until a write succeeds again: four times the target, for a busy machine.
const RECOVERY: Duration = Duration::from_secs(20);
const INTERVAL: Duration = Duration::from_millis(100);

/// Held while a disk is full: one at a time.
static FULL: Mutex<()> = Mutex::const_new(());

pub(super) async fn fill(
    run: &Run,
    held: Duration,
    fresh: bool,
    pressed: bool,
) -> anyhow::Result<()> {
    let _alone = FULL.lock().await;
    let disk = run.disk.clone().context("there is no disk")?;
    let fill = async || {
        let disk = disk.clone();
        tokio::task::spawn_blocking(move || disk.fill()).await
    };
    if fresh {
        processes::restart(run, 0).await?;
    }
    let victim = store(run).await.context("nothing to delete")?;
    let excuse = run.excuses.begin();
    let began = Instant::now();
    fill().await??;
    run.tally.log("the disk is full");
    run.tally.count("faults: full disks");
    let mut deleted = false;
    while began.elapsed() < held {
        // Under pressure, space that a deletion frees is gone immediately: no deletion then.
        if pressed {
            fill().await??;
        } else if !deleted {
            deleted = delete(run, &victim).await;
        }
        sleep(INTERVAL).await;
    }
    if deleted {
        run.tally.count("disk: deletions that a full disk let through");
    }
    disk.free()?;
    let freed = Instant::now();
    run.tally.log("the disk has room again");
    let again = store(run).await;
    // Time for which other faults held the server is no fault of the disk's.
    let recovery = freed.max(run.last_disturbance().min(Instant::now())).elapsed();
    drop(excuse);
    run.tally.took("disk: longest until a write succeeded again", recovery);
    if recovery > RECOVERY || again.is_none() {
        let case = format!("not within {:.1} s", recovery.as_secs_f64());
        run.tally.broken("writes succeed again when a full disk has room", case);
    }
    if !deleted {
        run.delete(&victim, false).await;
    }
    if let Some(name) = again {
        run.delete(&name, false).await;
    }
    Ok(())
}

/// Stores a capture; tries again at short intervals.
async fn store(run: &Run) -> Option<String> {
    let (display_name, request_id) = (run.fresh("disk"), run.fresh("request"));
    let name = run.upload(true, 0, &display_name, &request_id).await?;
    run.ledger.capture(&name, &run.references.archives[0].digest, false);
    run.tally.count("acknowledged: captures");
    Some(name)
}

/// Attempts to delete a capture.
async fn delete(run: &Run, name: &str) -> bool {
    run.ledger.fate(name, Fate::Leaving);
    let request = run.http().request(Method::DELETE, &format!("/v1/{name}"));
    let answer = timeout(Duration::from_secs(5), send(request)).await;
    let deleted = matches!(answer, Ok(Ok(_)));
    if deleted {
        run.ledger.fate(name, Fate::Deleted);
        run.tally.count("acknowledged: deletions");
    } else {
        run.tally.log(format_args!("a deletion on a full disk: {answer:?}"));
    }
    deleted
}

//! Jobs: all have ended, as they should.

use std::time::{Duration, Instant};

use bendtwin_proto::v1::{Fit, Job, job::State};
use tokio::time::sleep;

use super::Listed;
use crate::{ledger::Fate, run::Run};

/// Time for everything that is queued to be done.
const SETTLE: Duration = Duration::from_secs(300);
/// Reasons for which a job may fail that was killed again and again, or met a full disk.
const LEGITIMATE: [&str; 5] =
    ["WORKER_LOST", "INGEST_CRASHED", "DISK_FULL", "NO_DISK_SPACE", "INGEST_RESULT_LOST"];

/// Waits until no job is under way; then lists everything.
pub(super) async fn settle(run: &Run) -> Option<Listed> {
    let began = Instant::now();
    loop {
        let listed = Listed::read(run).await?;
        let fits = listed.fits.values().map(|fit| (&fit.name, &fit.job));
        let jobs = fits.chain(listed.captures.values().map(|c| (&c.name, &c.ingest)));
        let is_under_way = |job: &Job| matches!(job.state(), State::Queued | State::Running);
        let left: Vec<_> = jobs.filter(|(_, job)| job.as_ref().is_some_and(is_under_way)).collect();
        if left.is_empty() {
            run.tally.took("recovery: time for the jobs that were left", began.elapsed());
            return Some(listed);
        }
        if began.elapsed() > SETTLE {
            for (name, job) in left {
                run.tally.broken("every job ends", format_args!("{name}: {job:?}"));
            }
            return Some(listed);
        }
        sleep(Duration::from_millis(500)).await;
    }
}

/// Compares fits and ingests with the ledger.
pub(super) fn fits(run: &Run, listed: &Listed) {
    let things = run.ledger.things();
    for (name, ordered) in &things.fits {
        match (ordered.fate, listed.fits.get(name)) {
            (Fate::Kept, None) => run.tally.broken("nothing that was acknowledged is lost", name),
            (Fate::Deleted, Some(_)) => run.tally.broken("what was deleted stays deleted", name),
            (_, Some(fit)) => ended(run, listed, fit, ordered.cancelled),
            (_, None) => {}
        }
    }
    for name in listed.fits.keys().filter(|name| !things.fits.contains_key(*name)) {
        run.tally.broken("nothing is made twice", name);
    }
    for (name, capture) in &listed.captures {
        let is_honest = things.captures.get(name).is_some_and(|stored| !stored.is_hostile);
        if let Some(ingest) = capture.ingest.as_ref().filter(|_| is_honest) {
            let what = format!("the ingest of {name}");
            run.tally.count(format!("ingests: {}", ingest.state().as_str_name()));
            if ingest.state() == State::Failed {
                failed(run, &what, ingest);
            }
        }
    }
}

fn ended(run: &Run, listed: &Listed, fit: &Fit, cancelled: bool) {
    let Some(job) = &fit.job else { return };
    run.tally.count(format!("fits: {}", job.state().as_str_name()));
    match job.state() {
        State::Succeeded if !listed.twins.contains_key(&fit.twin) => {
            let case = format_args!("{} of {}", fit.twin, fit.name);
            run.tally.broken("nothing that was acknowledged is lost", case);
        }
        State::Cancelled if !cancelled => {
            run.tally.broken("nobody but its owner cancels a fit", &fit.name);
        }
        State::Failed => failed(run, &fit.name, job),
        _ => {}
    }
}

fn failed(run: &Run, what: &str, job: &Job) {
    let fault = job.fault.clone().unwrap_or_default();
    run.tally.count(format!("jobs that failed: {}", fault.reason));
    run.tally.log(format_args!("{what} failed: {job:?}"));
    if !LEGITIMATE.contains(&fault.reason.as_str()) {
        let case = format_args!("{what}: {} {}", fault.reason, fault.message);
        run.tally.broken("a job fails only for what was done to it", case);
    }
}

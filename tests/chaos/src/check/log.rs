//! The logs of servers and workers: ends without a cause.

use crate::run::Run;

/// Reads the logs of a run.
pub(super) fn read(run: &Run) -> anyhow::Result<()> {
    for log in run.system.logs() {
        let text = std::fs::read(log)?;
        let text = String::from_utf8_lossy(&text);
        text.lines().for_each(|line| judge(run, line));
    }
    Ok(())
}

fn judge(run: &Run, line: &str) {
    if line.contains("panicked at") {
        run.tally.broken("no process panics", line.trim());
    }
    // By its supervisor in the server; SIGKILL is from here.
    if line.contains("worker ended, restarting") && !line.contains("signal: 9") {
        run.tally.count("workers that ended by themselves");
        run.tally.broken("no worker ends by itself", line.trim());
    }
}

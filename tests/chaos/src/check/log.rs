//! The log of the server and its workers: ends that nobody caused.

use crate::run::Run;

/// Reads the log of a run.
pub(super) fn read(run: &Run) -> anyhow::Result<()> {
    let text = std::fs::read(run.server.log_file())?;
    for line in String::from_utf8_lossy(&text).lines() {
        if line.contains("panicked at") {
            run.tally.broken("no process panics", line.trim());
        }
        // By its supervisor in the server; SIGKILL is from here.
        if line.contains("worker ended, restarting") && !line.contains("signal: 9") {
            run.tally.count("workers that ended by themselves");
            run.tally.broken("no worker ends by itself", line.trim());
        }
    }
    Ok(())
}

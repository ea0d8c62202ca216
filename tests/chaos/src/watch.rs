//! Memory and descriptors of the server and its workers, while they run.

use std::{sync::Arc, time::Duration};

use crate::run::Run;

const INTERVAL: Duration = Duration::from_millis(500);

/// Watches until the task is ended.
pub(crate) async fn watch(run: Arc<Run>) {
    loop {
        if let Some(pid) = run.server.pid() {
            if let Some(bytes) = peak_memory(pid) {
                run.tally.reached(SERVER, bytes >> 20);
            }
            if let Some(count) = descriptors(pid) {
                run.tally.reached("memory: most descriptors of the server", count);
            }
        }
        for bytes in run.server.workers().into_iter().filter_map(peak_memory) {
            run.tally.reached(WORKER, bytes >> 20);
        }
        tokio::time::sleep(INTERVAL).await;
    }
}

/// Row of the server's peak.
pub(crate) const SERVER: &str = "memory: peak of the server [MiB]";
/// Row of a worker's peak.
pub(crate) const WORKER: &str = "memory: peak of a worker [MiB]";

/// Peak of a process's memory [bytes].
fn peak_memory(pid: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse::<u64>().ok()?.checked_mul(1024)
}

/// Number of open descriptors.
pub(crate) fn descriptors(pid: u32) -> Option<u64> {
    Some(std::fs::read_dir(format!("/proc/{pid}/fd")).ok()?.count() as u64)
}

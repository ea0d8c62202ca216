//! Memory and descriptors of servers and workers, while they run.

use std::{sync::Arc, time::Duration};

use crate::{run::Run, schedule::Victim};

const INTERVAL: Duration = Duration::from_millis(500);

/// Watches until the task is ended.
pub(crate) async fn watch(run: Arc<Run>) {
    loop {
        for server in run.system.targets(Victim::Server) {
            if let Some(bytes) = peak_memory(server.pid) {
                run.tally.reached(SERVER, bytes >> 20);
            }
            if let Some(count) = descriptors(server.pid) {
                run.tally.reached("memory: most descriptors of a server", count);
            }
        }
        for worker in run.system.targets(Victim::Worker) {
            if let Some(bytes) = peak_memory(worker.pid) {
                run.tally.reached(WORKER, bytes >> 20);
            }
        }
        tokio::time::sleep(INTERVAL).await;
    }
}

/// Row of a server's peak.
pub(crate) const SERVER: &str = "memory: peak of a server [MiB]";
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

//! Processes of a cluster, found and killed by an environment variable, so that nothing outlives a
//! test.

use std::{
    collections::{HashMap, HashSet},
    path::Path,
    process::{Child, Command, Stdio},
};

/// The environment variable that marks a cluster's processes.
const MARK: &str = "BENDTWIN_E2E_CLUSTER";

/// A cluster's processes.
#[derive(Debug)]
pub struct Processes {
    mark: String,
}

impl Processes {
    /// The processes of the cluster in this folder.
    pub fn new(cluster: &Path) -> Self {
        Self { mark: format!("{MARK}={}", cluster.display()) }
    }

    /// Starts a process of this cluster; its output goes to `log`.
    pub fn start(&self, command: &mut Command, log: &Path) -> Child {
        let log = std::fs::OpenOptions::new().create(true).append(true).open(log).unwrap();
        let (name, value) = self.mark.split_once('=').unwrap();
        command
            .env(name, value)
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .spawn()
            .unwrap()
    }

    /// Ids of the live worker processes, in no particular order.
    pub fn workers(&self) -> Vec<u32> {
        self.running("worker")
    }

    /// Ids of the live processes that read captures.
    pub fn readers(&self) -> Vec<u32> {
        self.running("ingest-capture")
    }

    fn running(&self, command: &str) -> Vec<u32> {
        let runs = |pid: &u32| {
            let arguments = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            arguments.split(|b| *b == 0).nth(1) == Some(command.as_bytes())
        };
        self.all().into_iter().filter(runs).collect()
    }

    /// Ids of all live processes: those with the mark and what they started, for a process may be
    /// started without the environment of its parent.
    fn all(&self) -> Vec<u32> {
        let pids = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let parents: HashMap<u32, u32> = pids
            .filter_map(|entry| entry.file_name().to_string_lossy().parse().ok())
            .filter_map(|pid| Some((pid, parent(pid)?)))
            .collect();
        let mut ours: HashSet<u32> =
            parents.keys().copied().filter(|pid| self.has_mark(*pid)).collect();
        loop {
            let children =
                parents.iter().filter(|(pid, parent)| ours.contains(parent) && !ours.contains(pid));
            let children: Vec<u32> = children.map(|(pid, _)| *pid).collect();
            if children.is_empty() {
                return ours.into_iter().collect();
            }
            ours.extend(children);
        }
    }

    fn has_mark(&self, pid: u32) -> bool {
        let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        environment.split(|b| *b == 0).any(|entry| entry == self.mark.as_bytes())
    }
}

/// Id of the parent of a live process.
fn parent(pid: u32) -> Option<u32> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in parentheses, may have spaces.
    let mut fields = stat.rsplit_once(") ")?.1.split(' ');
    let state = fields.next()?;
    fields.next()?.parse().ok().filter(|_| state != "Z")
}

impl Drop for Processes {
    fn drop(&mut self) {
        // A process that is just being started may be missed once, so this repeats until no process
        // is left.
        for _ in 0..10 {
            let all = self.all();
            if all.is_empty() {
                break;
            }
            all.into_iter().for_each(kill);
        }
    }
}

/// kill -9.
pub fn kill(pid: u32) {
    signal(pid, "KILL");
}

/// Sends a signal, by its name without `SIG`; nothing happens if the process is gone.
pub fn signal(pid: u32, name: &str) {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("kill -s {name} {pid}")]).stderr(Stdio::null());
    shell.status().unwrap();
}

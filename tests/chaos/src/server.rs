//! A server with its own workers, over one folder.

use std::{
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
};

use bendtwin_harness::{command::bendtwin, process::Processes};

use crate::{
    clock::Clock,
    supervised::{Excuses, Plan, Supervised},
    tally::Tally,
};

/// Workers of the server.
const WORKERS: usize = 2;
/// Time after which a worker that does not report loses its job [s]: shorter than the longest
/// pauses, so that these pauses matter.
const LEASE_S: f64 = 4.0;
/// Memory that requests at a server may take together [MiB].
pub(crate) const SERVER_MIB: u64 = 512;
/// Memory of the workers together [MiB].
pub(crate) const WORKERS_MIB: u64 = 2048;

/// The server, its workers and their folder.
pub(crate) struct Server {
    folder: PathBuf,
    address: String,
    processes: Arc<Processes>,
    pub(crate) supervised: Arc<Supervised>,
    tally: Arc<Tally>,
}

impl Server {
    /// Workers that it has when it is whole.
    pub(crate) const WORKERS: usize = WORKERS;

    /// A server with its data in `folder/data`; it is not started yet.
    pub(crate) fn new(
        folder: &Path,
        clock: Option<Clock>,
        tally: Arc<Tally>,
        excuses: Excuses,
    ) -> anyhow::Result<Self> {
        let free = std::net::TcpListener::bind("127.0.0.1:0")?;
        let address = free.local_addr()?.to_string();
        // The disk is small. Small uploads that were begun shall still be there after hours.
        let text = format!(
            "listen = \"{address}\"\n\
             data_dir = \"{data}\"\n\
             client_token = \"none\"\n\
             lease_s = {LEASE_S:?}\n\
             heartbeat_interval_s = {heartbeat:?}\n\
             upload_start_s = 604800.0\n\
             disk_floor_mib = 32\n\
             trash_s = 30.0\n\
             memory_mib = {SERVER_MIB}\n\
             [workers]\n\
             count = {WORKERS}\n\
             memory_mib = {WORKERS_MIB}\n\
             backend = \"cpu\"\n",
            data = folder.join("data").display(),
            heartbeat = LEASE_S / 4.0,
        );
        std::fs::write(folder.join("config.toml"), text)?;
        let place = folder.to_owned();
        let command = move || {
            let mut command = bendtwin();
            command.arg("server").arg("--config").arg(place.join("config.toml"));
            command.env("TMPDIR", place.join("tmp"));
            if let Some(clock) = &clock {
                clock.preload(&mut command);
            }
            command
        };
        let plan = Plan {
            name: "server".to_owned(),
            command: Box::new(command),
            log: folder.join("server.log"),
            url: Some(format!("http://{address}")),
        };
        let processes = Arc::new(Processes::new(folder));
        let supervised = Arc::new(Supervised::new(plan, processes.clone(), tally.clone(), excuses));
        Ok(Self { folder: folder.to_owned(), address, processes, supervised, tally })
    }

    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    pub(crate) fn workers(&self) -> Vec<u32> {
        self.processes.workers()
    }

    pub(crate) fn readers(&self) -> Vec<u32> {
        self.processes.readers()
    }

    /// `bendtwin store check` of the data of a server that has ended.
    pub(crate) fn check_store(&self) -> anyhow::Result<()> {
        let knows = bendtwin().args(["store", "check", "--help"]).output()?;
        if !knows.status.success() {
            self.tally.say("SKIPPED store check: this binary has no such command");
            return Ok(());
        }
        let mut command: Command = bendtwin();
        let output = command
            .args(["store", "check", "--data-dir"])
            .arg(self.folder.join("data"))
            .output()?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned()
            + &String::from_utf8_lossy(&output.stderr);
        self.tally.log(format_args!("store check: {}\n{text}", output.status));
        if !output.status.success() {
            self.tally.broken("the store is in order", text.trim());
        }
        Ok(())
    }
}

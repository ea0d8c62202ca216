//! A server with workers in a temporary folder: the server's own, or some that the test starts.

use std::{
    path::{Path, PathBuf},
    process::Child,
    time::Duration,
};

use bendtwin_proto::v1::Worker;
use tempfile::TempDir;
use tokio::sync::SemaphorePermit;

use crate::{
    Api,
    command::{bendtwin, bendtwin_within},
    http::Http,
    process::{Processes, kill},
    waiting::{self, until},
};

/// Longest time for the start of a process on a busy machine.
pub const START: Duration = Duration::from_secs(60);
/// The token of workers that the test starts itself.
pub(crate) const TOKEN: &str = "end-to-end-worker-token";

/// Time after which a dead worker's job goes to the next one, where the server did not see the worker die [s]. A live
/// worker is heard within it on a machine that is busy with other things.
const LEASE_S: f64 = 5.0;

/// Options of a cluster.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Workers that the server starts and restarts itself.
    pub own_workers: u32,
    /// Other clusters that may run at the same time.
    pub isolation: Isolation,
    /// Additional arguments of the server's own workers.
    pub worker_args: &'static [&'static str],
    /// Bounds on the memory of the processes.
    pub memory: Option<Memory>,
    /// URL of the server's database, if that is PostgreSQL.
    pub database: Option<String>,
    /// The data folder, if the server has it in common with others.
    pub data_dir: Option<PathBuf>,
    /// More variables of the server's environment.
    pub environment: Vec<(&'static str, String)>,
}

/// Budgets of memory, and limits of the system above them (`RLIMIT_DATA`: all memory that a process
/// may write, stacks of threads included).
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// Budget of the server [MiB].
    pub server_mib: u64,
    /// Budget of each worker that the test starts [MiB].
    pub worker_mib: u64,
    /// Memory of either beyond its budget [MiB].
    pub base_mib: u64,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            own_workers: 1,
            isolation: Isolation::Shared,
            worker_args: &[],
            memory: None,
            database: None,
            data_dir: None,
            environment: Vec::new(),
        }
    }
}

/// Other clusters that may run at the same time.
#[derive(Clone, Copy, Debug)]
pub enum Isolation {
    /// Number that the machine can take.
    Shared,
    /// No other cluster, because time is measured.
    Exclusive,
    /// Any number: the caller holds a slot already.
    Nested,
}

/// A server with its workers and its folder.
pub struct TestCluster {
    setup: Setup,
    child: Child,
    address: String,
    started: Vec<Child>,
    processes: Processes,
    folder: TempDir,
    _slots: Option<SemaphorePermit<'static>>,
}

impl TestCluster {
    /// Starts a cluster and waits until it is ready.
    pub async fn start(setup: Setup) -> Self {
        let slots = match setup.isolation {
            Isolation::Shared => Some(waiting::shared_slot().await),
            Isolation::Exclusive => Some(waiting::all_slots().await),
            Isolation::Nested => None,
        };
        let folder = tempfile::Builder::new().prefix("bendtwin-e2e-").tempdir().unwrap();
        let processes = Processes::new(folder.path());
        let (child, address) = launch(&processes, folder.path(), &setup, "127.0.0.1:0").await;
        let server =
            Self { setup, child, address, started: Vec::new(), processes, folder, _slots: slots };
        server.workers_ready(server.setup.own_workers as usize).await;
        server
    }

    /// A cluster with default options.
    pub async fn ordinary() -> Self {
        Self::start(Setup::default()).await
    }

    /// `http://host:port`.
    pub fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    /// A new gRPC channel.
    pub fn api(&self) -> Api {
        Api::new(&self.address)
    }

    /// An HTTP client.
    pub fn http(&self) -> Http {
        Http::new(&self.url())
    }

    /// The folder that survives restarts.
    pub fn data_dir(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    /// A path for a file of the test.
    pub fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_string_lossy().into_owned()
    }

    /// Output of all processes.
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }

    /// kill -9 of the server; its workers have to notice by themselves.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Starts the server again after [`TestCluster::kill`], at the same address.
    pub async fn start_again(&mut self) {
        let (child, address) =
            launch(&self.processes, self.folder.path(), &self.setup, &self.address).await;
        self.child = child;
        assert_eq!(address, self.address);
    }

    /// True if the server process still runs and has not been replaced.
    pub fn is_alive(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Id of the server process.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Ids of the worker processes.
    pub fn worker_pids(&self) -> Vec<u32> {
        self.processes.workers()
    }

    /// Ids of the processes that read captures.
    pub fn reader_pids(&self) -> Vec<u32> {
        self.processes.readers()
    }

    /// kill -9 of every worker process.
    pub fn kill_workers(&self) {
        self.worker_pids().into_iter().for_each(kill);
    }

    /// Starts a worker that the server did not start.
    pub async fn start_worker(&mut self) -> Worker {
        let before: Vec<_> = self.known_workers().await.into_iter().map(|w| w.name).collect();
        let mut command = match self.setup.memory {
            None => bendtwin(),
            Some(memory) => bendtwin_within(memory.worker_mib + memory.base_mib),
        };
        if let Some(memory) = self.setup.memory {
            command.env("BENDTWIN_WORKER_MEMORY_MIB", memory.worker_mib.to_string());
        }
        command.args(["worker", "--server", &self.url()]).env("BENDTWIN_WORKER_TOKEN", TOKEN);
        self.started.push(self.processes.start(&mut command, &self.folder.path().join("log")));
        until("a new worker", START, async || {
            self.known_workers().await.into_iter().find(|w| !before.contains(&w.name))
        })
        .await
    }

    /// kill -9 of a worker that the test started, oldest first.
    pub fn kill_own_worker(&mut self) {
        let mut worker = self.started.remove(0);
        worker.kill().unwrap();
        worker.wait().unwrap();
    }

    async fn known_workers(&self) -> Vec<Worker> {
        self.api().list_workers().await.unwrap_or_default()
    }

    async fn workers_ready(&self, count: usize) {
        // A server that takes a token shows the list to nobody here.
        if count == 0 {
            return;
        }
        let api = self.api();
        until(&format!("{count} workers\n{}", self.log()), START, async || {
            (api.list_workers().await.ok()?.len() >= count).then_some(())
        })
        .await;
    }
}

impl Drop for TestCluster {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let log = self.log();
            let tail: Vec<_> = log.lines().rev().take(30).collect();
            eprintln!("the last lines of the server and its workers:");
            tail.into_iter().rev().for_each(|line| eprintln!("  {line}"));
        }
        // Reaps the children; what they started ends with `processes`.
        for child in self.started.iter_mut().chain([&mut self.child]) {
            child.kill().ok();
            child.wait().ok();
        }
    }
}

/// Starts a server and waits until it answers; returns its address as well.
pub(crate) async fn launch(
    processes: &Processes,
    folder: &Path,
    setup: &Setup,
    listen: &str,
) -> (Child, String) {
    let mut child = begin(processes, folder, setup, listen);
    let address = until("the server's address", START, async || {
        if let Some(status) = child.try_wait().unwrap() {
            let log = std::fs::read_to_string(folder.join("log")).unwrap();
            panic!("the server ended ({status}):\n{log}");
        }
        let text = std::fs::read_to_string(folder.join("port")).ok()?;
        let port: u16 = text.trim().parse().ok()?;
        Some(format!("127.0.0.1:{port}"))
    })
    .await;
    until("the server to answer", START, async || {
        Http::new(&format!("http://{address}")).is_up().await.then_some(())
    })
    .await;
    (child, address)
}

/// Starts the process of a server, which writes into the files `log` and `port` of a folder.
pub(crate) fn begin(processes: &Processes, folder: &Path, setup: &Setup, listen: &str) -> Child {
    let (config, port_file) = (folder.join("config.toml"), folder.join("port"));
    std::fs::remove_file(&port_file).ok();
    let Setup { own_workers, worker_args, .. } = setup;
    let args: Vec<&str> = ["worker"].iter().chain(*worker_args).copied().collect();
    let text = format!(
        "listen = \"{listen}\"\n\
         data_dir = \"{data}\"\n\
         worker_token = \"{TOKEN}\"\n\
         client_token = \"none\"\n\
         lease_s = {LEASE_S:?}\n\
         heartbeat_interval_s = {heartbeat:?}\n\
         [workers]\n\
         count = {own_workers}\n\
         args = {args:?}\n\
         min_backoff_s = 0.02\n\
         max_backoff_s = 0.2\n",
        data = setup.data_dir.clone().unwrap_or_else(|| folder.join("data")).display(),
        heartbeat = LEASE_S / 4.0,
    );
    std::fs::write(&config, text).unwrap();
    let mut command = match setup.memory {
        None => bendtwin(),
        Some(memory) => bendtwin_within(memory.server_mib + memory.base_mib),
    };
    if let Some(memory) = setup.memory {
        command.env("BENDTWIN_MEMORY_MIB", memory.server_mib.to_string());
    }
    if let Some(url) = &setup.database {
        command.env("BENDTWIN_DATABASE_URL", url);
    }
    command.envs(setup.environment.iter().map(|(name, value)| (name, value)));
    command.arg("server").arg("--config").arg(&config).arg("--port-file").arg(&port_file);
    processes.start(&mut command, &folder.join("log"))
}

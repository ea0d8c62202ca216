//! Several servers over one PostgreSQL database and one folder of content, and workers that know all of
//! them.

use std::{path::PathBuf, process::Child, time::Duration};

use tempfile::TempDir;
use tokio::sync::SemaphorePermit;

use crate::{
    Api, Postgres, Setup,
    cluster::{START, TOKEN, begin, launch},
    command::bendtwin,
    http::Http,
    process::Processes,
    waiting::{self, until},
};

/// Servers and workers of one database.
pub struct Fleet {
    servers: Vec<Server>,
    workers: Vec<Child>,
    processes: Processes,
    folder: TempDir,
    postgres: Postgres,
    _slot: SemaphorePermit<'static>,
}

struct Server {
    child: Child,
    address: String,
    setup: Setup,
    folder: PathBuf,
}

impl Fleet {
    /// Starts a server for each number, with that number of its own workers; `None` without
    /// PostgreSQL.
    pub async fn start_or_skip(own_workers: &[u32]) -> Option<Self> {
        let postgres = Postgres::start_or_skip().await?;
        let slot = waiting::shared_slot().await;
        let folder = tempfile::Builder::new().prefix("bendtwin-fleet-").tempdir().unwrap();
        let processes = Processes::new(folder.path());
        let mut servers = Vec::new();
        for (number, own_workers) in own_workers.iter().enumerate() {
            let setup = Setup {
                own_workers: *own_workers,
                database: Some(postgres.url_with_password("none")),
                data_dir: Some(folder.path().join("data")),
                ..Setup::default()
            };
            let place = folder.path().join(format!("server-{number}"));
            std::fs::create_dir(&place).unwrap();
            let (child, address) = launch(&processes, &place, &setup, "127.0.0.1:0").await;
            servers.push(Server { child, address, setup, folder: place });
        }
        let workers = Vec::new();
        Some(Self { servers, workers, processes, folder, postgres, _slot: slot })
    }

    /// A new gRPC channel to a server.
    pub fn api(&self, server: usize) -> Api {
        Api::new(&self.servers[server].address)
    }

    /// An HTTP client of a server.
    pub fn http(&self, server: usize) -> Http {
        Http::new(&self.url(server))
    }

    /// `http://host:port` of a server.
    pub fn url(&self, server: usize) -> String {
        format!("http://{}", self.servers[server].address)
    }

    /// Output of a server and its own workers.
    pub fn log(&self, server: usize) -> String {
        std::fs::read_to_string(self.servers[server].folder.join("log")).unwrap_or_default()
    }

    /// kill -9 of a server.
    pub fn kill(&mut self, server: usize) {
        let child = &mut self.servers[server].child;
        child.kill().unwrap();
        child.wait().unwrap();
    }

    /// Starts a server again after [`Fleet::kill`], at the same address.
    pub async fn start_again(&mut self, server: usize) {
        let Server { address, setup, folder, .. } = &self.servers[server];
        let (child, _) = launch(&self.processes, folder, setup, address).await;
        self.servers[server].child = child;
    }

    /// Starts a server that is to refuse its start after [`Fleet::kill`]; returns what it says.
    pub async fn refused_start(&mut self, server: usize) -> String {
        let Server { child, address, setup, folder } = &mut self.servers[server];
        let before = std::fs::read_to_string(folder.join("log")).unwrap().len();
        *child = begin(&self.processes, folder, setup, address);
        let status = until("the end of a server", START, async || child.try_wait().unwrap()).await;
        assert!(!status.success(), "the server has not refused its start");
        std::fs::read_to_string(folder.join("log")).unwrap()[before..].to_owned()
    }

    /// The answer of the database to statements.
    pub async fn query(&self, statements: &str) -> String {
        self.postgres.query(statements).await
    }

    /// Starts a worker that knows all servers and calls this one first; returns its name, once every
    /// server knows it.
    pub async fn start_worker(&mut self, first: usize) -> String {
        let known = self.names(first).await;
        // With one server there is no choice; the other servers are given as alternatives to it.
        let mut urls: Vec<String> = vec![self.url(first)];
        urls.extend((0..self.servers.len()).filter(|s| *s != first).map(|s| self.url(s)));
        loop {
            let mut command = bendtwin();
            command.args(["worker", "--server", &urls.join(",")]);
            command.env("BENDTWIN_WORKER_TOKEN", TOKEN);
            let worker = self.processes.start(&mut command, &self.folder.path().join("workers"));
            self.workers.push(worker);
            let name = until("a new worker", START, async || {
                self.names(first).await.into_iter().find(|name| !known.contains(name))
            })
            .await;
            // Chance decides which server is called first.
            if self.log(first).contains(&format!("worker registered worker={name}")) {
                return name;
            }
            let mut worker = self.workers.pop().unwrap();
            terminate(&worker);
            worker.wait().unwrap();
            until("its end", START, async || (self.names(first).await == known).then_some(()))
                .await;
        }
    }

    /// Names of the workers that a server knows, in order.
    pub async fn names(&self, server: usize) -> Vec<String> {
        let workers = self.api(server).list_workers().await.unwrap_or_default();
        workers.into_iter().map(|worker| worker.name).collect()
    }

    /// Waits until the newest worker process has ended; true if it says that all is well.
    pub async fn worker_ended(&mut self, deadline: Duration) -> bool {
        let worker = self.workers.last_mut().unwrap();
        until("the end of the worker", deadline, async || worker.try_wait().unwrap())
            .await
            .success()
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        if std::thread::panicking() {
            for number in 0..self.servers.len() {
                let log = self.log(number);
                let tail: Vec<_> = log.lines().rev().take(20).collect();
                eprintln!("the last lines of server {number}:");
                tail.into_iter().rev().for_each(|line| eprintln!("  {line}"));
            }
        }
        let servers = self.servers.iter_mut().map(|server| &mut server.child);
        for child in self.workers.iter_mut().chain(servers) {
            child.kill().ok();
            child.wait().ok();
        }
    }
}

fn terminate(process: &Child) {
    let id = process.id().to_string();
    std::process::Command::new("kill").args(["-TERM", &id]).status().unwrap();
}

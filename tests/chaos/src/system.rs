//! The system under test: one server with its own workers, or a fleet. Faults and checks ask it for
//! processes, clients for an address.

use std::{
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::bail;
use bendtwin_harness::{Api, http::Http, process};
use tokio::{task::JoinSet, time::sleep};

use crate::{
    fleet::Fleet,
    schedule::Victim,
    server::Server,
    supervised::{POLL, START, Supervised},
};

/// A system.
pub(crate) enum System {
    Server(Server),
    Fleet(Fleet),
}

/// A process that a fault is about.
pub(crate) struct Target {
    pub(crate) pid: u32,
    /// Supervisor of the server, if the suite started it.
    pub(crate) supervised: Option<Arc<Supervised>>,
}

impl Target {
    /// kill -9.
    pub(crate) fn kill(&self) {
        match &self.supervised {
            Some(supervised) => supervised.kill(),
            None => process::kill(self.pid),
        }
    }
}

impl System {
    /// `host:port` for clients.
    pub(crate) fn address(&self) -> &str {
        match self {
            Self::Server(server) => server.address(),
            Self::Fleet(fleet) => fleet.address(),
        }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://{}", self.address())
    }

    pub(crate) fn api(&self) -> Api {
        Api::new(self.address())
    }

    pub(crate) fn http(&self) -> Http {
        Http::new(&self.url())
    }

    pub(crate) fn fleet(&self) -> Option<&Fleet> {
        match self {
            Self::Server(_) => None,
            Self::Fleet(fleet) => Some(fleet),
        }
    }

    pub(crate) fn servers(&self) -> Vec<Arc<Supervised>> {
        match self {
            Self::Server(server) => vec![server.supervised.clone()],
            Self::Fleet(fleet) => fleet.servers.clone(),
        }
    }

    /// All processes that are supervised from here.
    fn supervised(&self) -> Vec<Arc<Supervised>> {
        match self {
            Self::Server(_) => self.servers(),
            Self::Fleet(fleet) => fleet.servers.iter().chain(&fleet.workers).cloned().collect(),
        }
    }

    /// The live processes of a kind.
    pub(crate) fn targets(&self, victim: Victim) -> Vec<Target> {
        let ours = |all: &[Arc<Supervised>]| {
            let target = |one: &Arc<Supervised>| {
                Some(Target { pid: one.pid()?, supervised: Some(one.clone()) })
            };
            all.iter().filter_map(target).collect()
        };
        let others =
            |pids: Vec<u32>| pids.into_iter().map(|pid| Target { pid, supervised: None }).collect();
        match (victim, self) {
            (Victim::Server, _) => ours(&self.servers()),
            (Victim::Worker, Self::Fleet(fleet)) => ours(&fleet.workers),
            (Victim::Worker, Self::Server(server)) => others(server.workers()),
            (Victim::Reader, Self::Fleet(fleet)) => others(fleet.readers()),
            (Victim::Reader, Self::Server(server)) => others(server.readers()),
        }
    }

    /// Restarts everything by hand: a client waits for too long.
    pub(crate) fn restart_by_hand(&self, why: &str) {
        self.servers().iter().for_each(|server| server.restart_by_hand(why));
    }

    /// Supervises all processes from now on.
    pub(crate) fn start(&self) -> JoinSet<anyhow::Result<()>> {
        let mut supervisors = JoinSet::new();
        for one in self.supervised() {
            supervisors.spawn_local(one.supervise());
        }
        supervisors
    }

    /// Waits until every server is ready and knows all workers.
    pub(crate) async fn is_whole(&self) -> anyhow::Result<()> {
        let began = Instant::now();
        for server in self.servers() {
            let url = server.url().unwrap_or_default();
            let (http, api) = (Http::new(url), Api::new(url.trim_start_matches("http://")));
            let is_whole = async || {
                let listed = tokio::time::timeout(Duration::from_secs(5), api.list_workers());
                http.is_ready().await
                    && matches!(listed.await, Ok(Ok(workers)) if workers.len() == self.workers())
            };
            while !is_whole().await {
                if began.elapsed() > START {
                    let workers = self.workers();
                    bail!(
                        "{} was not ready with {workers} workers within {START:?}",
                        server.name()
                    );
                }
                sleep(10 * POLL).await;
            }
        }
        Ok(())
    }

    /// Number of workers that it has when it is whole.
    fn workers(&self) -> usize {
        match self {
            Self::Server(_) => Server::WORKERS,
            Self::Fleet(fleet) => fleet.workers.len(),
        }
    }

    /// Ends everything in order, without a restart.
    pub(crate) async fn stop(&self) -> anyhow::Result<()> {
        // Workers first, which report their end to servers.
        for one in self.supervised().iter().rev() {
            one.stop().await?;
        }
        Ok(())
    }

    pub(crate) fn logs(&self) -> Vec<PathBuf> {
        self.supervised().iter().map(|one| one.log_file().to_owned()).collect()
    }

    /// Checks what it left, after its end.
    pub(crate) fn check_remains(&self) -> anyhow::Result<()> {
        match self {
            Self::Server(server) => server.check_store(),
            Self::Fleet(fleet) => fleet.check_leases(),
        }
    }
}

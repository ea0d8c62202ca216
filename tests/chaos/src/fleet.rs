//! Two servers and four workers over one PostgreSQL and one bucket, on two machines that are network
//! namespaces, behind a load balancer.
//!
//! Each of the servers and workers is supervised as a process of systemd or Kubernetes is. PostgreSQL
//! and S3 are on a third machine, and are no part of what is tested: the suite ends, stops and starts
//! them.

mod balancer;
mod history;
pub(crate) mod network;
pub(crate) mod services;

use std::{path::Path, sync::Arc};

use anyhow::Context as _;
use bendtwin_harness::{command::bendtwin, process::Processes};

use self::{balancer::Balancer, network::Network, services::Services};
use crate::{
    clock::Clock,
    server::{SERVER_MIB, WORKERS_MIB},
    supervised::{Excuses, Plan, Supervised},
    tally::Tally,
};

/// Workers on each machine.
const WORKERS: usize = 2;
/// Time after which a silent worker or server loses its jobs [s]: shorter than most pauses and
/// partitions.
pub(crate) const LEASE_S: f64 = 3.0;
const WORKER_TOKEN: &str = "workers-of-the-fleet";
/// Port of a server on its machine.
const PORT: u16 = 7070;

/// A fleet.
pub(crate) struct Fleet {
    pub(crate) servers: Vec<Arc<Supervised>>,
    pub(crate) workers: Vec<Arc<Supervised>>,
    pub(crate) services: Services,
    pub(crate) network: Arc<Network>,
    balancer: Balancer,
    processes: Arc<Processes>,
    tally: Arc<Tally>,
}

impl Fleet {
    /// Number of machines with a server and workers.
    pub(crate) const MACHINES: usize = 2;

    /// Starts the services; servers and workers are not started yet. Each machine has a clock, if there
    /// are any.
    pub(crate) async fn new(
        folder: &Path,
        clocks: &[Clock],
        tally: Arc<Tally>,
        excuses: Excuses,
    ) -> anyhow::Result<Self> {
        let network = Arc::new(Network::new(&tally)?);
        let services = Services::start(folder, &network).await?;
        let processes = Arc::new(Processes::new(folder));
        let mut urls = Vec::new();
        for machine in 0..Self::MACHINES {
            let port = network.free_port(machine, PORT)?;
            urls.push(format!("http://{}:{port}", network.address(machine)));
        }
        let supervised = |machine: usize, name: String, arguments: Vec<String>, url| {
            let (network, clock) = (network.clone(), clocks.get(machine).cloned());
            let (environment, tmp) = (services.environment(), folder.join("tmp"));
            let command = move || {
                let mut command = bendtwin();
                command.args(&arguments).env("TMPDIR", &tmp).envs(environment.iter().cloned());
                command.env("BENDTWIN_WORKER_TOKEN", WORKER_TOKEN);
                if let Some(clock) = &clock {
                    clock.preload(&mut command);
                }
                network.on(machine, &command)
            };
            let log = folder.join(format!("{}.log", name.replace(' ', "-")));
            let plan = Plan { name, command: Box::new(command), log, url };
            Arc::new(Supervised::new(plan, processes.clone(), tally.clone(), excuses.clone()))
        };
        let mut servers = Vec::new();
        for (machine, url) in urls.iter().enumerate() {
            let config = folder.join(format!("server-{machine}.toml"));
            let data = folder.join(format!("data-{machine}"));
            let listen = url.trim_start_matches("http://");
            let text = format!(
                "listen = \"{listen}\"\n\
                 insecure = true\n\
                 client_token = \"none\"\n\
                 data_dir = \"{data}\"\n\
                 lease_s = {LEASE_S:?}\n\
                 heartbeat_interval_s = {heartbeat:?}\n\
                 upload_start_s = 604800.0\n\
                 disk_floor_mib = 32\n\
                 trash_s = 30.0\n\
                 memory_mib = {SERVER_MIB}\n\
                 [workers]\n\
                 count = 0\n",
                data = data.display(),
                heartbeat = LEASE_S / 4.0,
            );
            std::fs::write(&config, text)?;
            let arguments = ["server", "--config", &config.to_string_lossy()].map(str::to_owned);
            let name = format!("server {machine}");
            servers.push(supervised(machine, name, arguments.into(), Some(url.clone())));
        }
        let mut workers = Vec::new();
        for number in 0..Self::MACHINES * WORKERS {
            let machine = number % Self::MACHINES;
            let listen = format!("{}:0", network.address(machine));
            let memory = (WORKERS_MIB as usize / (Self::MACHINES * WORKERS)).to_string();
            let (label, all) = (label(number), urls.join(","));
            let arguments = ["worker", "--backend", "cpu", "--label", &label]
                .into_iter()
                .chain(["--server", &all, "--worker-listen", &listen])
                .chain(["--memory-mib", &memory, "--log", history::LOG])
                .map(str::to_owned);
            workers.push(supervised(
                machine,
                format!("worker {number}"),
                arguments.collect(),
                None,
            ));
        }
        let balancer = Balancer::start(urls).await?;
        Ok(Self { servers, workers, services, network, balancer, processes, tally })
    }

    /// `host:port` of the load balancer.
    pub(crate) fn address(&self) -> &str {
        self.balancer.address()
    }

    /// Ids of the processes that read captures.
    pub(crate) fn readers(&self) -> Vec<u32> {
        self.processes.readers()
    }

    /// The worker with one of these labels.
    pub(crate) fn worker_with(&self, labels: &[String]) -> anyhow::Result<&Arc<Supervised>> {
        let found = (0..self.workers.len()).find(|number| labels.contains(&label(*number)));
        found.map(|number| &self.workers[number]).with_context(|| format!("no {labels:?}"))
    }

    /// Has the database note from now on what is written of jobs.
    pub(crate) fn record(&self) -> anyhow::Result<()> {
        self.services.database(history::RECORD).map(drop)
    }

    /// Compares what the database noted of jobs with what workers did; they have ended.
    pub(crate) fn check_leases(&self) -> anyhow::Result<()> {
        let noted = self.services.database(history::NOTED)?;
        history::check(&noted, &self.workers, &self.tally)
    }
}

fn label(worker: usize) -> String {
    format!("worker-{worker}")
}

//! `bendtwin worker`: the data plane, started by the server or by an operator; and what operators do
//! with the workers of a server.

use std::{net::SocketAddr, path::PathBuf, time::Duration};

use bendtwin_client::WorkerId;
use bendtwin_tls::{MutualPaths, PairPaths};
use bendtwin_worker::{Limits, Options, Sandbox};
use clap::{Args, Subcommand, ValueEnum};

use crate::{
    backend::BackendArgs,
    failure::{self, Usage},
    global::Global,
    output, signals,
    table::Table,
};

/// Time between two checks whether a worker has ended.
const ASK_AGAIN: Duration = Duration::from_millis(200);

/// Options of a worker. The address of the server is `--server`; several, with commas between them,
/// are servers of one database.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Worker {
    #[command(subcommand)]
    command: Option<Command>,
    /// Token of the server for its workers
    #[arg(long, env = "BENDTWIN_WORKER_TOKEN", value_name = "TOKEN", hide_env_values = true)]
    token: Option<String>,
    #[command(flatten)]
    listener: Listener,
    #[command(flatten)]
    backend: BackendArgs,
    /// URL at which the server reaches this worker, where it differs: http://host:port, https:// with
    /// a certificate
    #[arg(long, env = "BENDTWIN_WORKER_ADVERTISE", value_name = "URL")]
    advertise: Option<String>,
    /// Folder for captures while they are read, in a private folder inside it [default: the cache
    /// folder if one is given, else the system's temporary folder; in the data folder for workers
    /// that the server starts]
    #[arg(long, env = "BENDTWIN_SCRATCH_DIR", value_name = "DIR")]
    scratch_dir: Option<PathBuf>,
    /// Folder for compiled kernels [default: the user's cache folder]
    #[arg(long, env = "BENDTWIN_CACHE_DIR", value_name = "DIR")]
    cache_dir: Option<PathBuf>,
    /// Only answer rollouts, lease no jobs
    #[arg(long)]
    no_fits: bool,
    /// Label that fits can require, for example gpu=h100; may be repeated
    #[arg(
        long = "label",
        env = "BENDTWIN_WORKER_LABELS",
        value_name = "WORD",
        value_delimiter = ','
    )]
    labels: Vec<String>,
    /// Memory for rollouts, loaded twins and fits [MiB; default: half of the machine's]
    #[arg(long, env = "BENDTWIN_WORKER_MEMORY_MIB", value_name = "MIB")]
    memory_mib: Option<u64>,
    /// Memory of the process that reads an uploaded capture [MiB]
    #[arg(long, env = "BENDTWIN_INGEST_MEMORY_MIB", value_name = "MIB", default_value_t = mib(Limits::default().ingest_bytes))]
    ingest_memory_mib: u64,
    /// Time limit of that process, plus a second for each MiB of the capture [s]
    #[arg(long, env = "BENDTWIN_INGEST_TIMEOUT_S", value_name = "S", default_value_t = Limits::default().ingest_time.as_secs())]
    ingest_timeout_s: u64,
    /// Time of a second such process for captures that come while another one is being read; those that take
    /// longer wait for the first [s]
    #[arg(long, env = "BENDTWIN_INGEST_BRIEF_S", value_name = "S", default_value_t = Limits::default().brief_time.as_secs())]
    ingest_brief_s: u64,
    /// Confinement of that process: `required` reads nothing on systems without Landlock and
    /// seccomp, `best-effort` uses what the system supports
    #[arg(
        long,
        env = "BENDTWIN_INGEST_SANDBOX",
        value_enum,
        value_name = "DEMAND",
        default_value = "best-effort"
    )]
    ingest_sandbox: SandboxArg,
    /// Memory of one observation in a fit [MiB]
    #[arg(long, env = "BENDTWIN_CAPTURE_MEMORY_MIB", value_name = "MIB", default_value_t = mib(Limits::default().capture_bytes))]
    capture_memory_mib: u64,
    /// Memory of a fit, its capture included [MiB, estimated; default: half of the worker's memory]
    #[arg(long, env = "BENDTWIN_FIT_MEMORY_MIB", value_name = "MIB")]
    fit_memory_mib: Option<u64>,
    /// Smallest share of the device's time for fits while rollouts would use all of it, 0 to 0.9
    #[arg(long, env = "BENDTWIN_FIT_SHARE", value_name = "SHARE", default_value_t = bendtwin_worker::FIT_SHARE)]
    fit_share: f64,
    /// Memory of the loaded twins [MiB, estimated]
    #[arg(long, env = "BENDTWIN_WARM_MEMORY_MIB", value_name = "MIB", default_value_t = mib(Limits::default().warm_bytes))]
    warm_memory_mib: u64,
    /// Exit when the standard input ends: the server that started this worker is gone
    #[arg(long)]
    exit_with_parent: bool,
}

/// The port of a worker.
#[derive(Debug, Args)]
pub(crate) struct Listener {
    /// Certificate of this worker, for a server on another host (https://, --ca): a PEM file,
    /// reloaded when it changes
    #[arg(long, env = "BENDTWIN_WORKER_CERTIFICATE", value_name = "FILE", requires = "key")]
    certificate: Option<PathBuf>,
    /// Key of this certificate: a PEM file that other users cannot read
    #[arg(long, env = "BENDTWIN_WORKER_KEY", value_name = "FILE", requires = "certificate")]
    key: Option<PathBuf>,
    /// List of the certificates that the authority has revoked (`bendtwin ca revoke`), to refuse
    /// servers with such a certificate: a PEM file, reloaded when it changes
    #[arg(long, env = "BENDTWIN_WORKER_CRL", value_name = "FILE", requires = "certificate")]
    crl: Option<PathBuf>,
    /// Address for rollouts; port 0 takes a free one
    #[arg(
        long,
        env = "BENDTWIN_WORKER_LISTEN",
        value_name = "ADDRESS",
        default_value_t = bendtwin_worker::LISTEN
    )]
    pub(crate) worker_listen: SocketAddr,
}

impl Listener {
    /// The files of its TLS, if it has one.
    pub(crate) fn tls(&self, global: &Global) -> Result<Option<MutualPaths>, Usage> {
        let pair = self.certificate.clone().zip(self.key.clone());
        let pair = pair.map(|(certificate, key)| PairPaths { certificate, key });
        match (pair, global.ca.clone()) {
            (Some(pair), Some(ca)) => Ok(Some(MutualPaths { pair, ca, crl: self.crl.clone() })),
            (Some(_), None) => {
                let fault =
                    "--certificate requires --ca, the authority of the server and its workers";
                Err(Usage(fault.to_owned()))
            }
            (None, _) => Ok(None),
        }
    }
}

fn mib(bytes: u64) -> u64 {
    bytes >> 20
}

fn bytes(mib: u64) -> u64 {
    mib.saturating_mul(1 << 20)
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List the workers that the server knows
    List,
    /// Ask workers to take no more work, to hand back their jobs, to finish their rollouts and to
    /// exit
    Drain(Drain),
}

#[derive(Debug, Args)]
struct Drain {
    /// workers/{uuid}
    #[arg(required = true)]
    names: Vec<WorkerId>,
    /// Wait until they have ended
    #[arg(long)]
    wait: bool,
}

/// Demands on the confinement, as users write them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SandboxArg {
    /// Full confinement, or nothing is read
    Required,
    /// As much as the system supports
    BestEffort,
}

impl From<SandboxArg> for Sandbox {
    fn from(demand: SandboxArg) -> Self {
        match demand {
            SandboxArg::Required => Self::Required,
            SandboxArg::BestEffort => Self::BestEffort,
        }
    }
}

/// The parts of the confinement of reading processes that this system lacks, if any.
pub(crate) fn lacking_confinement() -> Option<String> {
    bendtwin_worker::available().lacking()
}

impl Worker {
    /// True if it runs a worker, false for commands about the workers of a server.
    pub(crate) fn is_service(&self) -> bool {
        self.command.is_none()
    }

    fn options(self, global: &Global) -> Result<Options, Usage> {
        let token = self.token.ok_or_else(|| {
            let fault =
                "give the server's token for its workers: --token, or BENDTWIN_WORKER_TOKEN";
            Usage(fault.to_owned())
        })?;
        let defaults = Options::new(&global.server, token);
        let tls = self.listener.tls(global)?;
        let memory_bytes = self.memory_mib.map_or(defaults.memory_bytes, bytes);
        let fit_bytes = self.fit_memory_mib.map_or(memory_bytes / 2, bytes);
        Ok(Options {
            tls,
            memory_bytes,
            backend: self.backend.options(self.cache_dir.as_ref().map(|dir| dir.join("kernels"))),
            listen: self.listener.worker_listen,
            advertise: self.advertise,
            scratch_dir: self.scratch_dir,
            cache_dir: self.cache_dir,
            fits: !self.no_fits,
            labels: self.labels,
            ingest_sandbox: self.ingest_sandbox.into(),
            fit_share: self.fit_share,
            limits: Limits {
                ingest_time: Duration::from_secs(self.ingest_timeout_s),
                brief_time: Duration::from_secs(self.ingest_brief_s),
                ingest_bytes: bytes(self.ingest_memory_mib),
                capture_bytes: bytes(self.capture_memory_mib),
                fit_bytes,
                warm_bytes: bytes(self.warm_memory_mib),
                ..defaults.limits
            },
            ..defaults
        })
    }
}

pub(crate) async fn run(mut args: Worker, global: &Global) -> anyhow::Result<()> {
    match args.command.take() {
        None => {}
        Some(Command::List) => return list(global).await,
        Some(Command::Drain(args)) => return drain(args, global).await,
    }
    let shutdown = signals::shutdown();
    if args.exit_with_parent {
        signals::end_with_parent(shutdown.clone());
    }
    let options = args.options(global)?;
    bendtwin_worker::run(options, shutdown).await.map_err(failure::failed)
}

async fn list(global: &Global) -> anyhow::Result<()> {
    let workers = global.connect().await?.workers().all().await?;
    output::print(global, &workers, || {
        let mut table = Table::new([
            "NAME", "STARTED", "STATE", "BACKEND", "DEVICE", "TWINS", "ROLLOUTS", "OF",
        ]);
        for worker in &workers {
            let job = worker.fit.map(|fit| fit.to_string());
            let job = job.or_else(|| worker.ingest.map(|capture| format!("reads {capture}")));
            let state = if worker.draining { Some("ends".to_owned()) } else { job };
            table.row([
                worker.name.to_string(),
                format!("{:.0}", worker.start_time),
                state.unwrap_or_else(|| "idle".to_owned()),
                worker.backend.clone(),
                worker.device.clone(),
                worker.warm_twins.len().to_string(),
                worker.rollouts_in_flight.to_string(),
                worker.server.clone().unwrap_or_else(|| "all servers".to_owned()),
            ]);
        }
        table.text()
    })
}

async fn drain(args: Drain, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    let mut drained = Vec::new();
    for name in &args.names {
        drained.push(client.workers().drain(*name).await?);
    }
    for name in args.names.iter().filter(|_| args.wait) {
        while client.workers().all().await?.iter().any(|worker| worker.name == *name) {
            tokio::time::sleep(ASK_AGAIN).await;
        }
    }
    let done = if args.wait { "ended" } else { "end, now or after their rollouts" };
    output::print(global, &drained, || format!("{} workers {done}", drained.len()))
}

/// `bendtwin ingest-capture`: the process that a worker starts to read a capture.
#[derive(Debug, Args)]
pub(crate) struct IngestCapture {
    /// The folder that the worker prepared
    folder: PathBuf,
}

pub(crate) fn ingest_capture(args: &IngestCapture) -> anyhow::Result<()> {
    Ok(bendtwin_worker::ingest_capture(&args.folder)?)
}

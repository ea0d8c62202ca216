//! The life of a worker: open the device, register, lease jobs and answer rollouts until asked to
//! end, then hand back what is unfinished.

use std::{
    future::pending,
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use bendtwin_contract::worker_key;
use bendtwin_core::ids::WorkerId;
use bendtwin_fit::OpenRasteriser;
use bendtwin_proto::worker::v1::RegisterRequest;
use bendtwin_rollout::Painter;
use bendtwin_tls::{Mutual, Reloaded};
use tokio::{
    net::TcpListener,
    sync::{mpsc, watch},
    task::JoinHandle,
};
use tokio_util::sync::CancellationToken;
use tonic::transport::server::TcpIncoming;

use crate::{
    Error, Options,
    budget::Memory,
    device::Device,
    fit::Fits,
    ingest::{BriefIngests, Ingests},
    leasing::{self, StopSignals},
    registration::Registration,
    rollout::{self, Replays, Rollouts, WarmTwins},
    scratch::Scratch,
    server_client::ServerClient,
    tls,
};

/// Longest time for rollouts and final reports once the worker has to end.
const SHUTDOWN_GRACE: Duration = Duration::from_secs(15);

/// Longest time for rollouts if a server asked the worker to end: no supervisor waits for it.
const DRAIN_GRACE: Duration = Duration::from_secs(600);
/// Longest time for the last word to a server.
const LEAVE_TIMEOUT: Duration = Duration::from_secs(2);

/// Runs a worker until `shutdown` (jobs under way are handed back with their
/// latest checkpoints, rollouts are finished) or until the server drains it.
///
/// # Errors
/// If the worker cannot start, if the server refuses it, or if a job panicked or the device failed:
/// then the process must end, and a fresh one start.
pub async fn run(options: Options, shutdown: CancellationToken) -> Result<(), Error> {
    options.validate()?;
    let (fatal, mut died) = mpsc::unbounded_channel();
    let device = open_device(&options, fatal.clone()).await?;
    let result = run_on(&device, &options, shutdown, fatal, &mut died).await;
    device.close();
    // A panic that came while the last job ended still makes the exit a failure.
    match (result, died.try_recv()) {
        (Ok(()), Ok(error)) => Err(error),
        (result, _) => result,
    }
}

/// A worker that answers rollouts and leases no jobs yet.
struct ServingWorker {
    id: WorkerId,
    endpoint: String,
    server: ServerClient,
    scratch: Scratch,
    registration: Registration,
    serving: Serving,
}

async fn run_on(
    device: &Device,
    options: &Options,
    shutdown: CancellationToken,
    fatal: mpsc::UnboundedSender<Error>,
    died: &mut mpsc::UnboundedReceiver<Error>,
) -> Result<(), Error> {
    let worker = ServingWorker::new(device, options, &shutdown).await?;
    tokio::select! {
        registered = worker.registration.register(options.delivery_timeout) => registered?,
        () = shutdown.cancelled() => return Ok(()),
    }
    let name = &device.description().name;
    tracing::info!(worker = %worker.id, endpoint = worker.endpoint, device = name, "worker ready");
    // Leasing ends before the job under way does: the job of a worker that must die is not
    // handed back as unharmed, or it would kill one worker after another.
    let stop = StopSignals {
        closed: shutdown.child_token(),
        drained: shutdown.clone(),
        asked: CancellationToken::new(),
    };
    let heartbeat = tokio::spawn(worker.registration.clone().heartbeat(stop.clone()));
    let mut leasing = tokio::spawn(worker.lease(device, options, &stop, fatal));
    let result = tokio::select! {
        ended = &mut leasing => ended.unwrap_or_else(|e| Err(Error::Panicked(e.to_string()))),
        error = died.recv() => error.map_or(Ok(()), Err),
        () = shutdown.cancelled() => Ok(()),
    };
    stop.closed.cancel();
    if options.fits
        && !leasing.is_finished()
        && tokio::time::timeout(SHUTDOWN_GRACE, &mut leasing).await.is_err()
    {
        tracing::warn!("the jobs under way did not end in time: their leases will run out");
    }
    leasing.abort();
    worker.leave(&heartbeat, stop.is_asked()).await;
    result
}

impl ServingWorker {
    /// Reads certificates, makes the folder for captures and answers rollouts.
    async fn new(
        device: &Device,
        options: &Options,
        shutdown: &CancellationToken,
    ) -> Result<Self, Error> {
        let (key, id) = worker_key::generate();
        let limits = options.limits;
        let tls = options.tls.as_ref().map(tls::load).transpose()?;
        if let Some(tls) = &tls {
            tokio::spawn(tls.clone().watch(shutdown.clone()));
        }
        let server = ServerClient::new(&options.servers, &options.token, &key, tls.as_ref())?;
        let base = options.scratch_dir.clone().or_else(|| options.cache_dir.clone());
        let base = base.unwrap_or_else(std::env::temp_dir);
        let scratch = Scratch::new(&base)
            .map_err(|source| Error::System { what: "make a folder for captures", source })?;
        let dir = scratch.path().to_owned();

        let memory = Memory::new(options.memory_bytes);
        let memory_mib = options.memory_bytes >> 20;
        tracing::info!(memory_mib, "memory for rollouts, twins and fits");
        let twins =
            WarmTwins::new(server.clone(), device.clone(), limits, memory.clone(), dir.clone());
        let replays = Replays::new(server.clone(), dir, limits, memory.clone());
        let rollouts = Rollouts::new(
            id.to_string(),
            device.clone(),
            twins,
            replays,
            memory,
            painter(device, options),
            limits.rollouts,
        );
        let (endpoint, serving) = serve(options, rollouts.clone(), tls).await?;
        rollouts.set_fit_bytes(if options.fits { limits.fit_bytes } else { 0 });
        let request = register_request(id, &endpoint, device, &options.labels);
        let registration = Registration::new(server.clone(), request, rollouts);
        Ok(Self { id, endpoint, server, scratch, registration, serving })
    }

    /// Leases jobs until `stop`, if the options say so.
    fn lease(
        &self,
        device: &Device,
        options: &Options,
        stop: &StopSignals,
        fatal: mpsc::UnboundedSender<Error>,
    ) -> impl Future<Output = Result<(), Error>> + Send + use<> {
        let (limits, dir) = (options.limits, self.scratch.path().to_owned());
        let fits = Fits {
            rasteriser: rasteriser(options),
            device: device.clone(),
            dir: dir.clone(),
            limits,
            delivery_timeout: options.delivery_timeout,
            fatal,
        };
        let ingests = Ingests {
            dir,
            program: options.ingest_program.clone().unwrap_or_else(this_program),
            memory_bytes: limits.ingest_bytes,
            time: limits.ingest_time,
            sandbox: options.ingest_sandbox,
            delivery_timeout: options.delivery_timeout,
            taken: watch::Sender::new(false),
        };
        let brief = BriefIngests { first: ingests.clone(), time: limits.brief_time };
        let (leases, stop, registration) = (options.fits, stop.clone(), self.registration.clone());
        async move {
            if !leases {
                return pending().await;
            }
            // Side by side: the report of an uploaded capture should not wait for the fits of others.
            tokio::try_join!(
                leasing::lease(&fits, &registration, &stop),
                leasing::lease(&ingests, &registration, &stop),
                leasing::lease(&brief, &registration, &stop)
            )
            .map(drop)
        }
    }

    /// Finishes the rollouts under way, while heartbeats continue, and tells a server.
    async fn leave(self, heartbeat: &JoinHandle<()>, is_asked: bool) {
        self.serving.stop(if is_asked { DRAIN_GRACE } else { SHUTDOWN_GRACE }).await;
        heartbeat.abort();
        let leave = self.server.leave(self.id.to_string());
        if !matches!(tokio::time::timeout(LEAVE_TIMEOUT, leave).await, Ok(Ok(()))) {
            tracing::info!("no server heard that this worker ends: one will notice");
        }
        tracing::info!("worker ended");
    }
}

/// Opens the rasteriser of Gaussians on the worker's device.
fn rasteriser(options: &Options) -> OpenRasteriser {
    let options = options.backend.clone();
    Arc::new(move || bendtwin_backends::rasteriser(&options).map_err(|e| e.to_string()))
}

/// What pictures of sessions are drawn with: the cores, and a GPU for Gaussians if it is the worker's device.
fn painter(device: &Device, options: &Options) -> Painter {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    Painter::new(cores, (!device.is_processor()).then(|| rasteriser(options)))
}

/// The program of this process, even if its file has been replaced since the start: worker and
/// child are of one build.
fn this_program() -> PathBuf {
    let running = Path::new("/proc/self/exe");
    if cfg!(target_os = "linux") && running.exists() {
        return running.to_owned();
    }
    std::env::current_exe().unwrap_or_else(|_| PathBuf::from("bendtwin"))
}

async fn open_device(
    options: &Options,
    fatal: mpsc::UnboundedSender<Error>,
) -> Result<Device, Error> {
    let backend = options.backend.clone();
    let fit_share = options.fit_share;
    let open = move || Ok(bendtwin_backends::open(&backend)?);
    tokio::task::spawn_blocking(move || Device::spawn(open, fatal, fit_share))
        .await
        .map_err(|e| Error::Panicked(e.to_string()))?
}

fn register_request(
    id: WorkerId,
    endpoint: &str,
    device: &Device,
    labels: &[String],
) -> RegisterRequest {
    let description = device.description();
    RegisterRequest {
        worker: id.to_string(),
        endpoint: endpoint.to_owned(),
        backend: description.kind.clone(),
        device: description.name.clone(),
        build: bendtwin_core::BUILD.to_owned(),
        lanes: u32::try_from(description.lanes).unwrap_or(u32::MAX),
        labels: labels.to_vec(),
    }
}

/// A rollout service under way.
struct Serving {
    stop: CancellationToken,
    task: JoinHandle<()>,
}

/// Binds the address and answers rollouts there. Also returns the endpoint.
async fn serve(
    options: &Options,
    rollouts: Rollouts,
    tls: Option<Reloaded<Mutual>>,
) -> Result<(String, Serving), Error> {
    let failed = |source| Error::Listen { address: options.listen.to_string(), source };
    let listener = TcpListener::bind(options.listen).await.map_err(failed)?;
    let scheme = if tls.is_some() { "https" } else { "http" };
    let endpoint = match &options.advertise {
        Some(endpoint) => endpoint.clone(),
        None => format!("{scheme}://{}", listener.local_addr().map_err(failed)?),
    };
    if let Some(tls) = &tls {
        tls::check_endpoint(&endpoint, tls.get().certificate.as_ref())?;
    }
    let stop = CancellationToken::new();
    let (token, until) = (options.token.clone(), stop.clone());
    let task = tokio::spawn(async move {
        let served = match tls {
            Some(tls) => {
                let incoming = tls::incoming(listener, tls);
                rollout::serve(rollouts, &token, incoming, until).await
            }
            None => {
                // Without TCP_NODELAY small replies wait 40 ms for an acknowledgement.
                let incoming = TcpIncoming::from(listener).with_nodelay(Some(true));
                rollout::serve(rollouts, &token, incoming, until).await
            }
        };
        if let Err(error) = served {
            tracing::error!("the rollout service ended: {error}");
        }
    });
    Ok((endpoint, Serving { stop, task }))
}

impl Serving {
    /// Finishes the rollouts under way, for a limited time.
    async fn stop(mut self, grace: Duration) {
        self.stop.cancel();
        if tokio::time::timeout(grace, &mut self.task).await.is_err() {
            self.task.abort();
        }
    }
}

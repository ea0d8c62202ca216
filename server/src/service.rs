//! The server as a whole: its start and its shutdown.

use std::{net::SocketAddr, time::Duration};

use bendtwin_core::{Category, Problem};
use bendtwin_store::Store;
use tokio::{net::TcpListener, task::JoinHandle};
use tokio_util::sync::CancellationToken;

use crate::{
    app::App,
    client_token::{self, ClientToken},
    grpc,
    http::{self, origin::Hosts, root_service::RootService},
    listen,
    options::{ClientTokenPolicy, Options},
    supervise,
};

/// Reason for which a server did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Some options are not valid.
    #[error("the options are not accepted: {}", .0.join("; "))]
    Options(Vec<String>),
    /// The address is in use, or not an address of this machine.
    #[error("cannot listen on {address}: {source}: choose another address")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's error.
        source: std::io::Error,
    },
    /// The data folder cannot be opened.
    #[error("cannot open the data folder: {0}")]
    Store(#[from] bendtwin_store::Error),
    /// The file of the client token cannot be read or written.
    #[error("cannot keep the client token in {path}: {source}: give the file to this user")]
    ClientToken {
        /// The file.
        path: std::path::PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The server's own program cannot be found to start workers with.
    #[error("cannot find this program to start workers with: {0}: name it in workers.program")]
    Program(std::io::Error),
    /// The descriptors that are compiled in are damaged.
    #[error("descriptors of the API: {0}")]
    Descriptors(String),
    /// The state that the last run left cannot be taken up.
    #[error("cannot recover the state of the last run: {0}")]
    Recovery(String),
}

impl Problem for StartError {
    fn category(&self) -> Category {
        match self {
            Self::Options(_) => Category::InvalidArgument,
            Self::Listen { .. } | Self::ClientToken { .. } | Self::Program(_) => {
                Category::FailedPrecondition
            }
            Self::Store(error) => error.category(),
            Self::Descriptors(_) | Self::Recovery(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Options(_) => "INVALID_OPTIONS",
            Self::Listen { .. } => "CANNOT_LISTEN",
            Self::Store(error) => error.reason(),
            Self::ClientToken { .. } => "CLIENT_TOKEN_FILE",
            Self::Program(_) => "NO_WORKER_PROGRAM",
            Self::Descriptors(_) => "DESCRIPTORS",
            Self::Recovery(_) => "RECOVERY",
        }
    }
}

/// Interval at which expired uploads, and those that a crash left complete, are searched for.
const UPLOAD_SWEEP_INTERVAL: Duration = Duration::from_secs(60);
/// Interval at which unused content is searched for; the store also does so when it opens.
const GARBAGE_COLLECTION_INTERVAL: Duration = Duration::from_secs(3600);

/// A server to be started.
#[derive(Debug)]
pub struct Service;

/// A running server. Dropping it leaves it running; worker processes end with
/// the process in any case.
#[derive(Debug)]
pub struct Handle {
    address: SocketAddr,
    worker_address: SocketAddr,
    client_token: Option<String>,
    grace: Duration,
    app: App,
    /// Cancelled to close the sockets.
    close: CancellationToken,
    /// Cancelled to cut off connections.
    cut: CancellationToken,
    listeners: JoinHandle<()>,
    sweeper: JoinHandle<()>,
    uploads: JoinHandle<()>,
    workers: supervise::Supervisor,
}

impl Service {
    /// Opens the store, listens, takes up the state of the last run, and starts workers.
    ///
    /// # Errors
    /// See [`StartError`].
    pub async fn start(options: Options) -> Result<Handle, StartError> {
        options.validate().map_err(StartError::Options)?;
        let store = Store::open(bendtwin_store::Options::new(&options.data_dir)).await?;
        let (socket, address) = bind(options.listen).await?;
        let (worker_socket, worker_address) = bind(options.worker_listen).await?;
        let client_token = match options.client_token {
            ClientTokenPolicy::Required => Some(load_token(&options)?),
            ClientTokenPolicy::None => None,
        };
        if !address.ip().is_loopback() && client_token.is_none() {
            tracing::warn!(%address, "everyone who reaches this address may use the API");
        }
        let (grace, hosts) = (options.shutdown_grace(), Hosts::new(&options.allowed_hosts));
        let app = App::new(options, store);
        app.recover().await.map_err(|e| StartError::Recovery(e.to_string()))?;
        let root_service = RootService {
            http: http::router(&app),
            grpc: grpc::router(&app).await?,
            metrics: app.metrics.clone(),
            methods: grpc::methods()?.into(),
            hosts,
            token: client_token.as_deref().map(ClientToken::new),
        };
        let for_workers = RootService {
            http: http::operations_router(&app),
            grpc: grpc::worker_router(&app).await,
            ..root_service.clone()
        };
        let (close, cut) = (CancellationToken::new(), CancellationToken::new());
        let serve = |socket, service, bounds| {
            listen::serve(socket, service, bounds, app.metrics.clone(), close.clone(), cut.clone())
        };
        let public = serve(socket, root_service, listen::Bounds::public(&app.options));
        let workers = serve(worker_socket, for_workers, listen::Bounds::workers(&app.options));
        let listeners = tokio::spawn(async {
            tokio::join!(public, workers);
        });
        let sweeper = tokio::spawn(sweep(app.clone()));
        let uploads = tokio::spawn(sweep_uploads(app.clone()));
        let workers = supervise::start(&app, worker_address)?;
        tracing::info!(%address, %worker_address, "listening");
        Ok(Handle {
            address,
            worker_address,
            client_token,
            grace,
            app,
            close,
            cut,
            listeners,
            sweeper,
            uploads,
            workers,
        })
    }
}

async fn bind(address: SocketAddr) -> Result<(TcpListener, SocketAddr), StartError> {
    let cannot_listen = |source| StartError::Listen { address, source };
    let socket = TcpListener::bind(address).await.map_err(cannot_listen)?;
    let address = socket.local_addr().map_err(cannot_listen)?;
    Ok((socket, address))
}

fn load_token(options: &Options) -> Result<String, StartError> {
    client_token::load(&options.data_dir).map_err(|source| StartError::ClientToken {
        path: client_token::path(&options.data_dir),
        source,
    })
}

impl Handle {
    /// Address on which it listens, with the actual port where port 0 was asked for.
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// Address on which workers reach it.
    pub fn worker_addr(&self) -> SocketAddr {
        self.worker_address
    }

    /// The token that clients have to show, if any.
    pub fn client_token(&self) -> Option<&str> {
        self.client_token.as_deref()
    }

    /// Shuts down in order: workers give their jobs back and end, streams end, requests under way
    /// finish within the grace period, the store closes.
    pub async fn shutdown(self) {
        tracing::info!("stopping");
        self.app.stopping.cancel();
        // Workers need their socket to give their jobs back.
        self.workers.stop(self.grace).await;
        self.close.cancel();
        let mut listeners = self.listeners;
        if tokio::time::timeout(self.grace, &mut listeners).await.is_err() {
            tracing::warn!("requests under way are cut off");
            self.cut.cancel();
            // They end as soon as their connections have.
            let _ = listeners.await;
        }
        self.sweeper.abort();
        self.uploads.abort();
        self.app.store.close().await;
        tracing::info!("stopped");
    }
}

/// Ends leases that have run out, and forgets workers that fell silent.
async fn sweep(app: App) {
    let every = (app.options.lease() / 10).clamp(Duration::from_millis(20), Duration::from_secs(1));
    // Leases that ran out while the server was down: their workers first get a chance to report.
    let first = tokio::time::Instant::now() + 2 * app.options.heartbeat_interval();
    let mut tick = tokio::time::interval_at(first, every);
    let mut collected = tokio::time::Instant::now();
    tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    loop {
        tick.tick().await;
        if let Err(error) = app.sweep().await {
            tracing::error!(%error, "sweeping failed; trying again");
        }
        if collected.elapsed() >= GARBAGE_COLLECTION_INTERVAL {
            collected = tokio::time::Instant::now();
            if let Err(error) = app.store.collect_garbage().await {
                tracing::error!(%error, "cannot remove unused content; trying again");
            }
        }
    }
}

/// Finishes uploads that a crash left complete, and ends expired ones, at once and then at
/// intervals.
async fn sweep_uploads(app: App) {
    let every = UPLOAD_SWEEP_INTERVAL.min(app.options.upload_expiry());
    let mut tick = tokio::time::interval(every);
    tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    loop {
        tick.tick().await;
        if let Err(error) = app.sweep_uploads().await {
            tracing::error!(%error, "sweeping uploads failed; trying again");
        }
    }
}

//! The server as a whole: its start and its shutdown.

use std::{net::SocketAddr, path::PathBuf, sync::Arc, time::Duration};

use bendtwin_core::Problem;
use bendtwin_store::Store;
use bendtwin_tls::FileError;
use tokio::{net::TcpListener, task::JoinHandle, time::Instant};
use tokio_util::sync::CancellationToken;

use crate::{
    access::client_token,
    app::{App, Sweeps},
    grpc,
    http::{
        self,
        origin::Hosts,
        root_service::{RootService, Transport},
    },
    listen::{self, Bounds},
    metrics::Metrics,
    options::{ClientTokenPolicy, Options},
    sign_in::SignIn,
    supervise,
    tls::Certificates,
};

/// Reason for which a server did not start.
#[derive(Debug, thiserror::Error, Problem)]
pub enum StartError {
    /// Some options are not valid.
    #[error("the options are not accepted: {}", .0.join("; "))]
    #[problem(InvalidArgument, "INVALID_OPTIONS")]
    Options(Vec<String>),
    /// The address is in use, or not an address of this machine.
    #[error(
        "cannot listen on {address}: {source}: choose another address with --listen, or stop the \
         program that listens there"
    )]
    #[problem(FailedPrecondition, "CANNOT_LISTEN")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's error.
        source: std::io::Error,
    },
    /// The data folder cannot be opened.
    #[error("cannot open the data folder {}: {source}", folder.display())]
    #[problem(transparent)]
    Store {
        /// The folder.
        folder: PathBuf,
        /// The fault of the store.
        source: bendtwin_store::Error,
    },
    /// The file of the client token cannot be read or written.
    #[error("cannot keep the client token in {path}: {source}: give the file to this user")]
    #[problem(FailedPrecondition, "CLIENT_TOKEN_FILE")]
    ClientToken {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file with the token of a fleet has none.
    #[error(
        "no client token in {path} ({fault}): write at least 32 printable characters without spaces \
         into it"
    )]
    #[problem(FailedPrecondition, "CLIENT_TOKEN_FILE")]
    NoClientToken {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: String,
    },
    /// The files of a certificate or its key cannot be used.
    #[error("no TLS: {0}")]
    #[problem(transparent)]
    Certificate(#[from] FileError),
    /// The file with the secret of the sign-in cannot be read.
    #[error("cannot read the client secret of sign_in in {}: {source}", path.display())]
    #[problem(FailedPrecondition, "CLIENT_SECRET_FILE")]
    ClientSecret {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The program of the workers cannot be started.
    #[error("cannot start workers with {program}: {fault}: name their program in workers.program")]
    #[problem(FailedPrecondition, "NO_WORKER_PROGRAM")]
    Program {
        /// The program.
        program: String,
        /// The reason.
        fault: String,
    },
    /// The descriptors that are compiled in are damaged.
    #[error("descriptors of the API: {0}")]
    #[problem(Internal, "DESCRIPTORS")]
    Descriptors(String),
    /// The state that the last run left cannot be taken up.
    #[error("cannot recover the state of the last run: {0}")]
    #[problem(Internal, "RECOVERY")]
    Recovery(String),
}

/// Time for answers under way after the workers have ended, even if those took the whole grace
/// period.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// A server to be started.
#[derive(Debug)]
pub struct Service;

/// A running server. Dropping it leaves it running; worker processes end with
/// the process in any case.
#[derive(Debug)]
pub struct Handle {
    address: SocketAddr,
    worker_address: SocketAddr,
    worker_tls_address: Option<SocketAddr>,
    client_token: Option<String>,
    grace: Duration,
    app: App,
    /// Cancelled to close the socket of clients.
    close: CancellationToken,
    /// Cancelled to close the socket of workers.
    close_workers: CancellationToken,
    /// Cancelled to cut off connections.
    cut: CancellationToken,
    listeners: Vec<JoinHandle<()>>,
    sweeps: Sweeps,
    workers: supervise::Supervisor,
}

impl Service {
    /// Opens the store, listens, takes up the state of the last run, and starts workers.
    ///
    /// # Errors
    /// See [`StartError`].
    pub async fn start(options: Options) -> Result<Handle, StartError> {
        options.validate().map_err(StartError::Options)?;
        let program = supervise::program(&options.workers)?;
        // First of all: a server that cannot listen leaves no folder behind.
        let certificates = Certificates::load(&options)?;
        let sign_in = options.sign_in.as_ref().map(SignIn::load).transpose()?;
        let (socket, address) = bind(options.listen).await?;
        let (worker_socket, worker_address) = bind(options.worker_listen).await?;
        let worker_tls = match &options.worker_tls {
            Some(tls) => Some(bind(tls.listen).await?),
            None => None,
        };
        let worker_tls_address = worker_tls.as_ref().map(|(_, address)| *address);
        let metrics = Metrics::new();
        let store = open_store(&options, &metrics).await?;
        let client_token = match options.client_token {
            ClientTokenPolicy::Required => Some(load_token(&options)?),
            ClientTokenPolicy::None => None,
        };
        warn_of_openness(&options, address, worker_address);
        let (grace, hosts) = (options.shutdown_grace(), Hosts::new(&options.allowed_hosts));
        let memory_mib = options.memory_bytes() >> 20;
        let worker_memory_mib = options.workers.each_memory_mib();
        tracing::info!(memory_mib, worker_memory_mib, "memory for requests, and of each worker");
        let app = App::new(options, store, certificates.clone(), metrics.clone(), sign_in);
        app.recover().await.map_err(|e| StartError::Recovery(e.to_string()))?;
        let grpc = grpc::router(&app).await?;
        let root_service = RootService {
            http: http::router(&app, &grpc),
            grpc,
            metrics: metrics.clone(),
            methods: grpc::methods()?.into(),
            hosts,
            gate: app.gate(client_token.as_deref()),
            transport: Transport::default(),
        };
        let for_workers = RootService {
            http: http::operations_router(&app),
            grpc: grpc::worker_router(&app),
            ..root_service.clone()
        };
        let (close, close_workers) = (CancellationToken::new(), CancellationToken::new());
        let cut = CancellationToken::new();
        let serve = |socket, service, bounds, tls, close: &CancellationToken| {
            let (close, cut) = (close.clone(), cut.clone());
            let metrics = metrics.clone();
            tokio::spawn(listen::serve(socket, service, bounds, tls, metrics, close, cut))
        };
        let bounds = |name| Bounds::workers(app.options(), name);
        let (public, to_close) = (Bounds::public(app.options()), &close_workers);
        let mut listeners = vec![
            serve(socket, root_service, public, certificates.public(), &close),
            serve(worker_socket, for_workers.clone(), bounds("workers"), None, to_close),
        ];
        if let Some((socket, _)) = worker_tls {
            let tls = certificates.workers();
            listeners.push(serve(socket, for_workers, bounds("workers_tls"), tls, to_close));
        }
        let sweeps = Sweeps::start(&app);
        let workers = supervise::start(&app, program, worker_address);
        tracing::info!(%address, %worker_address, ?worker_tls_address, "listening");
        Ok(Handle {
            address,
            worker_address,
            worker_tls_address,
            client_token,
            grace,
            app,
            close,
            close_workers,
            cut,
            listeners,
            sweeps,
            workers,
        })
    }
}

/// Says in the log what a server on a network trusts.
fn warn_of_openness(options: &Options, address: SocketAddr, worker_address: SocketAddr) {
    let with_tls = |a: &SocketAddr| *a == address && options.tls.is_some();
    let open = [address, worker_address].into_iter().filter(|a| !a.ip().is_loopback());
    for address in open.filter(|a| !with_tls(a)) {
        if options.insecure {
            tracing::warn!(%address, "insecure: there is no TLS, and everyone on the way can read");
        } else if options.is_published_locally() {
            tracing::info!(%address, "the port is trusted to be published to this machine alone");
        } else {
            tracing::warn!(%address, "a proxy is trusted to have the TLS in front of this address");
        }
    }
    if !address.ip().is_loopback() && options.client_token == ClientTokenPolicy::None {
        tracing::warn!(%address, "insecure: everyone who reaches this address may use the API");
    }
}

async fn open_store(options: &Options, metrics: &Metrics) -> Result<Store, StartError> {
    let folder = options.data_dir.clone();
    let database = options.database_url.clone();
    let objects = options.objects_url.clone();
    let of_store = bendtwin_store::Options {
        database,
        objects,
        observer: Some(Arc::new(metrics.clone())),
        ..bendtwin_store::Options::new(&folder)
    };
    Store::open(of_store).await.map_err(|source| StartError::Store { folder, source })
}

async fn bind(address: SocketAddr) -> Result<(TcpListener, SocketAddr), StartError> {
    let cannot_listen = |source| StartError::Listen { address, source };
    let socket = TcpListener::bind(address).await.map_err(cannot_listen)?;
    let address = socket.local_addr().map_err(cannot_listen)?;
    Ok((socket, address))
}

fn load_token(options: &Options) -> Result<String, StartError> {
    if let Some(path) = &options.client_token_file {
        return client_token::read(path)
            .map_err(|fault| StartError::NoClientToken { path: path.clone(), fault });
    }
    client_token::load(&options.data_dir)
        .map_err(|source| StartError::ClientToken { path: options.client_token_path(), source })
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

    /// Address on which workers of other hosts reach it, if there is one.
    pub fn worker_tls_addr(&self) -> Option<SocketAddr> {
        self.worker_tls_address
    }

    /// The token that clients have to show, if any.
    pub fn client_token(&self) -> Option<&str> {
        self.client_token.as_deref()
    }

    /// Shuts down in order: workers give their jobs back and end, streams end, requests under way
    /// finish within the grace period, the store closes.
    pub async fn shutdown(self) {
        tracing::info!("stopping");
        let ends = Instant::now() + self.grace;
        // Silent connections are not waited for, but workers need their socket to hand jobs back.
        self.close.cancel();
        self.app.stop(self.grace.min(LAST_WORDS)).await;
        self.workers.stop(self.grace).await;
        self.close_workers.cancel();
        let last = ends.max(Instant::now() + self.grace.min(LAST_WORDS));
        let mut listeners = futures::future::join_all(self.listeners);
        if tokio::time::timeout_at(last, &mut listeners).await.is_err() {
            tracing::warn!("requests under way are cut off");
            self.cut.cancel();
            // They end as soon as their connections have.
            let _ = listeners.await;
        }
        self.sweeps.stop();
        self.app.close().await;
        tracing::info!("stopped");
    }
}

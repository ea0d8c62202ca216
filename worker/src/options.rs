//! Options of a worker.

use std::{
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::PathBuf,
    time::Duration,
};

use bendtwin_backends as backends;
use bendtwin_tls::MutualPaths;

use crate::{
    Error,
    ingest::{Sandbox, available},
};

/// Approximate memory of the process that reads a capture before it has read anything [bytes].
pub(crate) const LEAST_INGEST_BYTES: u64 = 64 << 20;

/// Least memory of a worker [bytes].
const LEAST_BYTES: u64 = 128 << 20;

/// Default of [`Options::fit_share`].
pub const FIT_SHARE: f64 = 0.25;

/// Default of [`Options::listen`].
pub const LISTEN: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// Options of a worker process.
#[derive(Clone)]
pub struct Options {
    /// Addresses of the servers, for example `http://127.0.0.1:7070`: one of them is called until it
    /// is gone, then the next.
    pub servers: Vec<String>,
    /// The token that server and workers share.
    pub token: String,
    /// Backend and device to compute on.
    pub backend: backends::Options,
    /// Address at which rollouts are answered; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Files of its certificate, for a server that it reaches over TLS and for its own port.
    pub tls: Option<MutualPaths>,
    /// URL `http://host:port` (`https://` with a certificate) at which the server reaches `listen`, where that differs (in a
    /// container, for example).
    pub advertise: Option<String>,
    /// Folder for captures while they are read; a private folder is made in it. The cache folder if
    /// none, and without one the system's temporary folder.
    pub scratch_dir: Option<PathBuf>,
    /// Folder for content that a later start can use.
    pub cache_dir: Option<PathBuf>,
    /// Least share of the device's time that fits get while rollouts want all of it.
    pub fit_share: f64,
    /// True to lease jobs, false to answer rollouts only.
    pub fits: bool,
    /// Words that fits can ask for.
    pub labels: Vec<String>,
    /// The program whose hidden command `ingest-capture` reads captures; this very program if none.
    pub ingest_program: Option<PathBuf>,
    /// Demand on the confinement of the process that reads captures.
    pub ingest_sandbox: Sandbox,
    /// Memory for rollouts, loaded twins and fits [bytes].
    pub memory_bytes: u64,
    /// Bounds on the work of one worker.
    pub limits: Limits,
    /// Time for which a finished result is kept while the server cannot be reached.
    pub delivery_timeout: Duration,
}

impl std::fmt::Debug for Options {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("servers", &self.servers)
            .field("backend", &self.backend)
            .field("listen", &self.listen)
            .field("limits", &self.limits)
            .finish_non_exhaustive()
    }
}

/// Bounds on the work of one worker; what exceeds them is refused with RESOURCE_EXHAUSTED before
/// anything is allocated. Bounds on rollout requests are the server's, which sends them to the
/// worker when it registers ([`bendtwin_contract::rollout::Limits`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Memory of the process that reads a capture [bytes].
    pub ingest_bytes: u64,
    /// Time of that process; it gets another second for each MiB of the archive.
    pub ingest_time: Duration,
    /// Time of a second such process, which reads captures while another one is being read; those that take
    /// longer wait for the first.
    pub brief_time: Duration,
    /// Memory that one observation may take when read [bytes].
    pub capture_bytes: u64,
    /// Memory that a fit may take, its capture included [bytes, estimated].
    pub fit_bytes: u64,
    /// Size of a twin file [bytes].
    pub twin_bytes: u64,
    /// Memory of all loaded twins [bytes, estimated].
    pub warm_bytes: u64,
    /// Loaded twins.
    pub warm_twins: usize,
    /// Rollout requests in flight.
    pub rollouts: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            ingest_bytes: 1500 << 20,
            ingest_time: Duration::from_secs(600),
            brief_time: Duration::from_secs(4),
            capture_bytes: 2 << 30,
            fit_bytes: crate::budget::default_bytes() / 2,
            twin_bytes: 512 << 20,
            warm_bytes: 1 << 30,
            warm_twins: 32,
            rollouts: 64,
        }
    }
}

impl Options {
    /// Options for servers, with commas between their addresses; everything else at its default.
    pub fn new(servers: &str, token: impl Into<String>) -> Self {
        let servers = servers.split(',').map(str::trim).filter(|server| !server.is_empty());
        Self {
            servers: servers.map(str::to_owned).collect(),
            token: token.into(),
            backend: backends::Options::default(),
            listen: LISTEN,
            tls: None,
            advertise: None,
            scratch_dir: None,
            cache_dir: None,
            fit_share: FIT_SHARE,
            fits: true,
            labels: Vec::new(),
            ingest_program: None,
            ingest_sandbox: Sandbox::default(),
            memory_bytes: crate::budget::default_bytes(),
            limits: Limits::default(),
            delivery_timeout: Duration::from_secs(600),
        }
    }

    /// Checks what can be checked without starting.
    ///
    /// # Errors
    /// If an option cannot work.
    pub fn validate(&self) -> Result<(), Error> {
        let fault = if self.servers.is_empty() {
            Some("there is no server: give its address with --server".to_owned())
        } else if self.token.is_empty() {
            Some("the worker token is empty: give the server's (BENDTWIN_WORKER_TOKEN)".to_owned())
        } else if !self.token.bytes().all(|b| b.is_ascii_graphic()) {
            Some("the worker token has characters that a header cannot carry".to_owned())
        } else if let Some(fault) = self.tls_fault() {
            Some(fault)
        } else if self.listen.ip().is_unspecified() && self.advertise.is_none() {
            Some(format!(
                "listening on {} needs --advertise {}://host:port, so that the server can reach this worker",
                self.listen,
                if self.tls.is_some() { "https" } else { "http" }
            ))
        } else if self.memory_bytes < LEAST_BYTES {
            let least = LEAST_BYTES >> 20;
            Some(format!("--memory-mib is too little for anything: give at least {least}"))
        } else if self.limits.ingest_bytes < LEAST_INGEST_BYTES {
            let least = LEAST_INGEST_BYTES >> 20;
            Some(format!("--ingest-memory-mib is too little for anything: give at least {least}"))
        } else if self.limits.ingest_time.is_zero() {
            Some("--ingest-timeout-s is 0: give at least 1".to_owned())
        } else if self.limits.brief_time.is_zero() {
            Some("--ingest-brief-s is 0: give at least 1".to_owned())
        } else if self.ingest_sandbox == Sandbox::Required && !available().suffices() {
            let lacking = available().lacking().unwrap_or_default();
            Some(format!(
                "this system does not confine the process that reads captures ({lacking}): use a kernel with Landlock \
                 and seccomp, or --ingest-sandbox best-effort"
            ))
        } else if !(0.0..=0.9).contains(&self.fit_share) {
            Some(format!("--fit-share is {}: it must lie in 0..=0.9", self.fit_share))
        } else {
            None
        };
        fault.map_or(Ok(()), |m| Err(Error::Options(m)))
    }

    /// The fault of certificates that do not go with the addresses.
    fn tls_fault(&self) -> Option<String> {
        let is_https = |url: &str| url.starts_with("https://");
        let other = self.servers.iter().find(|url| is_https(url) != self.tls.is_some());
        match (&self.tls, other) {
            (None, Some(server)) => Some(format!(
                "{server} takes a certificate of this worker: give --ca, --certificate and --key \
                 (`bendtwin ca issue --role worker`)"
            )),
            (Some(_), Some(server)) => Some(format!(
                "a worker with a certificate talks to its servers over TLS: use https:// instead of \
                 {server}"
            )),
            (Some(_), None) if self.advertise.as_deref().is_some_and(|url| !is_https(url)) => Some(
                "a worker with a certificate answers over TLS: --advertise https://host:port"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

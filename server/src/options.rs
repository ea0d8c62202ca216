//! Options of a server. Every field has a default, unknown fields are refused, and
//! [`Options::validate`] reports all faults together.

mod public;
mod queue;
mod retention;
mod sign_in;
mod tls;

use std::{net::SocketAddr, path::PathBuf, time::Duration};

use bendtwin_contract::rollout;
use bendtwin_store::{DatabaseUrl, NewRule, ObjectsUrl, Quotas};
use serde::{Deserialize, Serialize};

use crate::{access::client_token, listen::Timeouts};
pub use queue::Queue;
pub use retention::RetentionRule;
pub use sign_in::SignIn;
pub(crate) use sign_in::{is_local, is_protected};
pub use tls::{Tls, WorkerTls};

const MIB: u64 = 1 << 20;

/// Backends that workers can use.
const BACKENDS: [&str; 3] = ["auto", "cpu", "cuda"];

/// Options of a server.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Address for HTTP and gRPC; port 0 takes a free one. One that is not loopback takes `tls`,
    /// `tls_terminated_by_proxy`, `published_locally` or `insecure`.
    pub listen: SocketAddr,
    /// Address at which clients reach the server, without a path, where it differs from `listen`;
    /// without one it is that of `sign_in`.
    pub public_url: Option<String>,
    /// Address for workers alone, with `/healthz`, `/readyz` and `/metrics`; port 0 takes a free
    /// one. The server's own workers use it, so that clients cannot take their connections.
    pub worker_listen: SocketAddr,
    /// Names by which clients may call the server, beside `localhost` and addresses; `*` allows
    /// all.
    pub allowed_hosts: Vec<String>,
    /// Token that clients have to show.
    pub client_token: ClientTokenPolicy,
    /// File with the token of clients, which several servers may have; without one each has its own in
    /// its data folder.
    pub client_token_file: Option<PathBuf>,
    /// Certificate that clients are shown; without one there is no TLS.
    pub tls: Option<Tls>,
    /// Listener for workers on other hosts; with it the address for clients takes no workers.
    pub worker_tls: Option<WorkerTls>,
    /// Sign-in of people with an identity provider; without one there are keys and the token alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign_in: Option<SignIn>,
    /// True if a proxy in front has the TLS, so that the server may listen on an address that is
    /// not loopback.
    pub tls_terminated_by_proxy: bool,
    /// True if the address is that of a container, whose port is published to the machine that it
    /// runs on and to no other. Without effect where one of the settings above, or `insecure`, says
    /// what protects the address.
    pub published_locally: bool,
    /// True if the server may listen on an address that is not loopback without TLS, and without a
    /// token: everyone on the way reads and changes what passes.
    pub insecure: bool,
    /// The folder of the database and the blobs; made if missing.
    pub data_dir: PathBuf,
    /// URL of the PostgreSQL database that has the rows; without one they are in SQLite in the data
    /// folder.
    pub database_url: Option<DatabaseUrl>,
    /// Place of all content, a bucket (`s3://bucket/prefix`) or a folder (`file:///folder`) that several
    /// servers may share; without one it is in the data folder.
    pub objects_url: Option<ObjectsUrl>,
    /// The token of workers that others start; without one, only the server's own workers may
    /// connect.
    pub worker_token: Option<String>,
    /// The server's own worker processes.
    pub workers: WorkerPolicy,
    /// Memory that requests under way may take together [MiB]; without it an eighth of the machine's
    /// (or the container's), at least 128 and at most 2048.
    pub memory_mib: Option<u64>,
    /// Shares of owners in the queue.
    pub queue: Queue,
    /// Bounds on one request.
    pub limits: Limits,
    /// Bounds on owners whose keys state none.
    pub quotas: DefaultQuotas,
    /// Time for which a worker keeps a job without reporting [s].
    pub lease_s: f64,
    /// Interval at which workers send heartbeats [s].
    #[serde(alias = "beat_interval_s")]
    pub heartbeat_interval_s: f64,
    /// Time for which a resumable upload is kept without further bytes, and remembered after its
    /// end [s].
    pub upload_expiry_s: f64,
    /// Time limit while hardly anything has arrived: less than a megabyte [s].
    pub upload_start_s: f64,
    /// Free space of the disk below which new captures, twins and fits are refused [MiB].
    pub disk_floor_mib: u64,
    /// Time for which what was deleted can be restored [s]; 0 deletes for good.
    pub trash_s: f64,
    /// Rules by which captures, fits and twins are moved to the trash.
    pub retention: Vec<RetentionRule>,
    /// Interval at which these rules, and those of the API, are applied [s].
    pub retention_interval_s: f64,
    /// Longest wait of a shutdown for requests and workers to end [s].
    pub shutdown_grace_s: f64,
}

/// Token that clients have to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClientTokenPolicy {
    /// The one in the file `client-token` of the data folder, made at the first start.
    Required,
    /// No token: everyone who reaches the server may use it.
    None,
}

/// Worker processes that the server starts and restarts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WorkerPolicy {
    /// Number of workers; 0 leaves it to others to start workers.
    pub count: u32,
    /// The program; this very program if none.
    pub program: Option<PathBuf>,
    /// Arguments of the program.
    pub args: Vec<String>,
    /// Variables of their environment, for example how this process logs.
    #[serde(skip)]
    pub environment: Vec<(String, String)>,
    /// Memory of the workers together [MiB]; without it half of the machine's (or the container's).
    /// Passed in their environment, so that `args` take precedence.
    pub memory_mib: Option<u64>,
    /// Backend of the workers: `auto`, `cpu` or `cuda`. Passed in their environment, so that `args`
    /// take precedence; the same holds for `devices`.
    pub backend: String,
    /// CUDA devices by number, assigned to the workers in turn. If empty, every worker takes device
    /// 0.
    pub devices: Vec<u32>,
    /// Wait before the first restart [s]; it doubles up to `max_backoff_s`.
    pub min_backoff_s: f64,
    /// Longest wait before a restart [s].
    pub max_backoff_s: f64,
}

/// Quotas of keys that state none, each without a bound unless it is given. The client token has no
/// quotas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DefaultQuotas {
    /// Fits and ingests that wait for a worker.
    pub queued_jobs: Option<u64>,
    /// Size of everything that is stored for the owner [bytes].
    pub stored_bytes: Option<u64>,
    /// Rollouts, plans, registrations and evaluations in progress at one server.
    pub rollouts: Option<u64>,
    /// Fits and ingests that run at workers, at least 1; further ones stay queued.
    pub running_jobs: Option<u64>,
}

impl DefaultQuotas {
    pub(crate) fn to_store(self) -> Quotas {
        let Self { queued_jobs, stored_bytes, rollouts, running_jobs } = self;
        Quotas { queued_jobs, stored_bytes, rollouts, running_jobs, ..Quotas::default() }
    }
}

/// Bounds on what one request may ask.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Size of a capture archive [bytes].
    pub capture_bytes: u64,
    /// Size of a twin file [bytes].
    pub twin_bytes: u64,
    /// Size of a checkpoint [bytes].
    pub checkpoint_bytes: u64,
    /// Size of the report of a capture, as a document and as a page each [bytes].
    pub report_bytes: u64,
    /// Size of a JSON body other than a rollout's [bytes].
    pub json_bytes: usize,
    /// Bounds on what one rollout request may ask for. Workers receive them when they register.
    pub rollout: rollout::Limits,
    /// Rollouts under way at one worker; large ones take a quarter of them at most.
    pub rollouts_per_worker: usize,
    /// Rollouts waiting for one worker; more are refused with the time that the work ahead takes
    /// as retry delay.
    pub rollout_queue: usize,
    /// Open connections of clients; further ones take the place of the longest idle, or are
    /// closed. Fewer where the process may open few files.
    pub connections: usize,
    /// Connections of one peer, among them.
    pub connections_per_peer: usize,
    /// Longest time for the head of a request on a connection without another one [s].
    pub head_timeout_s: f64,
    /// Time after which a response of which nothing is read is cut off [s].
    pub stream_idle_s: f64,
    /// Age from which a connection takes no further requests, give or take a tenth: requests under
    /// way are finished, and the client connects again, perhaps to another server behind a load
    /// balancer [s].
    pub connection_age_s: f64,
    /// Silence after which the request of an upload is given up [s]. Other bodies have a second
    /// more, and all of them have to come at 1 KiB/s on average beyond that.
    pub upload_idle_s: f64,
    /// Uploads under way that can be resumed.
    pub uploads: u64,
    /// Disk space reserved for them together, which grows with the bytes of each that have arrived
    /// [bytes].
    pub uploads_bytes: u64,
    /// Plays under way, each a session at a worker that is advanced in real time.
    pub plays: usize,
    /// Browsers that watch one play.
    pub play_watchers: usize,
    /// Time after which an unused play ends [s].
    pub play_idle_s: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 7070)),
            public_url: None,
            worker_listen: SocketAddr::from(([127, 0, 0, 1], 0)),
            allowed_hosts: Vec::new(),
            client_token: ClientTokenPolicy::Required,
            client_token_file: None,
            tls: None,
            worker_tls: None,
            sign_in: None,
            tls_terminated_by_proxy: false,
            published_locally: false,
            insecure: false,
            data_dir: PathBuf::from("bendtwin-data"),
            database_url: None,
            objects_url: None,
            worker_token: None,
            workers: WorkerPolicy::default(),
            memory_mib: None,
            queue: Queue::default(),
            limits: Limits::default(),
            quotas: DefaultQuotas::default(),
            lease_s: 30.0,
            heartbeat_interval_s: 5.0,
            upload_expiry_s: 7.0 * 86_400.0,
            upload_start_s: 600.0,
            disk_floor_mib: 256,
            trash_s: 7.0 * 86_400.0,
            retention: Vec::new(),
            retention_interval_s: 3_600.0,
            shutdown_grace_s: 10.0,
        }
    }
}

impl Default for WorkerPolicy {
    fn default() -> Self {
        Self {
            count: 1,
            program: None,
            args: vec!["worker".to_owned()],
            environment: Vec::new(),
            memory_mib: None,
            backend: "auto".to_owned(),
            devices: Vec::new(),
            min_backoff_s: 0.1,
            max_backoff_s: 5.0,
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            capture_bytes: 8 << 30,
            twin_bytes: 256 << 20,
            checkpoint_bytes: 4 << 30,
            report_bytes: 64 << 20,
            json_bytes: 1 << 20,
            rollout: rollout::Limits::default(),
            rollouts_per_worker: 8,
            rollout_queue: 64,
            connections: 4096,
            connections_per_peer: 3072,
            head_timeout_s: 30.0,
            stream_idle_s: 30.0,
            connection_age_s: 1800.0,
            upload_idle_s: 60.0,
            uploads: 1024,
            uploads_bytes: 256 << 30,
            plays: 8,
            play_watchers: 64,
            play_idle_s: 600.0,
        }
    }
}

/// Leaves token and database out.
impl std::fmt::Debug for Options {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("listen", &self.listen)
            .field("data_dir", &self.data_dir)
            .field("workers", &self.workers)
            .field("limits", &self.limits)
            .finish_non_exhaustive()
    }
}

impl Options {
    /// Checks every value.
    ///
    /// # Errors
    /// All faults found, one sentence each.
    pub fn validate(&self) -> Result<(), Vec<String>> {
        let mut faults = Vec::new();
        let mut within = |name: &str, value: f64, low: f64, high: f64| {
            if !(value >= low && value <= high) {
                faults.push(format!("{name} is {value}: it must lie in {low}..={high}"));
            }
        };
        within("lease_s", self.lease_s, 0.1, 86_400.0);
        within("heartbeat_interval_s", self.heartbeat_interval_s, 0.01, 3_600.0);
        within("upload_expiry_s", self.upload_expiry_s, 1.0, 365.0 * 86_400.0);
        within("upload_start_s", self.upload_start_s, 1.0, 365.0 * 86_400.0);
        within("disk_floor_mib", self.disk_floor_mib as f64, 0.0, f64::from(1 << 30));
        within("trash_s", self.trash_s, 0.0, 3_650.0 * 86_400.0);
        within("retention_interval_s", self.retention_interval_s, 1.0, 31.0 * 86_400.0);
        within("shutdown_grace_s", self.shutdown_grace_s, 0.0, 3_600.0);
        let workers = &self.workers;
        within("workers.count", f64::from(workers.count), 0.0, 256.0);
        within("workers.min_backoff_s", workers.min_backoff_s, 0.001, 3_600.0);
        within("workers.max_backoff_s", workers.max_backoff_s, workers.min_backoff_s, 86_400.0);
        let mib = |mib: Option<u64>, least: u64| mib.unwrap_or(least) as f64;
        within("memory_mib", mib(self.memory_mib, 64), 64.0, f64::from(1 << 24));
        let least = 128 * u64::from(workers.count);
        within("workers.memory_mib", mib(workers.memory_mib, least), least as f64, 1e9);
        self.queue.validate(&mut within);
        within("quotas.running_jobs", self.quotas.running_jobs.unwrap_or(1) as f64, 1.0, 1e9);
        let limits = &self.limits;
        let large = (1u64 << 50) as f64;
        within("limits.capture_bytes", limits.capture_bytes as f64, 1.0, large);
        within("limits.twin_bytes", limits.twin_bytes as f64, 1.0, large);
        within("limits.checkpoint_bytes", limits.checkpoint_bytes as f64, 1.0, large);
        within("limits.report_bytes", limits.report_bytes as f64, 1.0, large);
        within("limits.json_bytes", limits.json_bytes as f64, 1024.0, large);
        let rollout = &limits.rollout;
        // Protocol buffers end at 2 GiB.
        let message = f64::from(1 << 30);
        within("limits.rollout.request_bytes", rollout.request_bytes as f64, 1024.0, message);
        within("limits.rollout.json_bytes", rollout.json_bytes as f64, 1024.0, message);
        within("limits.rollout.json_reply_bytes", rollout.json_reply_bytes as f64, 1024.0, message);
        within("limits.rollout.memory_bytes", rollout.memory_bytes as f64, 1e6, large);
        within("limits.rollout.reply_bytes", rollout.reply_bytes as f64, 1024.0, message);
        within("limits.rollout.instances", rollout.instances as f64, 1.0, f64::from(u32::MAX));
        within("limits.rollout.frames", rollout.frames as f64, 1.0, f64::from(1 << 24));
        within("limits.rollout.costs", rollout.costs as f64, 1.0, 65_536.0);
        within("limits.rollout.name_bytes", rollout.name_bytes as f64, 1.0, 65_536.0);
        within("limits.rollout.targets", rollout.targets as f64, 1.0, large);
        within("limits.rollout.work", rollout.work as f64, 1.0, large);
        within("limits.rollouts_per_worker", limits.rollouts_per_worker as f64, 1.0, 65_536.0);
        within("limits.rollout_queue", limits.rollout_queue as f64, 0.0, 1e6);
        within("limits.connections", limits.connections as f64, 1.0, 1e6);
        within("limits.connections_per_peer", limits.connections_per_peer as f64, 1.0, 1e6);
        within("limits.head_timeout_s", limits.head_timeout_s, 0.01, 3_600.0);
        within("limits.stream_idle_s", limits.stream_idle_s, 0.01, 86_400.0);
        within("limits.connection_age_s", limits.connection_age_s, 0.1, 31.0 * 86_400.0);
        within("limits.upload_idle_s", limits.upload_idle_s, 0.1, 86_400.0);
        within("limits.uploads", limits.uploads as f64, 1.0, 1e6);
        within("limits.uploads_bytes", limits.uploads_bytes as f64, 1.0, large);
        within("limits.plays", limits.plays as f64, 0.0, 256.0);
        within("limits.play_watchers", limits.play_watchers as f64, 0.0, 65_536.0);
        within("limits.play_idle_s", limits.play_idle_s, 1.0, 86_400.0);
        if self.heartbeat_interval_s > self.lease_s / 2.0 {
            faults.push(format!(
                "heartbeat_interval_s is {}: it must be at most half of lease_s ({})",
                self.heartbeat_interval_s, self.lease_s
            ));
        }
        if let Some(token) = &self.worker_token
            && (token.len() < 16 || !token.bytes().all(|b| b.is_ascii_graphic()))
        {
            faults.push(
                "worker_token must be at least 16 printable characters without spaces".to_owned(),
            );
        }
        if !BACKENDS.contains(&self.workers.backend.as_str()) {
            let backend = &self.workers.backend;
            faults.push(format!("workers.backend is `{backend}`: it must be auto, cpu or cuda"));
        }
        for host in self.allowed_hosts.iter().filter(|host| !is_host(host)) {
            faults.push(format!(
                "allowed_hosts has `{host}`: give names without scheme and port, or *"
            ));
        }
        faults.extend(self.openness());
        faults.extend(self.public_url_faults());
        faults.extend(self.sign_in_faults());
        if let Some(url) = &self.database_url
            && let Err(fault) = DatabaseUrl::parse(url.reveal())
        {
            faults.push(format!("database_url: {fault}"));
        }
        if let Some(url) = &self.objects_url
            && let Err(fault) = ObjectsUrl::parse(&url.to_string())
        {
            faults.push(format!("objects_url: {fault}"));
        }
        for (number, rule) in self.retention.iter().enumerate() {
            if let Err((field, fault)) = rule.conditions() {
                faults.push(format!("retention[{number}].{field} {fault}"));
            }
        }
        if self.data_dir.as_os_str().is_empty() {
            faults.push("data_dir is empty: name a folder".to_owned());
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// Memory that requests under way may take together [bytes].
    pub(crate) fn memory_bytes(&self) -> u64 {
        let chosen = self.memory_mib.map(|mib| mib.saturating_mul(MIB));
        chosen.unwrap_or_else(|| (machine_bytes() / 8).clamp(128 * MIB, 2048 * MIB))
    }

    /// File of the token of clients: the one that the options name, or that of the data folder.
    pub fn client_token_path(&self) -> PathBuf {
        let own = || client_token::path(&self.data_dir);
        self.client_token_file.clone().unwrap_or_else(own)
    }

    pub(crate) fn lease(&self) -> Duration {
        Duration::from_secs_f64(self.lease_s)
    }

    pub(crate) fn heartbeat_interval(&self) -> Duration {
        Duration::from_secs_f64(self.heartbeat_interval_s)
    }

    pub(crate) fn upload_expiry(&self) -> Duration {
        Duration::from_secs_f64(self.upload_expiry_s)
    }

    pub(crate) fn upload_start(&self) -> Duration {
        Duration::from_secs_f64(self.upload_start_s.min(self.upload_expiry_s))
    }

    /// Free space of the disk below which new content is refused [bytes].
    pub(crate) fn disk_floor_bytes(&self) -> u64 {
        self.disk_floor_mib.saturating_mul(MIB)
    }

    /// Time for which what was deleted can be restored; zero deletes for good.
    pub(crate) fn trash(&self) -> Duration {
        Duration::from_secs_f64(self.trash_s)
    }

    pub(crate) fn retention_interval(&self) -> Duration {
        Duration::from_secs_f64(self.retention_interval_s)
    }

    /// The rules of the configuration. Those that are no rules were refused at the start.
    pub(crate) fn retention_rules(&self) -> Vec<NewRule> {
        self.retention.iter().filter_map(|rule| rule.conditions().ok()).collect()
    }

    pub(crate) fn timeouts(&self) -> Timeouts {
        Timeouts {
            head: Duration::from_secs_f64(self.limits.head_timeout_s),
            // Uploads end first, with a specific error.
            body: self.limits.upload_idle() + Duration::from_secs(1),
            unread: Duration::from_secs_f64(self.limits.stream_idle_s),
            age: Duration::from_secs_f64(self.limits.connection_age_s),
        }
    }

    pub(crate) fn shutdown_grace(&self) -> Duration {
        Duration::from_secs_f64(self.shutdown_grace_s)
    }
}

/// True for `*` and for anything that can stand in a URL as a name.
fn is_host(host: &str) -> bool {
    let is_part = |b: u8| b.is_ascii_alphanumeric() || b"-._".contains(&b);
    host == "*" || !host.is_empty() && host.bytes().all(is_part)
}

impl WorkerPolicy {
    /// Memory of one worker [MiB].
    pub(crate) fn each_memory_mib(&self) -> u64 {
        let all = self.memory_mib.unwrap_or_else(|| machine_bytes() / 2 / MIB);
        (all / u64::from(self.count.max(1))).max(128)
    }
}

/// Memory of the machine or the container; 4 GiB where it is not known.
fn machine_bytes() -> u64 {
    bendtwin_budget::machine_bytes().unwrap_or(4096 * MIB)
}

impl Limits {
    /// Limits of plays.
    pub(crate) fn plays(&self) -> bendtwin_play::Limits {
        bendtwin_play::Limits {
            plays: self.plays,
            watchers: self.play_watchers,
            idle: Duration::from_secs_f64(self.play_idle_s),
        }
    }

    pub(crate) fn upload_idle(&self) -> Duration {
        Duration::from_secs_f64(self.upload_idle_s)
    }
}

#[cfg(test)]
mod tests;

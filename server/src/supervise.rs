//! The server's own worker processes: started, restarted when they end, and
//! ended with the server.
//!
//! A child gets the server's address and a separate token in its environment. Its standard input
//! is a pipe that the server holds open; the child exits when that ends, by a shutdown or because
//! the server died. When a child ends, its jobs are requeued immediately.

mod program;

use std::{ffi::OsString, net::SocketAddr, path::PathBuf, process::Stdio, time::Duration};

use tokio::{
    process::{Child as Process, Command},
    time::Instant,
};
use tokio_util::{sync::CancellationToken, task::TaskTracker};

use crate::{access::Child, app::App};

pub(crate) use program::program;

/// The environment variable with the server's address, for example `http://127.0.0.1:7070`.
pub const SERVER_VARIABLE: &str = "BENDTWIN_SERVER";
/// The environment variable with the worker token.
pub const TOKEN_VARIABLE: &str = "BENDTWIN_WORKER_TOKEN";
/// The environment variable with the file of a worker's certificate.
const CERTIFICATE_VARIABLE: &str = "BENDTWIN_WORKER_CERTIFICATE";
/// The environment variable with the file of its key.
const KEY_VARIABLE: &str = "BENDTWIN_WORKER_KEY";
/// The environment variable with the URL of the server's database.
const DATABASE_VARIABLE: &str = "BENDTWIN_DATABASE_URL";
/// The environment variable with the place of content.
const OBJECTS_VARIABLE: &str = "BENDTWIN_OBJECTS";
/// The environment variable with the backend: `auto`, `cpu` or `cuda`.
pub const BACKEND_VARIABLE: &str = "BENDTWIN_BACKEND";
/// The environment variable with the number of the CUDA device.
pub const DEVICE_VARIABLE: &str = "BENDTWIN_DEVICE";
/// The environment variable with the folder for captures while they are read. Workers inherit it
/// from a server that has it.
pub const SCRATCH_VARIABLE: &str = "BENDTWIN_SCRATCH_DIR";
/// Scratch folder inside the data folder.
const SCRATCH_FOLDER: &str = "scratch";

/// The environment variable with the memory of the worker [MiB].
pub const MEMORY_VARIABLE: &str = "BENDTWIN_WORKER_MEMORY_MIB";

/// Lifetime from which a child counts as healthy: the next restart is quick again.
const HEALTHY_AFTER: Duration = Duration::from_secs(3);

/// The supervisor of all children.
#[derive(Debug)]
pub(crate) struct Supervisor {
    stop: CancellationToken,
    /// Cancelled after the grace period: children are killed.
    kill: CancellationToken,
    tasks: TaskTracker,
}

/// Program, arguments and environment of every child.
#[derive(Clone, Debug)]
struct SpawnOptions {
    program: PathBuf,
    args: Vec<OsString>,
    environment: Vec<(String, String)>,
    server: String,
    backend: String,
    /// CUDA devices, taken in turn.
    devices: Vec<u32>,
    memory_mib: u64,
    min_backoff: Duration,
    max_backoff: Duration,
}

impl SpawnOptions {
    /// The device of the worker in a slot, if any were named.
    fn device(&self, slot: u32) -> Option<u32> {
        let turn = (slot as usize).checked_rem(self.devices.len())?;
        self.devices.get(turn).copied()
    }
}

/// Starts the children that the options ask for.
pub(crate) fn start(app: &App, program: Option<PathBuf>, address: SocketAddr) -> Supervisor {
    let policy = &app.options().workers;
    let supervisor = Supervisor {
        stop: CancellationToken::new(),
        kill: CancellationToken::new(),
        tasks: TaskTracker::new(),
    };
    let Some(program) = program else { return supervisor };
    let spawn_options = SpawnOptions {
        program,
        args: policy.args.iter().map(OsString::from).collect(),
        environment: policy.environment.clone(),
        server: format!("http://{}", reachable(address)),
        backend: policy.backend.clone(),
        devices: policy.devices.clone(),
        memory_mib: policy.each_memory_mib(),
        min_backoff: Duration::from_secs_f64(policy.min_backoff_s),
        max_backoff: Duration::from_secs_f64(policy.max_backoff_s),
    };
    for slot in 0..policy.count {
        let (stop, kill) = (supervisor.stop.clone(), supervisor.kill.clone());
        let slot_supervisor = SlotSupervisor {
            app: app.clone(),
            spawn_options: spawn_options.clone(),
            slot,
            stop,
            kill,
        };
        supervisor.tasks.spawn(slot_supervisor.run());
    }
    supervisor
}

/// The address at which processes on this machine reach the server.
fn reachable(address: SocketAddr) -> SocketAddr {
    let mut address = address;
    if address.ip().is_unspecified() {
        address.set_ip(match address {
            SocketAddr::V4(_) => std::net::Ipv4Addr::LOCALHOST.into(),
            SocketAddr::V6(_) => std::net::Ipv6Addr::LOCALHOST.into(),
        });
    }
    address
}

impl Supervisor {
    /// Ends all children: asked first, killed after the grace period.
    pub(crate) async fn stop(self, grace: Duration) {
        self.stop.cancel();
        self.tasks.close();
        if tokio::time::timeout(grace, self.tasks.wait()).await.is_err() {
            self.kill.cancel();
            self.tasks.wait().await;
        }
    }
}

/// Supervisor of a slot: starts a child whenever the slot is empty.
struct SlotSupervisor {
    app: App,
    spawn_options: SpawnOptions,
    slot: u32,
    stop: CancellationToken,
    kill: CancellationToken,
}

impl SlotSupervisor {
    async fn run(self) {
        let mut backoff = self.spawn_options.min_backoff;
        let mut generation = 0u32;
        while !self.stop.is_cancelled() {
            let child = Child(u64::from(generation) << 32 | u64::from(self.slot));
            if generation > 0 {
                self.app.child_restarted(self.slot);
            }
            generation = generation.wrapping_add(1);
            let started = Instant::now();
            match self.spawn(child) {
                Ok(process) => self.wait_for_exit(child, process).await,
                Err(error) => {
                    let program = self.spawn_options.program.display();
                    tracing::error!(%error, %program, "cannot start a worker");
                }
            }
            self.app.child_gone(child).await;
            if started.elapsed() >= HEALTHY_AFTER {
                backoff = self.spawn_options.min_backoff;
            }
            let () = tokio::select! {
                () = self.stop.cancelled() => (),
                () = tokio::time::sleep(backoff) => (),
            };
            backoff = (backoff * 2).min(self.spawn_options.max_backoff);
        }
    }

    fn spawn(&self, child: Child) -> std::io::Result<Process> {
        let mut command = Command::new(&self.spawn_options.program);
        if let Some(device) = self.spawn_options.device(self.slot) {
            command.env(DEVICE_VARIABLE, device.to_string());
        }
        if std::env::var_os(SCRATCH_VARIABLE).is_none() {
            let folder = std::path::absolute(&self.app.options().data_dir)?.join(SCRATCH_FOLDER);
            command.env(SCRATCH_VARIABLE, folder);
        }
        // Of the environment of the server, the database and the bucket are nothing to workers and to
        // the programs that read strangers' files for them.
        for variable in [DATABASE_VARIABLE, OBJECTS_VARIABLE, "PGPASSWORD", "PGPASSFILE"] {
            command.env_remove(variable);
        }
        // They talk to it without TLS, on this machine.
        for variable in [CERTIFICATE_VARIABLE, KEY_VARIABLE] {
            command.env_remove(variable);
        }
        for (variable, _) in std::env::vars_os() {
            if variable.to_string_lossy().to_ascii_uppercase().starts_with("AWS_") {
                command.env_remove(variable);
            }
        }
        command
            .args(&self.spawn_options.args)
            .envs(self.spawn_options.environment.iter().map(|(name, value)| (name, value)))
            .env(SERVER_VARIABLE, &self.spawn_options.server)
            .env(TOKEN_VARIABLE, self.app.admit_child(child))
            .env(BACKEND_VARIABLE, &self.spawn_options.backend)
            .env(MEMORY_VARIABLE, self.spawn_options.memory_mib.to_string())
            .stdin(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
    }

    /// Waits until the process ends, by itself or on request.
    async fn wait_for_exit(&self, child: Child, mut process: Process) {
        tracing::info!(slot = self.slot, pid = process.id(), "worker started");
        // Dropping it ends the child's standard input.
        let stdin = process.stdin.take();
        let ended = tokio::select! {
            ended = process.wait() => Some(ended),
            () = self.stop.cancelled() => None,
        };
        drop(stdin);
        let ended = match ended {
            Some(ended) => ended,
            None => tokio::select! {
                ended = process.wait() => ended,
                () = self.kill.cancelled() => {
                    tracing::warn!(slot = self.slot, "worker does not end: killing it");
                    match process.kill().await {
                        Ok(()) => process.wait().await,
                        Err(error) => Err(error),
                    }
                }
            },
        };
        match ended {
            Ok(status) if self.stop.is_cancelled() => {
                tracing::info!(slot = self.slot, %status, "worker ended");
            }
            Ok(status) => {
                tracing::warn!(slot = self.slot, %status, ?child, "worker ended, restarting");
            }
            Err(error) => tracing::error!(slot = self.slot, %error, "cannot wait for the worker"),
        }
    }
}

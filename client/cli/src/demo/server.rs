//! The demo's server: a process of this very program, which ends with it.

use std::{
    path::{Path, PathBuf},
    process::{ExitStatus, Stdio},
    time::{Duration, Instant},
};

use anyhow::Context as _;
use bendtwin_client::Client;
use tokio::process::{Child, ChildStdin, Command};

use crate::backend::BackendArgs;

/// Longest time for the start of server and worker.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// Longest time for their end.
const STOP_TIMEOUT: Duration = Duration::from_secs(20);
/// Time between two polls.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A running server with one worker.
pub(super) struct DemoServer {
    child: Child,
    /// Held open as long as the server should run; kept here because waiting for a child closes the
    /// child's own.
    stdin: Option<ChildStdin>,
    log: PathBuf,
    pub(super) connection: Connection,
}

/// The server's address, and a client of it.
#[derive(Clone)]
pub(super) struct Connection {
    pub(super) url: String,
    /// The token that clients show.
    pub(super) token: String,
    pub(super) client: Client,
}

impl DemoServer {
    /// Starts a server in a folder and waits until its worker has registered.
    pub(super) async fn start(folder: &Path, backend: &BackendArgs) -> anyhow::Result<Self> {
        let (port_file, log) = (folder.join("port"), folder.join("server.log"));
        // A kept folder may have the port of the last time.
        let _ = std::fs::remove_file(&port_file);
        let log_file = std::fs::File::create(&log)
            .with_context(|| format!("cannot write {}", log.display()))?;
        let mut child = Command::new(std::env::current_exe()?)
            .args(["server", "--listen", "127.0.0.1:0", "--workers", "1", "--exit-with-parent"])
            .args(["--client-token", "required"])
            .arg("--data-dir")
            .arg(folder.join("data"))
            .arg("--port-file")
            .arg(&port_file)
            // The demo is independent of the settings of the user's server.
            .env_remove("BENDTWIN_CONFIG")
            .env_remove("BENDTWIN_CLIENT_TOKEN")
            .env_remove("BENDTWIN_ALLOWED_HOSTS")
            .env_remove("BENDTWIN_TLS_CERTIFICATE")
            .env_remove("BENDTWIN_TLS_KEY")
            .env_remove("BENDTWIN_LISTEN_WORKERS_TLS")
            .env_remove("BENDTWIN_WORKER_TLS_CERTIFICATE")
            .env_remove("BENDTWIN_WORKER_TLS_KEY")
            .env_remove("BENDTWIN_WORKER_TLS_CA")
            .env_remove("BENDTWIN_WORKER_TOKEN")
            .env_remove("BENDTWIN_WORKER_LISTEN")
            .env_remove("BENDTWIN_WORKER_ADVERTISE")
            .env_remove("BENDTWIN_CACHE_DIR")
            .env_remove("BENDTWIN_SCRATCH_DIR")
            .env_remove("BENDTWIN_INGEST_SANDBOX")
            .env_remove("BENDTWIN_INGEST_TIMEOUT_S")
            .env_remove("BENDTWIN_DEVICES")
            .env_remove("BENDTWIN_DEVICE_MEMORY_MIB")
            .envs(backend.variables())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(log_file)
            .kill_on_drop(true)
            .spawn()
            .context("cannot start the server process")?;
        let started = Instant::now();
        let port = loop {
            if let Some(status) = child.try_wait()? {
                return Err(ended(status, &log));
            }
            let text = std::fs::read_to_string(&port_file).unwrap_or_default();
            if let Ok(port) = text.trim().parse::<u16>() {
                break port;
            }
            anyhow::ensure!(
                started.elapsed() < START_TIMEOUT,
                "the server does not start{}",
                tail(&log)
            );
            tokio::time::sleep(POLL_INTERVAL).await;
        };
        let url = format!("http://127.0.0.1:{port}");
        // Independent of any token of the user's server.
        let token = std::fs::read_to_string(folder.join("data/client-token"))
            .context("cannot read the token of the server")?;
        let token = token.trim().to_owned();
        let client = Client::connect_with_token(&url, Some(&token)).await?;
        while client.workers().all().await?.is_empty() {
            anyhow::ensure!(started.elapsed() < START_TIMEOUT, "no worker starts{}", tail(&log));
            tokio::time::sleep(POLL_INTERVAL).await;
        }
        let stdin = child.stdin.take();
        Ok(Self { child, stdin, log, connection: Connection { url, token, client } })
    }

    /// Waits until the server ends by itself, which it should not.
    pub(super) async fn ended(&mut self) -> anyhow::Error {
        match self.child.wait().await {
            Ok(status) => ended(status, &self.log),
            Err(error) => error.into(),
        }
    }

    /// Ends server and worker in order.
    pub(super) async fn stop(mut self) {
        // The end of its standard input asks the server to shut down.
        drop(self.stdin.take());
        if tokio::time::timeout(STOP_TIMEOUT, self.child.wait()).await.is_err() {
            let _ = self.child.kill().await;
        }
    }
}

fn ended(status: ExitStatus, log: &Path) -> anyhow::Error {
    anyhow::anyhow!("the server ended ({status}){}", tail(log))
}

/// The last lines of the server's log.
fn tail(log: &Path) -> String {
    let text = std::fs::read_to_string(log).unwrap_or_default();
    let lines: Vec<_> = text.lines().rev().take(10).collect();
    lines.into_iter().rev().fold("; its log ends:".to_owned(), |all, l| all + "\n  " + l)
}

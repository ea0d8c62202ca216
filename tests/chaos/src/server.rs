//! The server under test, and its supervisor: what a process manager does, and no more. It starts
//! the server again when it has ended. A restart for any other reason is one by hand, which breaks
//! a promise.

use std::{
    path::{Path, PathBuf},
    process::{Child, Command},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail};
use bendtwin_harness::{
    Api,
    command::bendtwin,
    http::Http,
    process::{Processes, signal},
};
use tokio::time::sleep;

use crate::{clock::Clock, tally::Tally};

/// Workers of the server.
pub(crate) const WORKERS: usize = 2;
/// Time after which a worker that does not report loses its job [s]: shorter than the longest
/// pauses, so that these pauses matter.
const LEASE_S: f64 = 4.0;
/// Memory that requests at the server may take together [MiB].
pub(crate) const SERVER_MIB: u64 = 512;
/// Memory of the workers together [MiB].
pub(crate) const WORKERS_MIB: u64 = 2048;
/// Longest time from a start until the server is ready.
const START: Duration = Duration::from_secs(60);
/// Longest time from SIGTERM to the end.
const STOP: Duration = Duration::from_secs(45);
/// Wait before a start after an end, as of a process manager.
const PAUSE: Duration = Duration::from_millis(100);
const POLL: Duration = Duration::from_millis(20);

/// The server, its workers and their folder.
pub(crate) struct Server {
    folder: PathBuf,
    address: String,
    processes: Processes,
    clock: Option<Clock>,
    tally: Arc<Tally>,
    child: Mutex<Option<Child>>,
    /// True if somebody killed it: its end is no surprise.
    doomed: AtomicBool,
    /// True if it was asked to end, and not killed since.
    orderly: AtomicBool,
    /// Held while it is asked to end: orderly ends come one at a time.
    ending: tokio::sync::Mutex<()>,
    /// True while the disk is full: the server may be unready, and fail to start.
    pub(crate) disk_is_full: AtomicBool,
    stopping: AtomicBool,
    by_hand: Mutex<Option<Instant>>,
}

impl Server {
    /// A server with its data in `folder/data`; it is not started yet.
    pub(crate) fn new(
        folder: &Path,
        clock: Option<Clock>,
        tally: Arc<Tally>,
    ) -> anyhow::Result<Self> {
        let free = std::net::TcpListener::bind("127.0.0.1:0")?;
        let address = free.local_addr()?.to_string();
        // The disk is small. Small uploads that were begun shall still be there after hours.
        let text = format!(
            "listen = \"{address}\"\n\
             data_dir = \"{data}\"\n\
             client_token = \"none\"\n\
             lease_s = {LEASE_S:?}\n\
             heartbeat_interval_s = {heartbeat:?}\n\
             upload_start_s = 604800.0\n\
             disk_floor_mib = 32\n\
             memory_mib = {SERVER_MIB}\n\
             [workers]\n\
             count = {WORKERS}\n\
             memory_mib = {WORKERS_MIB}\n\
             backend = \"cpu\"\n",
            data = folder.join("data").display(),
            heartbeat = LEASE_S / 4.0,
        );
        std::fs::write(folder.join("config.toml"), text)?;
        Ok(Self {
            folder: folder.to_owned(),
            address,
            processes: Processes::new(folder),
            clock,
            tally,
            child: Mutex::new(None),
            doomed: AtomicBool::new(false),
            orderly: AtomicBool::new(false),
            ending: tokio::sync::Mutex::new(()),
            disk_is_full: AtomicBool::new(false),
            stopping: AtomicBool::new(false),
            by_hand: Mutex::new(None),
        })
    }

    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    pub(crate) fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    pub(crate) fn api(&self) -> Api {
        Api::new(&self.address)
    }

    pub(crate) fn http(&self) -> Http {
        Http::new(&self.url())
    }

    pub(crate) fn data_dir(&self) -> PathBuf {
        self.folder.join("data")
    }

    pub(crate) fn log_file(&self) -> PathBuf {
        self.folder.join("server.log")
    }

    fn child(&self) -> MutexGuard<'_, Option<Child>> {
        self.child.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn pid(&self) -> Option<u32> {
        self.child().as_ref().map(Child::id)
    }

    pub(crate) fn workers(&self) -> Vec<u32> {
        self.processes.workers()
    }

    pub(crate) fn readers(&self) -> Vec<u32> {
        self.processes.readers()
    }

    /// kill -9 of the server.
    pub(crate) fn kill(&self) {
        if let Some(child) = self.child().as_mut() {
            self.doomed.store(true, Ordering::SeqCst);
            self.orderly.store(false, Ordering::SeqCst);
            child.kill().ok();
        }
    }

    /// A restart by hand, because something does not come back by itself; at most one a minute.
    pub(crate) fn restart_by_hand(&self, why: &str) {
        let mut last = self.by_hand.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_some_and(|at| at.elapsed() < START) || self.stopping.load(Ordering::SeqCst) {
            return;
        }
        *last = Some(Instant::now());
        self.tally.count("restarts by hand");
        self.tally.broken("nobody has to restart the server", why);
        self.kill();
    }

    /// Starts the server, and again whenever it ends, until [`Server::stop`].
    pub(crate) async fn supervise(self: Arc<Self>) -> anyhow::Result<()> {
        let mut ended = Instant::now();
        while !self.stopping.load(Ordering::SeqCst) {
            self.doomed.store(false, Ordering::SeqCst);
            self.spawn()?;
            let was_ready = self.becomes_ready().await;
            if was_ready {
                self.tally
                    .took("recovery: longest from an end of the server to ready", ended.elapsed());
            }
            let status = self.ends().await?;
            ended = Instant::now();
            self.tally.log(format_args!("the server ended: {status}"));
            if self.orderly.swap(false, Ordering::SeqCst) && was_ready && !status.success() {
                self.tally.broken("SIGTERM ends the server in order", status);
            }
            let expected = self.doomed.load(Ordering::SeqCst)
                || self.stopping.load(Ordering::SeqCst)
                || self.disk_is_full.load(Ordering::SeqCst);
            if !expected {
                self.tally.count("servers that ended by themselves");
                self.tally.broken("the server does not end by itself", status);
            }
            sleep(PAUSE).await;
        }
        Ok(())
    }

    fn spawn(&self) -> anyhow::Result<()> {
        let mut command = bendtwin();
        command.arg("server").arg("--config").arg(self.folder.join("config.toml"));
        command.env("TMPDIR", self.folder.join("tmp"));
        if let Some(clock) = &self.clock {
            clock.preload(&mut command);
        }
        *self.child() = Some(self.processes.start(&mut command, &self.log_file()));
        Ok(())
    }

    /// Waits until the server is ready; false if it ends before.
    async fn becomes_ready(&self) -> bool {
        let http = self.http();
        let mut waited = Instant::now();
        loop {
            if self.has_ended() {
                return false;
            }
            if http.is_ready().await {
                return true;
            }
            if self.disk_is_full.load(Ordering::SeqCst) {
                waited = Instant::now();
            }
            if waited.elapsed() > START {
                self.restart_by_hand("it did not become ready");
                waited = Instant::now();
            }
            sleep(POLL).await;
        }
    }

    fn has_ended(&self) -> bool {
        self.child().as_mut().is_none_or(|child| !matches!(child.try_wait(), Ok(None)))
    }

    async fn ends(&self) -> anyhow::Result<std::process::ExitStatus> {
        loop {
            if let Some(child) = self.child().as_mut()
                && let Some(status) = child.try_wait()?
            {
                return Ok(status);
            }
            sleep(POLL).await;
        }
    }

    /// Waits until the server is ready and has all its workers.
    pub(crate) async fn is_whole(&self) -> anyhow::Result<()> {
        let (http, api, began) = (self.http(), self.api(), Instant::now());
        while began.elapsed() < START {
            if http.is_ready().await
                && let Ok(Ok(workers)) =
                    tokio::time::timeout(Duration::from_secs(5), api.list_workers()).await
                && workers.len() >= WORKERS
            {
                return Ok(());
            }
            sleep(10 * POLL).await;
        }
        bail!("the server was not ready with {WORKERS} workers within {START:?}")
    }

    /// SIGTERM, and a start by the supervisor.
    pub(crate) async fn restart(&self) -> anyhow::Result<()> {
        // A second signal would end it at once.
        let _one = self.ending.lock().await;
        let pid = self.pid().context("the server does not run")?;
        self.end_in_order(pid).await;
        let (http, began) = (self.http(), Instant::now());
        while self.pid() == Some(pid) || !http.is_ready().await {
            if began.elapsed() > START {
                bail!("it was not ready within {START:?}");
            }
            sleep(POLL).await;
        }
        Ok(())
    }

    /// SIGTERM, for good.
    pub(crate) async fn stop(&self) -> anyhow::Result<()> {
        self.stopping.store(true, Ordering::SeqCst);
        let _one = self.ending.lock().await;
        let pid = self.pid().context("the server does not run")?;
        self.end_in_order(pid).await;
        Ok(())
    }

    async fn end_in_order(&self, pid: u32) {
        self.doomed.store(true, Ordering::SeqCst);
        self.orderly.store(true, Ordering::SeqCst);
        signal(pid, "TERM");
        let began = Instant::now();
        while self.pid() == Some(pid) && !self.has_ended() {
            if began.elapsed() > STOP {
                self.tally.broken("SIGTERM ends the server", format_args!("not within {STOP:?}"));
                self.kill();
            }
            sleep(POLL).await;
        }
        self.tally.took("recovery: longest orderly end", began.elapsed());
    }

    /// `bendtwin store check` of the data of a server that has ended.
    pub(crate) fn check_store(&self) -> anyhow::Result<()> {
        let knows = bendtwin().args(["store", "check", "--help"]).output()?;
        if !knows.status.success() {
            self.tally.say("SKIPPED store check: this binary has no such command");
            return Ok(());
        }
        let mut command: Command = bendtwin();
        let output =
            command.args(["store", "check", "--data-dir"]).arg(self.data_dir()).output()?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned()
            + &String::from_utf8_lossy(&output.stderr);
        self.tally.log(format_args!("store check: {}\n{text}", output.status));
        if !output.status.success() {
            self.tally.broken("the store is in order", text.trim());
        }
        Ok(())
    }
}

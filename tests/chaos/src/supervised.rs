//! A process under test and its supervisor: what a process manager does, and no more. It starts the
//! process again when it has ended. A restart for any other reason is one by hand, which breaks a
//! promise.

use std::{
    path::{Path, PathBuf},
    process::{Child, Command},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail};
use bendtwin_harness::{
    http::Http,
    process::{Processes, signal},
};
use tokio::time::sleep;

use crate::tally::Tally;

/// Longest time from a start until a server is ready.
pub(crate) const START: Duration = Duration::from_secs(60);
/// Longest time from SIGTERM to the end.
const STOP: Duration = Duration::from_secs(45);
/// Wait before a start after an end, as of a process manager.
const PAUSE: Duration = Duration::from_millis(100);
/// Time for which a start may still fail because of what it met.
const AFTERMATH: Duration = Duration::from_secs(20);
pub(crate) const POLL: Duration = Duration::from_millis(20);

/// Description of a process.
pub(crate) struct Plan {
    /// `server`, `worker 3`.
    pub(crate) name: String,
    pub(crate) command: Box<dyn Fn() -> Command + Send + Sync>,
    pub(crate) log: PathBuf,
    /// `http://host:port`, if it is a server, which is to become ready.
    pub(crate) url: Option<String>,
}

/// A process that is started again whenever it ends.
pub(crate) struct Supervised {
    plan: Plan,
    processes: Arc<Processes>,
    tally: Arc<Tally>,
    excuses: Excuses,
    child: Mutex<Option<Child>>,
    /// True if the suite killed it: its end is no surprise.
    doomed: AtomicBool,
    /// True if it was asked to end, and not killed since.
    orderly: AtomicBool,
    /// Held while it is asked to end: orderly ends come one at a time.
    ending: tokio::sync::Mutex<()>,
    stopping: AtomicBool,
    by_hand: Mutex<Option<Instant>>,
}

/// Reasons for which a process may be unready, and fail to start: a full disk, a database that is away.
#[derive(Clone, Debug, Default)]
pub(crate) struct Excuses(Arc<(AtomicUsize, Mutex<Option<Instant>>)>);

/// A reason, as long as it holds.
#[derive(Debug)]
pub(crate) struct Excuse(Excuses);

impl Excuses {
    /// A reason that holds from now on.
    pub(crate) fn begin(&self) -> Excuse {
        self.0.0.fetch_add(1, Ordering::SeqCst);
        Excuse(self.clone())
    }

    fn hold(&self) -> bool {
        self.0.0.load(Ordering::SeqCst) > 0
    }

    /// True if one holds, or did when a process that ends now was starting.
    fn held(&self) -> bool {
        let last = *self.0.1.lock().unwrap_or_else(PoisonError::into_inner);
        self.hold() || last.is_some_and(|last| last.elapsed() < AFTERMATH)
    }
}

impl Drop for Excuse {
    fn drop(&mut self) {
        let Excuses(inner) = &self.0;
        *inner.1.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
        inner.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Supervised {
    /// A process that is not started yet.
    pub(crate) fn new(
        plan: Plan,
        processes: Arc<Processes>,
        tally: Arc<Tally>,
        excuses: Excuses,
    ) -> Self {
        Self {
            plan,
            processes,
            tally,
            excuses,
            child: Mutex::new(None),
            doomed: AtomicBool::new(false),
            orderly: AtomicBool::new(false),
            ending: tokio::sync::Mutex::new(()),
            stopping: AtomicBool::new(false),
            by_hand: Mutex::new(None),
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.plan.name
    }

    /// `http://host:port` of a server.
    pub(crate) fn url(&self) -> Option<&str> {
        self.plan.url.as_deref()
    }

    pub(crate) fn log_file(&self) -> &Path {
        &self.plan.log
    }

    fn child(&self) -> MutexGuard<'_, Option<Child>> {
        self.child.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn pid(&self) -> Option<u32> {
        self.child().as_ref().map(Child::id)
    }

    /// kill -9.
    pub(crate) fn kill(&self) {
        if let Some(child) = self.child().as_mut() {
            self.doomed.store(true, Ordering::SeqCst);
            self.orderly.store(false, Ordering::SeqCst);
            child.kill().ok();
        }
    }

    /// Restarts by hand what does not recover by itself; at most once a minute.
    pub(crate) fn restart_by_hand(&self, why: &str) {
        let mut last = self.by_hand.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_some_and(|at| at.elapsed() < START) || self.stopping.load(Ordering::SeqCst) {
            return;
        }
        *last = Some(Instant::now());
        self.tally.count("restarts by hand");
        let case = format_args!("{}: {why}", self.plan.name);
        self.tally.broken("nobody has to restart anything", case);
        self.kill();
    }

    /// Starts the process, and again whenever it ends, until [`Supervised::stop`].
    pub(crate) async fn supervise(self: Arc<Self>) -> anyhow::Result<()> {
        let mut ended = Instant::now();
        while !self.stopping.load(Ordering::SeqCst) {
            self.doomed.store(false, Ordering::SeqCst);
            let mut command = (self.plan.command)();
            *self.child() = Some(self.processes.start(&mut command, &self.plan.log));
            let was_ready = self.becomes_ready().await;
            if was_ready && self.plan.url.is_some() {
                self.tally
                    .took("recovery: longest from an end of a server to ready", ended.elapsed());
            }
            let status = self.ends().await?;
            ended = Instant::now();
            self.tally.log(format_args!("the {} ended: {status}", self.plan.name));
            if self.orderly.swap(false, Ordering::SeqCst) && was_ready && !status.success() {
                let case = format_args!("{}: {status}", self.plan.name);
                self.tally.broken("SIGTERM ends a process in order", case);
            }
            let expected =
                self.doomed.load(Ordering::SeqCst) || self.stopping.load(Ordering::SeqCst);
            if !expected && !was_ready && self.excuses.held() {
                self.tally.count("starts that failed, and were tried again");
            } else if !expected {
                self.tally.count("processes that ended by themselves");
                let case = format_args!("{}: {status}", self.plan.name);
                self.tally.broken("no process ends by itself", case);
            }
            sleep(PAUSE).await;
        }
        Ok(())
    }

    /// Waits until a server is ready; false if it ends before.
    async fn becomes_ready(&self) -> bool {
        let Some(url) = &self.plan.url else { return true };
        let http = Http::new(url);
        let mut waited = Instant::now();
        loop {
            if self.has_ended() {
                return false;
            }
            if http.is_ready().await {
                return true;
            }
            if self.excuses.hold() {
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

    /// SIGTERM, and a start by the supervisor.
    pub(crate) async fn restart(&self) -> anyhow::Result<()> {
        // A second signal would end it immediately.
        let _one = self.ending.lock().await;
        let pid = self.pid().with_context(|| format!("the {} does not run", self.plan.name))?;
        self.end_in_order(pid).await;
        let began = Instant::now();
        let is_ready = async || match &self.plan.url {
            Some(url) => Http::new(url).is_ready().await,
            None => true,
        };
        while self.pid() == Some(pid) || !is_ready().await {
            if began.elapsed() > START {
                bail!("it was not ready within {START:?}");
            }
            sleep(POLL).await;
        }
        Ok(())
    }

    /// Sends SIGTERM and does not restart.
    pub(crate) async fn stop(&self) -> anyhow::Result<()> {
        self.stopping.store(true, Ordering::SeqCst);
        let _one = self.ending.lock().await;
        let pid = self.pid().with_context(|| format!("the {} does not run", self.plan.name))?;
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
                let case = format_args!("{}: not within {STOP:?}", self.plan.name);
                self.tally.broken("SIGTERM ends a process", case);
                self.kill();
            }
            sleep(POLL).await;
        }
        self.tally.took("recovery: longest orderly end", began.elapsed());
    }
}

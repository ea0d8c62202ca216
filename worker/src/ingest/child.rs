//! The worker's side of the child process: starts it, reads its messages, kills it when the job is
//! stopped, and explains its end.

use std::{
    path::Path,
    process::{ExitStatus, Stdio},
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

use bendtwin_core::{Category, Fault};
use bendtwin_inspect::Verdict;
use tokio::{
    io::{AsyncBufRead, AsyncBufReadExt as _, AsyncRead, AsyncReadExt as _, BufReader},
    process::Command,
};

use super::{
    protocol::{CHECKPOINT, Message, read_result},
    sandbox::Enforced,
};
use crate::job::{
    checkpoints::{Checkpoints, MAX_BYTES as MAX_CHECKPOINT},
    report::LatestProgress,
};

/// Longest message line that is accepted [bytes]; the child writes far shorter ones.
const MAX_LINE: u64 = 1 << 20;
/// Size of the tail of its standard error that is kept [bytes].
const TAIL_BYTES: usize = 4 << 10;
/// Most threads of the child. Each has a stack and an arena, which count as the child's memory.
const MOST_THREADS: usize = 8;

/// Words for lack of memory in messages of Rust's runtime, which then aborts, and of the system.
const OUT_OF_MEMORY_TEXTS: [&str; 3] =
    ["memory allocation of", "Cannot allocate memory", "out of memory"];

/// The command of the child.
pub(super) struct Child<'a> {
    pub(super) program: &'a Path,
    pub(super) folder: &'a Path,
    /// Longest time that it may take.
    pub(super) time: Duration,
}

/// Variables of the worker's environment that the child gets. The worker's token is among the
/// others.
const PASSED_VARIABLES: [&str; 3] = ["BENDTWIN_LOG", "BENDTWIN_LOG_FORMAT", "RUST_BACKTRACE"];

/// Outcome of the child's work.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ChildOutcome {
    /// Observation, playback and report lie in the folder, and perhaps masks.
    Observed { verdict: Verdict },
    /// Masks, playback and report lie in the folder.
    Masked { verdict: Verdict },
    /// The report lies in the folder, and perhaps a playback and masks.
    Refused { verdict: Verdict, fault: Fault },
    /// The work needs more memory or time than it may take. The fault says which; the folder has no
    /// results.
    Exceeded { fault: Fault },
}

impl ChildOutcome {
    /// True if the work may end otherwise with more memory: a capture that takes more than there is, or than its
    /// reader grants itself, is exhausting.
    pub(super) fn may_lack_memory(&self) -> bool {
        match self {
            Self::Observed { .. } | Self::Masked { .. } => false,
            Self::Refused { fault, .. } => fault.category == Category::ResourceExhausted,
            Self::Exceeded { .. } => true,
        }
    }
}

impl Child<'_> {
    /// Runs the child to its end. Dropping the future kills it.
    ///
    /// # Errors
    /// If the child cannot be started, or ended without a final message.
    pub(super) async fn run(
        &self,
        progress: &LatestProgress,
        checkpoints: &Checkpoints,
    ) -> Result<ChildOutcome, Fault> {
        match tokio::time::timeout(self.time, self.run_without_end(progress, checkpoints)).await {
            Ok(ended) => ended,
            Err(_) => Ok(ChildOutcome::Exceeded { fault: timed_out(self.time) }),
        }
    }

    async fn run_without_end(
        &self,
        progress: &LatestProgress,
        checkpoints: &Checkpoints,
    ) -> Result<ChildOutcome, Fault> {
        let passed =
            PASSED_VARIABLES.iter().filter_map(|name| Some((name, std::env::var_os(name)?)));
        let mut child = Command::new(self.program)
            .arg("ingest-capture")
            .arg(self.folder)
            .env_clear()
            .envs(passed)
            .env("TMPDIR", self.folder)
            .env("RAYON_NUM_THREADS", threads().to_string())
            // Held open: the child exits when it ends, because the worker is gone then.
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .map_err(|e| crashed(&format!("it cannot be started: {e}")))?;
        let _stdin = child.stdin.take();
        let (Some(stdout), Some(stderr)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(crashed("its output cannot be read"));
        };
        let reading = self.read_messages(BufReader::new(stdout), progress, checkpoints);
        let (last, tail) = tokio::join!(reading, copy_log(stderr));
        let status = child.wait().await.map_err(|e| crashed(&e.to_string()))?;
        match last {
            Some(Message::Observed { verdict }) => Ok(ChildOutcome::Observed { verdict }),
            Some(Message::Masked { verdict }) => Ok(ChildOutcome::Masked { verdict }),
            // A file that cannot be read for lack of memory is not the file's fault.
            Some(Message::Refused { fault, .. }) if is_out_of_memory(&fault.message) => {
                Ok(ChildOutcome::Exceeded { fault: out_of_memory() })
            }
            Some(Message::Refused { verdict, fault }) => {
                Ok(ChildOutcome::Refused { verdict, fault })
            }
            Some(Message::Failed(fault)) => Err(fault),
            _ if is_out_of_memory(&tail) => Ok(ChildOutcome::Exceeded { fault: out_of_memory() }),
            _ if is_out_of_time(status) => {
                Ok(ChildOutcome::Exceeded { fault: timed_out(self.time) })
            }
            _ => Err(crashed(&describe_exit(status))),
        }
    }

    /// Passes on progress and checkpoints; returns the final message.
    async fn read_messages(
        &self,
        mut lines: impl AsyncBufRead + Unpin,
        progress: &LatestProgress,
        checkpoints: &Checkpoints,
    ) -> Option<Message> {
        let mut last = None;
        loop {
            let mut line = Vec::new();
            match (&mut lines).take(MAX_LINE).read_until(b'\n', &mut line).await {
                Ok(0) | Err(_) => return last,
                Ok(_) => {}
            }
            match serde_json::from_slice(&line) {
                Ok(Message::Progress(reported)) => progress.set(reported),
                Ok(Message::Confined(enforced)) => note(&enforced),
                Ok(Message::Checkpoint) => {
                    let path = self.folder.join(CHECKPOINT);
                    let reading = move || read_result(&path, MAX_CHECKPOINT);
                    let read = tokio::task::spawn_blocking(reading).await;
                    match read.unwrap_or_else(|e| Err(std::io::Error::other(e))) {
                        Ok(checkpoint) => checkpoints.submit(checkpoint, false),
                        Err(error) => tracing::warn!(%error, "a checkpoint cannot be read"),
                    }
                }
                Ok(message) => last = Some(message),
                Err(error) => tracing::warn!(%error, "the ingest process sent an invalid message"),
            }
        }
    }
}

/// Threads of the child.
pub(super) fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from).min(MOST_THREADS)
}

/// Logs what confines the child: loudly what lacks, but not for every capture.
fn note(enforced: &Enforced) {
    static WARNED: AtomicBool = AtomicBool::new(false);
    match enforced.lacking() {
        Some(lacking) if !WARNED.swap(true, Ordering::Relaxed) => tracing::warn!(
            "this system confines the process that reads captures only in part: {lacking}; its memory and time are \
             limited. --ingest-sandbox required reads nothing under such conditions"
        ),
        lacking => tracing::debug!(?lacking, "the process that reads the capture is confined"),
    }
}

/// Copies the child's log to the worker's; returns the end of it.
async fn copy_log(mut stderr: impl AsyncRead + Unpin) -> String {
    let mut tail = Vec::new();
    let mut chunk = [0; TAIL_BYTES];
    while let Ok(read) = stderr.read(&mut chunk).await {
        let Some(text) = chunk.get(..read).filter(|t| !t.is_empty()) else { break };
        eprint!("{}", String::from_utf8_lossy(text));
        tail.extend_from_slice(text);
        let surplus = tail.len().saturating_sub(TAIL_BYTES);
        tail.drain(..surplus);
    }
    String::from_utf8_lossy(&tail).into_owned()
}

fn is_out_of_memory(text: &str) -> bool {
    OUT_OF_MEMORY_TEXTS.iter().any(|words| text.contains(words))
}

fn out_of_memory() -> Fault {
    Fault {
        category: Category::ResourceExhausted,
        reason: "INGEST_OUT_OF_MEMORY".to_owned(),
        message: "reading the capture takes more memory than this worker gives it: split the capture, or \
                  start workers with a higher --ingest-memory-mib and run the ingest again"
            .to_owned(),
    }
}

fn timed_out(time: Duration) -> Fault {
    Fault {
        category: Category::ResourceExhausted,
        reason: "INGEST_TIMEOUT".to_owned(),
        message: format!(
            "reading the capture takes longer than the {} s that this worker gives it: split the capture, or start \
             workers with a higher --ingest-timeout-s and run the ingest again",
            time.as_secs()
        ),
    }
}

/// The fault for a user when the child ended unexpectedly; the details go to the worker's log.
fn crashed(how: &str) -> Fault {
    tracing::error!("the process that reads the capture failed: {how}");
    Fault {
        category: Category::Internal,
        reason: "INGEST_CRASHED".to_owned(),
        message: "the process that reads the capture ended unexpectedly; the worker's log says how. If it \
                  happens again the capture is damaged in a way that nobody thought of: please report it"
            .to_owned(),
    }
}

/// True if the system ended the process because its processor time was up.
#[cfg(unix)]
fn is_out_of_time(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt as _;
    status.signal() == Some(libc::SIGXCPU)
}

#[cfg(not(unix))]
fn is_out_of_time(_: ExitStatus) -> bool {
    false
}

#[cfg(unix)]
fn describe_exit(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt as _;
    match status.signal() {
        Some(signal) => format!("killed by signal {signal}"),
        None => status.to_string(),
    }
}

#[cfg(not(unix))]
fn describe_exit(status: ExitStatus) -> String {
    status.to_string()
}

#[cfg(test)]
mod tests;

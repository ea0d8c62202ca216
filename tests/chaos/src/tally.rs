//! The record of a run: counts, longest times, and promises that were broken, with a log of every line.

use std::{
    collections::BTreeMap,
    fmt,
    fs::File,
    io::Write as _,
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

/// The counts of a run.
#[derive(Debug)]
pub(crate) struct Tally {
    started: Instant,
    inner: Mutex<Inner>,
}

#[derive(Debug)]
struct Inner {
    counts: BTreeMap<String, u64>,
    longest: BTreeMap<String, Duration>,
    largest: BTreeMap<String, u64>,
    broken: BTreeMap<String, (u64, String)>,
    log: File,
}

impl Tally {
    /// A tally that logs to `chaos.log` in a folder.
    pub(crate) fn new(folder: &Path) -> std::io::Result<Self> {
        let inner = Inner {
            counts: BTreeMap::new(),
            longest: BTreeMap::new(),
            largest: BTreeMap::new(),
            broken: BTreeMap::new(),
            log: File::create(folder.join("chaos.log"))?,
        };
        Ok(Self { started: Instant::now(), inner: Mutex::new(inner) })
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A line of the log.
    pub(crate) fn log(&self, line: impl fmt::Display) {
        let at = self.started.elapsed().as_secs_f64();
        // A log that cannot be written is no fault of the server.
        writeln!(self.inner().log, "{at:9.3} {line}").ok();
    }

    /// A line of the log and of the terminal.
    pub(crate) fn say(&self, line: impl fmt::Display) {
        println!("{line}");
        self.log(line);
    }

    pub(crate) fn count(&self, what: impl Into<String>) {
        *self.inner().counts.entry(what.into()).or_default() += 1;
    }

    pub(crate) fn took(&self, what: impl Into<String>, time: Duration) {
        let mut inner = self.inner();
        let longest = inner.longest.entry(what.into()).or_default();
        *longest = time.max(*longest);
    }

    pub(crate) fn reached(&self, what: impl Into<String>, value: u64) {
        let mut inner = self.inner();
        let largest = inner.largest.entry(what.into()).or_default();
        *largest = value.max(*largest);
    }

    /// A broken promise: the promise, and the case.
    pub(crate) fn broken(&self, promise: impl Into<String>, case: impl fmt::Display) {
        let promise = promise.into();
        self.say(format_args!("BROKEN: {promise}: {case}"));
        self.inner().broken.entry(promise).or_insert_with(|| (0, case.to_string())).0 += 1;
    }

    pub(crate) fn largest(&self, what: &str) -> u64 {
        self.inner().largest.get(what).copied().unwrap_or(0)
    }

    /// Broken promises: how often, and the first case.
    pub(crate) fn all_broken(&self) -> Vec<(String, u64, String)> {
        let inner = self.inner();
        inner.broken.iter().map(|(p, (count, case))| (p.clone(), *count, case.clone())).collect()
    }

    /// The rows of the summary.
    pub(crate) fn rows(&self) -> Vec<(String, String)> {
        let inner = self.inner();
        let counts = inner.counts.iter().map(|(what, n)| (what.clone(), n.to_string()));
        let longest = inner.longest.iter();
        let longest = longest.map(|(what, t)| (what.clone(), format!("{:.1} s", t.as_secs_f64())));
        let largest = inner.largest.iter().map(|(what, n)| (what.clone(), n.to_string()));
        let mut rows: Vec<_> = counts.chain(longest).chain(largest).collect();
        rows.sort();
        rows
    }
}

//! Plan of a suite: the runs that have a valid result, and those that are pending.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use bendtwin_core::{Capture, Category, Fault, Views};

use crate::{
    Error, digest,
    folder::Folder,
    record::{Outcome, Record},
    run::PendingRun,
    suite::{CaptureEntry, RunId, Selection, Suite},
};

/// Options of a plan.
#[derive(Clone, Debug)]
pub struct PlanOptions {
    /// Folder of captures, if not the suite's.
    pub data: Option<PathBuf>,
    /// Selected runs; all if empty.
    pub only: Vec<Selection>,
    /// Build of the software that runs; results of another build are not valid.
    pub build: String,
    /// Results of other builds are valid, too.
    pub any_build: bool,
    /// Least time between checkpoints of a fit.
    pub checkpoint_every: Duration,
}

/// Reader of the capture at a path, with the views of its cameras if it is a raw recording; the fault is
/// the reason why it cannot be fitted.
pub type Read<'r> = dyn Fn(&Path) -> Result<(Capture, Option<Views>), Fault> + 'r;

/// A capture as it was read.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    pub(crate) capture: Result<Capture, Fault>,
    pub(crate) views: Option<Views>,
    /// Empty if it could not be read.
    pub(crate) digest: String,
}

/// The runs of a suite.
#[derive(Debug)]
pub struct Plan<'a> {
    pub(crate) suite: &'a Suite,
    pub(crate) folder: &'a Folder,
    pub(crate) options: PlanOptions,
    pub(crate) work: Vec<PendingRun>,
    pub(crate) kept: HashMap<RunId, Record>,
    /// The captures of selected runs, by name.
    pub(crate) sources: HashMap<&'a str, Arc<Source>>,
}

impl<'a> Plan<'a> {
    /// Reads the captures of the selected runs and finds existing results. A capture that cannot be
    /// read makes its runs fail; one that does not exist is an error here.
    ///
    /// # Errors
    /// If nothing is selected, captures are missing, or reading was cancelled.
    pub fn new(
        suite: &'a Suite,
        folder: &'a Folder,
        options: PlanOptions,
        read: &Read<'_>,
    ) -> Result<Self, Error> {
        for only in &options.only {
            if !suite.runs().any(|(id, ..)| only.contains(&id)) {
                return Err(Error::Selection(nothing(suite, only)));
            }
        }
        let (work, kept, sources) = (Vec::new(), HashMap::new(), HashMap::new());
        let mut plan = Self { suite, folder, options, work, kept, sources };
        plan.sources = plan.read_sources(read)?;
        for (id, capture, configuration) in suite.runs() {
            let record = folder.record(&id);
            let faults = |faults| Error::Suite { file: suite.file.clone(), faults };
            let settings = suite.settings(capture, configuration, id.seed).map_err(faults)?;
            let source = plan.sources.get(capture.name.as_str()).filter(|_| plan.is_selected(&id));
            let holds = |record: &Record| {
                let capture = source.map_or(&record.capture_digest, |s| &s.digest);
                let build =
                    if plan.options.any_build { &record.build } else { &plan.options.build };
                record.digest == digest::of_run(capture, &settings, build)
            };
            let record = record.filter(holds);
            let is_done = record.as_ref().is_some_and(Record::is_final);
            if let Some(source) = source.filter(|_| !is_done) {
                let build = plan.options.build.clone();
                let digest = digest::of_run(&source.digest, &settings, &build);
                let source = source.clone();
                plan.work.push(PendingRun { id: id.clone(), settings, source, build, digest });
            }
            plan.kept.extend(record.map(|record| (id, record)));
        }
        Ok(plan)
    }

    /// Number of runs that are still to be done.
    pub fn pending(&self) -> usize {
        self.work.len()
    }

    /// Number of selected runs whose results hold.
    pub fn done(&self) -> usize {
        self.kept.iter().filter(|(id, r)| self.is_selected(id) && r.is_final()).count()
    }

    /// All results of the suite that hold, selected or not, in the suite's order.
    pub fn records(&self) -> Vec<&Record> {
        self.suite.runs().filter_map(|(id, ..)| self.kept.get(&id)).collect()
    }

    /// Path of a capture of the suite.
    pub(crate) fn path_of(&self, capture: &CaptureEntry) -> PathBuf {
        self.suite.locate(capture, self.options.data.as_deref())
    }

    fn is_selected(&self, id: &RunId) -> bool {
        self.options.only.is_empty() || self.options.only.iter().any(|s| s.contains(id))
    }

    /// The captures that selected runs need.
    fn read_sources(&self, read: &Read<'_>) -> Result<HashMap<&'a str, Arc<Source>>, Error> {
        let needed = |c: &&CaptureEntry| {
            self.suite.runs().any(|(id, ..)| id.capture == c.name && self.is_selected(&id))
        };
        let needed: Vec<_> = self.suite.captures.iter().filter(needed).collect();
        let paths: Vec<PathBuf> = needed.iter().map(|c| self.path_of(c)).collect();
        let missing = needed.iter().zip(&paths).filter(|(_, path)| !path.exists());
        let faults: Vec<String> = missing
            .map(|(c, path)| format!("capture `{}`: there is no {}", c.name, path.display()))
            .collect();
        if !faults.is_empty() {
            return Err(Error::Suite { file: self.suite.file.clone(), faults });
        }
        let read = |(c, path): (&&'a CaptureEntry, PathBuf)| {
            Ok((c.name.as_str(), Arc::new(Source::new(path, read)?)))
        };
        needed.iter().zip(paths).map(read).collect()
    }
}

impl Source {
    fn new(path: PathBuf, read: &Read<'_>) -> Result<Self, Error> {
        let (capture, views) = match read(&path) {
            Ok((capture, views)) => (Ok(capture), views),
            Err(fault) => (Err(fault), None),
        };
        if capture.as_ref().is_err_and(|fault| fault.category == Category::Cancelled) {
            return Err(Error::Cancelled);
        }
        let digest = capture.as_ref().map(bendtwin_capture::digest).unwrap_or_default();
        Ok(Self { path, capture, views, digest })
    }
}

/// Message about a selection that matches no run, with the names that it could have matched.
fn nothing(suite: &Suite, only: &Selection) -> String {
    let captures: Vec<_> = suite.captures.iter().map(|c| c.name.as_str()).collect();
    let configurations: Vec<_> = suite.configurations.iter().map(|c| c.name.as_str()).collect();
    let seeds: Vec<_> = suite.seeds.iter().map(u64::to_string).collect();
    format!(
        "`{only}` names no run: captures are {}; configurations {}; seeds {}",
        captures.join(", "),
        configurations.join(", "),
        seeds.join(", ")
    )
}

impl Plan<'_> {
    /// Takes over a run's record.
    pub(crate) fn take(&mut self, record: Record) {
        self.kept.insert(record.run.clone(), record);
    }

    /// Number of selected runs that failed.
    pub fn failed(&self) -> usize {
        self.failures().iter().filter(|(id, _)| self.is_selected(id)).count()
    }

    /// All runs that failed, with why, in the suite's order.
    pub fn failures(&self) -> Vec<(&RunId, &Fault)> {
        self.records()
            .into_iter()
            .filter_map(|record| match &record.outcome {
                Outcome::Failed(fault) => Some((&record.run, fault)),
                Outcome::Finished(_) => None,
            })
            .collect()
    }
}

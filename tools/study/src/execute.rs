//! Parallel execution of runs: one at a time on each backend, in the suite's order, until all are
//! done or the plan is cancelled.

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
    thread,
};

use bendtwin_core::{CancelToken, Progress};
use bendtwin_engine::Backend;
use bendtwin_fit::OpenRasteriser;

use crate::{
    Error, Plan,
    record::{Outcome, Record},
    run::{RunContext, RunEnd},
    suite::RunId,
};

/// An event during the execution of a plan.
#[derive(Debug)]
pub enum Event<'a> {
    /// A run starts.
    Started {
        /// Id of the run.
        run: &'a RunId,
        /// True if it continues from a checkpoint.
        resumed: bool,
    },
    /// A run has made progress.
    Progress {
        /// Id of the run.
        run: &'a RunId,
        /// Progress of its fit.
        progress: Progress,
    },
    /// A run has finished or failed; its record is in the folder.
    Ended(&'a Record),
    /// A run was cancelled; the next start continues from its checkpoint.
    Interrupted(&'a RunId),
}

/// Devices that runs are computed on.
#[derive(Clone)]
pub struct Devices {
    /// Backends, each with one run at a time.
    pub backends: Vec<Arc<dyn Backend>>,
    /// Opens a rasteriser for the images of raw recordings.
    pub rasteriser: OpenRasteriser,
}

/// Numbers of runs by result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Runs that finished in this execution.
    pub finished: usize,
    /// Runs that failed in this execution.
    pub failed: usize,
    /// Runs that are still to be done.
    pub left: usize,
}

/// A message from a run's thread.
enum Message {
    Started(usize, bool),
    Progress(usize, Progress),
    Ended(usize, Result<RunEnd, Error>),
}

impl Plan<'_> {
    /// Executes the pending runs, on all backends in parallel, and takes over the results. Calls
    /// `tell` with every event.
    ///
    /// # Errors
    /// If the folder cannot be written to; then the token is cancelled, too.
    pub fn run(
        &mut self,
        devices: &Devices,
        cancel: &CancelToken,
        tell: &mut dyn FnMut(Event<'_>),
    ) -> Result<Summary, Error> {
        let (next, work) = (AtomicUsize::new(0), std::mem::take(&mut self.work));
        let (folder, checkpoint_every) = (self.folder, self.options.checkpoint_every);
        let (sender, receiver) = mpsc::channel::<Message>();
        let mut summary = Summary::default();
        let mut broken = None;
        let mut records = Vec::new();
        thread::scope(|scope| {
            let rasteriser = &devices.rasteriser;
            for backend in &devices.backends {
                let (sender, next, work) = (sender.clone(), &next, &work);
                scope.spawn(move || {
                    let context =
                        RunContext { folder, backend, rasteriser, checkpoint_every, cancel };
                    while !cancel.is_cancelled() {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(run) = work.get(index) else { break };
                        // The receiver outlives this thread.
                        let say = |message| drop(sender.send(message));
                        say(Message::Started(index, run.is_begun(folder)));
                        let end = run.run(&context, &|p| say(Message::Progress(index, p)));
                        let lost = end.as_ref().is_ok_and(device_is_lost);
                        say(Message::Ended(index, end));
                        if lost {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            for message in receiver {
                match message {
                    Message::Started(index, resumed) => {
                        tell(Event::Started { run: &work[index].id, resumed });
                    }
                    Message::Progress(index, progress) => {
                        tell(Event::Progress { run: &work[index].id, progress });
                    }
                    Message::Ended(_, Ok(RunEnd::Recorded(record))) => {
                        match record.outcome {
                            Outcome::Finished(_) => summary.finished += 1,
                            Outcome::Failed(_) => summary.failed += 1,
                        }
                        tell(Event::Ended(&record));
                        records.push(*record);
                    }
                    Message::Ended(index, Ok(RunEnd::Interrupted)) => {
                        tell(Event::Interrupted(&work[index].id));
                    }
                    Message::Ended(_, Err(error)) => {
                        cancel.cancel();
                        broken.get_or_insert(error);
                    }
                }
            }
        });
        summary.left = work.len() - summary.finished - summary.failed;
        let ended: Vec<RunId> = records.iter().map(|r| r.run.clone()).collect();
        self.work = work.into_iter().filter(|w| !ended.contains(&w.id)).collect();
        records.into_iter().for_each(|record| self.take(record));
        match broken {
            Some(error) => Err(error),
            None => Ok(summary),
        }
    }
}

/// True if the device failed. It does not recover within a process: the other runs wait for the
/// next one.
fn device_is_lost(end: &RunEnd) -> bool {
    match end {
        RunEnd::Recorded(record) => match &record.outcome {
            Outcome::Failed(fault) => fault.reason == "DEVICE_FAILED",
            Outcome::Finished(_) => false,
        },
        RunEnd::Interrupted => false,
    }
}

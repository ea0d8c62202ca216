//! Runs side by side: one at a time on each backend, in the suite's order, until all are done or someone cancels.

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

use crate::{
    Error, Plan,
    record::{Outcome, Record},
    run::{End, Site},
    suite::RunId,
};

/// What happens while a plan runs.
#[derive(Debug)]
pub enum Event<'a> {
    /// A run starts.
    Started {
        /// Which one.
        run: &'a RunId,
        /// Whether it goes on from a checkpoint.
        resumed: bool,
    },
    /// A run goes on.
    Progress {
        /// Which one.
        run: &'a RunId,
        /// How far it is.
        progress: Progress,
    },
    /// A run has ended, well or not; its record is in the folder.
    Ended(&'a Record),
    /// A run was cancelled; the next start goes on from its checkpoint.
    Interrupted(&'a RunId),
}

/// How a plan ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Runs that ended well now.
    pub finished: usize,
    /// Runs that failed now.
    pub failed: usize,
    /// Runs that are still to be done.
    pub left: usize,
}

/// What a run's thread tells.
enum Message {
    Started(usize, bool),
    Progress(usize, Progress),
    Ended(usize, Result<End, Error>),
}

impl Plan<'_> {
    /// Does what is to be done, on every backend at once, and takes the results over.
    ///
    /// # Errors
    /// If the folder cannot be written to; then the token is cancelled, too.
    pub fn run(
        &mut self,
        backends: &[Arc<dyn Backend>],
        cancel: &CancelToken,
        tell: &mut dyn FnMut(Event<'_>),
    ) -> Result<Tally, Error> {
        let (next, work) = (AtomicUsize::new(0), std::mem::take(&mut self.work));
        let (folder, checkpoint_every) = (self.folder, self.options.checkpoint_every);
        let (sender, receiver) = mpsc::channel::<Message>();
        let mut tally = Tally::default();
        let mut broken = None;
        let mut records = Vec::new();
        thread::scope(|scope| {
            for backend in backends {
                let (sender, next, work) = (sender.clone(), &next, &work);
                scope.spawn(move || {
                    let site = Site { folder, backend, checkpoint_every, cancel };
                    while !cancel.is_cancelled() {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(run) = work.get(index) else { break };
                        // Whoever listens outlives this thread.
                        let say = |message| drop(sender.send(message));
                        say(Message::Started(index, run.is_begun(folder)));
                        let end = run.run(&site, &|p| say(Message::Progress(index, p)));
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
                    Message::Ended(_, Ok(End::Recorded(record))) => {
                        match record.outcome {
                            Outcome::Finished(_) => tally.finished += 1,
                            Outcome::Failed(_) => tally.failed += 1,
                        }
                        tell(Event::Ended(&record));
                        records.push(*record);
                    }
                    Message::Ended(index, Ok(End::Interrupted)) => {
                        tell(Event::Interrupted(&work[index].id));
                    }
                    Message::Ended(_, Err(error)) => {
                        cancel.cancel();
                        broken.get_or_insert(error);
                    }
                }
            }
        });
        tally.left = work.len() - tally.finished - tally.failed;
        let ended: Vec<RunId> = records.iter().map(|r| r.run.clone()).collect();
        self.work = work.into_iter().filter(|w| !ended.contains(&w.id)).collect();
        records.into_iter().for_each(|record| self.take(record));
        match broken {
            Some(error) => Err(error),
            None => Ok(tally),
        }
    }
}

/// A device that failed does not heal within a process: what is left waits for the next one.
fn device_is_lost(end: &End) -> bool {
    match end {
        End::Recorded(record) => match &record.outcome {
            Outcome::Failed(fault) => fault.reason == "DEVICE_FAILED",
            Outcome::Finished(_) => false,
        },
        End::Interrupted => false,
    }
}

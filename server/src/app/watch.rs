//! Watching jobs: the current state, then every change, until the job has ended.

use std::time::Duration;

use bendtwin_core::ids::{CaptureId, FitId};
use bendtwin_store::{Job, JobId, Overview};
use futures::{Stream, StreamExt, stream};
use tokio::sync::broadcast::{Receiver, error::RecvError};

use super::{App, Error, Result};
use crate::access::Scope;

/// Time after which a job is read again without a notification, where other servers may have
/// changed it and their notifications come over a connection.
const LOOK_AGAIN: Duration = Duration::from_secs(5);

struct Watch {
    app: App,
    id: JobId,
    changes: Receiver<JobId>,
    /// Revisions up to this one have been sent.
    sent_revision: u64,
    ended: bool,
}

impl App {
    /// The revisions of a fit above `after`; only the newest if several arrive together. Ends after
    /// the terminal state, or with [`Error::Stopping`].
    pub(crate) async fn watch_fit(
        &self,
        name: &str,
        after: u64,
    ) -> Result<impl Stream<Item = Result<Job>> + Send + use<>> {
        let id: FitId = self.reach(Scope::FitsRead, name).await?;
        // Listen first, read second: no change in between is missed.
        let changes = self.store.jobs().changes();
        let fit = self.store.jobs().get(id).await?;
        Ok(self.watch(fit, changes, after))
    }

    /// A capture with each revision of its ingest above `after`, as [`App::watch_fit`].
    pub(crate) async fn watch_ingest(
        &self,
        name: &str,
        after: u64,
    ) -> Result<impl Stream<Item = Result<Overview>> + Send + use<>> {
        let id: CaptureId = self.reach(Scope::CapturesRead, name).await?;
        let changes = self.store.jobs().changes();
        let ingest = self.store.captures().overview(id).await?.ingest;
        let app = self.clone();
        Ok(
            self.watch(ingest, changes, after).then(move |ingest| {
                let app = app.clone();
                // As of now, but with the ingest as of the change: an end is sent once.
                async move {
                    Ok(Overview { ingest: ingest?, ..app.store.captures().overview(id).await? })
                }
            }),
        )
    }

    fn watch(
        &self,
        job: Job,
        changes: Receiver<JobId>,
        after: u64,
    ) -> impl Stream<Item = Result<Job>> + Send + use<> {
        let sent_revision = after.max(job.revision);
        let (id, ended) = (job.id, job.state.has_ended());
        let watch = Watch { app: self.clone(), id, changes, sent_revision, ended };
        let first = stream::iter((job.revision > after).then_some(Ok(job)));
        first.chain(stream::unfold(watch, Watch::next))
    }
}

impl Watch {
    async fn next(mut self) -> Option<(Result<Job>, Self)> {
        if self.ended {
            return None;
        }
        match self.wait().await {
            Ok(job) => {
                self.sent_revision = job.revision;
                self.ended = job.state.has_ended();
                Some((Ok(job), self))
            }
            Err(error) => {
                self.ended = true;
                Some((Err(error), self))
            }
        }
    }

    async fn wait(&mut self) -> Result<Job> {
        loop {
            let look_again = async {
                match self.app.store.is_shared() {
                    true => tokio::time::sleep(LOOK_AGAIN).await,
                    false => std::future::pending().await,
                }
            };
            let changed = tokio::select! {
                () = self.app.stopping.cancelled() => return Err(Error::Stopping),
                changed = self.changes.recv() => changed,
                () = look_again => Ok(self.id),
            };
            match changed {
                Ok(id) if id != self.id => continue,
                // Too many changes of other jobs to keep: read this one.
                Ok(_) | Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => return Err(Error::Stopping),
            }
            let job = self.app.store.jobs().get(self.id).await?;
            if job.revision > self.sent_revision || job.state.has_ended() {
                return Ok(job);
            }
        }
    }
}

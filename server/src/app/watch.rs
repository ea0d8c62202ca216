//! A fit as it changes: now, after every change, until it has ended.

use bendtwin_core::ids::FitId;
use bendtwin_store::Fit;
use futures::{Stream, StreamExt, stream};
use tokio::sync::broadcast::{Receiver, error::RecvError};

use super::{App, Error, Result};

struct Watch {
    app: App,
    id: FitId,
    changes: Receiver<FitId>,
    /// Revisions up to this one have been told.
    told: u64,
    ended: bool,
}

impl App {
    /// The revisions of a fit above `after`, newest only where several come at
    /// once. Ends after the terminal state, or with [`Error::Stopping`].
    pub(crate) async fn watch_fit(
        &self,
        name: &str,
        after: u64,
    ) -> Result<impl Stream<Item = Result<Fit>> + Send + use<>> {
        let id = super::name(name)?;
        // Listen first, read second: no change in between is missed.
        let changes = self.store.fits().changes();
        let fit = self.store.fits().get(id).await?;
        let ended = fit.state.has_ended();
        let watch = Watch { app: self.clone(), id, changes, told: after.max(fit.revision), ended };
        let first = stream::iter((fit.revision > after).then_some(Ok(fit)));
        Ok(first.chain(stream::unfold(watch, Watch::next)))
    }
}

impl Watch {
    async fn next(mut self) -> Option<(Result<Fit>, Self)> {
        if self.ended {
            return None;
        }
        match self.wait().await {
            Ok(fit) => {
                self.told = fit.revision;
                self.ended = fit.state.has_ended();
                Some((Ok(fit), self))
            }
            Err(error) => {
                self.ended = true;
                Some((Err(error), self))
            }
        }
    }

    async fn wait(&mut self) -> Result<Fit> {
        loop {
            let changed = tokio::select! {
                () = self.app.stopping.cancelled() => return Err(Error::Stopping),
                changed = self.changes.recv() => changed,
            };
            match changed {
                Ok(id) if id != self.id => continue,
                // Too many changes of others to keep: look for oneself.
                Ok(_) | Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => return Err(Error::Stopping),
            }
            let fit = self.app.store.fits().get(self.id).await?;
            if fit.revision > self.told || fit.state.has_ended() {
                return Ok(fit);
            }
        }
    }
}

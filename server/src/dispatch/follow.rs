//! Following of the workers of a fleet: each server watches each of them, whichever it was that they
//! registered at.

use std::{
    sync::{Arc, Weak},
    time::Duration,
};

use bendtwin_contract::rollout::REQUEST_BYTES;
use bendtwin_proto::worker::v1::{WatchRequest, WatchResponse};
use prost::Message as _;
use tonic::{Request, Status, Streaming};

use super::{Dispatch, Heartbeat, registry::Entry};

/// Least and most time before another attempt to watch a worker.
const AGAIN: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(5)];
/// Longest wait for the first word of a worker.
const FIRST_WORD: Duration = Duration::from_secs(3);

impl Dispatch {
    /// Watches a worker until its entry goes.
    pub(super) fn follow(&self, entry: &Arc<Entry>) {
        let (dispatch, gone) = (self.clone(), entry.gone.clone());
        let entry = Arc::downgrade(entry);
        tokio::spawn(async move {
            let [first, longest] = AGAIN;
            let mut wait = first;
            loop {
                let watched = tokio::select! {
                    () = gone.cancelled() => return,
                    watched = dispatch.watch(&entry) => watched,
                };
                match watched {
                    Ok(()) => wait = first,
                    Err(status) => {
                        tracing::debug!(%status, "a worker cannot be watched");
                        wait = (2 * wait).min(longest);
                    }
                }
                tokio::select! {
                    () = gone.cancelled() => return,
                    () = tokio::time::sleep(wait) => {}
                }
            }
        });
    }

    /// Passes on a worker's messages until the stream ends. An error if there were no messages.
    async fn watch(&self, entry: &Weak<Entry>) -> Result<(), Status> {
        let Some(known) = entry.upgrade() else { return Ok(()) };
        let mut messages = self.begin_to_watch(&known).await?;
        drop(known);
        loop {
            // One that is silent beyond the interval has a broken connection.
            let silence = self.fresh().max(FIRST_WORD);
            let message = tokio::time::timeout(silence, messages.message()).await;
            let (Ok(Ok(Some(message))), Some(entry)) = (message, entry.upgrade()) else {
                return Ok(());
            };
            self.take_in(&entry, heartbeat(message)?);
        }
    }

    /// Asks a worker what it has now. A missing answer is no error for the caller.
    pub(super) async fn ask(&self, entry: &Arc<Entry>) {
        let asked = self.begin_to_watch(entry);
        if let Ok(Err(status)) = tokio::time::timeout(FIRST_WORD, asked).await {
            tracing::debug!(worker = %entry.id(), %status, "a worker does not tell what it has");
        }
    }

    /// Begins to watch a worker, and takes its first word in.
    async fn begin_to_watch(&self, entry: &Arc<Entry>) -> Result<Streaming<WatchResponse>, Status> {
        let (mut client, token) = entry.client();
        let message = WatchRequest { interval_s: self.heartbeat_interval.as_secs_f64() };
        let length = message.encoded_len();
        let mut request = Request::new(message);
        request.metadata_mut().insert(REQUEST_BYTES, length.into());
        request.metadata_mut().insert("authorization", token);
        let mut messages = client.watch(request).await?.into_inner();
        let first = tokio::time::timeout(FIRST_WORD, messages.message()).await;
        let first = first.map_err(|_| Status::deadline_exceeded("no word in time"))??;
        let first = first.ok_or_else(|| Status::unavailable("the worker said nothing"))?;
        self.take_in(entry, heartbeat(first)?);
        Ok(messages)
    }

    /// Takes in what a worker says of itself. The facts of twins that it has loaded are read now: their
    /// rollouts are to be answered while the database is away.
    pub(super) fn take_in(&self, entry: &Entry, heartbeat: Heartbeat) {
        self.twins.prepare(&self.store, &heartbeat.warm);
        entry.heartbeat(self.now(), heartbeat);
    }
}

fn heartbeat(message: WatchResponse) -> Result<Heartbeat, Status> {
    Ok(message.heartbeat.unwrap_or_default().try_into()?)
}

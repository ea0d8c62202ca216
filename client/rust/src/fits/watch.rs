//! Watching a job through lost connections and server restarts.

use std::{
    pin::Pin,
    task::{Context, Poll},
    time::{Duration, Instant},
};

use bendtwin_core::ids::FitId;
use bendtwin_proto::v1::{self, WatchFitRequest, fit_service_client::FitServiceClient};
use futures::{Stream, StreamExt as _, stream::BoxStream};
use tonic::{Streaming, transport::Channel};

use crate::{Error, Fit};

/// How long a server may be away.
const PATIENCE: Duration = Duration::from_secs(60);
/// Between two attempts to reach it.
const PAUSE: Duration = Duration::from_millis(500);

/// The states of a job, from now until it has ended.
pub struct Watch(BoxStream<'static, Result<Fit, Error>>);

impl std::fmt::Debug for Watch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Watch")
    }
}

impl Stream for Watch {
    type Item = Result<Fit, Error>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_next_unpin(context)
    }
}

/// Where a watch stands.
struct Position {
    service: FitServiceClient<Channel>,
    name: FitId,
    after_revision: u64,
    stream: Option<Streaming<v1::Fit>>,
    /// Since when nothing was heard.
    silent_since: Option<Instant>,
    ended: bool,
}

pub(super) fn start(service: FitServiceClient<Channel>, name: FitId) -> Watch {
    let position = Position {
        service,
        name,
        after_revision: 0,
        stream: None,
        silent_since: None,
        ended: false,
    };
    Watch(
        futures::stream::unfold(position, |mut position| async move {
            let item = position.next().await?;
            Some((item, position))
        })
        .boxed(),
    )
}

impl Position {
    async fn next(&mut self) -> Option<Result<Fit, Error>> {
        while !self.ended {
            match self.advance().await {
                Ok(Some(fit)) => {
                    self.silent_since = None;
                    self.after_revision = fit.revision;
                    self.ended = fit.state.has_ended();
                    return Some(Ok(fit));
                }
                // The server closed the stream before the job's end: it shuts down.
                Ok(None) => self.stream = None,
                Err(error) => {
                    self.stream = None;
                    let since = *self.silent_since.get_or_insert_with(Instant::now);
                    if !error.is_transient() || since.elapsed() > PATIENCE {
                        self.ended = true;
                        return Some(Err(error));
                    }
                }
            }
            tokio::time::sleep(PAUSE).await;
        }
        None
    }

    async fn advance(&mut self) -> Result<Option<Fit>, Error> {
        let stream = match &mut self.stream {
            Some(stream) => stream,
            None => {
                let request = WatchFitRequest {
                    name: self.name.to_string(),
                    after_revision: self.after_revision,
                };
                self.stream.insert(self.service.watch_fit(request).await?.into_inner())
            }
        };
        stream.message().await?.map(Fit::try_from).transpose()
    }
}

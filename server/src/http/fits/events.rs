//! `/v1/fits/{id}/events` and `/v1/captures/{id}/events`: changes as server-sent events.

use std::{convert::Infallible, time::Duration};

use axum::{
    extract::State,
    http::HeaderMap,
    response::sse::{Event, KeepAlive, Sse},
};
use bendtwin_proto::json::{TensorFormat, Write};
use futures::{Stream, StreamExt};
use serde::Serialize;

use crate::{
    app::{self, App},
    grpc::convert,
    http::{Result, extract::Id},
};

const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Watch a fit
pub(in crate::http) async fn watch(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>> + Send>> {
    let fits = app.watch_fit(&id, last_seen(&headers)).await?;
    Ok(events("fit", fits, |fit| (fit.revision, convert::fit(fit))))
}

/// Watch a capture being read
pub(in crate::http) async fn watch_ingest(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>> + Send>> {
    let captures = app.watch_ingest(&id, last_seen(&headers)).await?;
    Ok(events("capture", captures, |c| (c.ingest.revision, convert::capture(c))))
}

/// The last revision that a client has seen. An id that is not from here, which a browser may send
/// after it read another stream, counts as none: the client then gets the newest again.
fn last_seen(headers: &HeaderMap) -> u64 {
    let text = headers.get("last-event-id").and_then(|v| v.to_str().ok());
    text.and_then(|t| t.trim().parse().ok()).unwrap_or(0)
}

/// An event for each change, with its revision.
fn events<T, M>(
    name: &'static str,
    changes: impl Stream<Item = app::Result<T>> + Send + 'static,
    resource: impl Fn(T) -> (u64, M) + Send + 'static,
) -> Sse<impl Stream<Item = Result<Event, Infallible>> + Send>
where
    T: Send + 'static,
    for<'m> Write<'m, M>: Serialize,
{
    // An error ends the stream: the client comes back with what it has seen.
    let good = changes.take_while(|change| std::future::ready(change.is_ok()));
    let events = good.filter_map(move |change| {
        let event = change.ok().and_then(|change| {
            let (revision, resource) = resource(change);
            let event = Event::default().event(name).id(revision.to_string());
            event
                .json_data(Write { message: &resource, tensors: TensorFormat::default() })
                .ok()
                .map(Ok)
        });
        std::future::ready(event)
    });
    Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE))
}

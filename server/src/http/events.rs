//! `/v1/fits/{id}/events`: a fit's changes as server-sent events.

use std::{convert::Infallible, time::Duration};

use axum::{
    extract::State,
    http::HeaderMap,
    response::sse::{Event, KeepAlive, Sse},
};
use futures::{Stream, StreamExt};

use super::{Result, extract::Id, resource::Fit};
use crate::{
    app::{App, Error},
    error::ProblemDocument,
};

const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Watch a fit
///
/// Server-sent events named `fit`, each with the whole fit as data and its
/// revision as id, until it has ended. `Last-Event-ID` skips what is known.
#[utoipa::path(get, path = "/v1/fits/{id}/events", tag = "fits",
    params(("id" = String, Path),
        ("Last-Event-ID" = Option<u64>, Header, description = "Skip revisions up to this one")),
    responses((status = 200, body = String, content_type = "text/event-stream"),
        (status = "default", body = ProblemDocument)))]
pub(super) async fn watch(
    State(app): State<App>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>> + Send>> {
    let after = match headers.get("last-event-id").map(|v| v.to_str()) {
        None => 0,
        Some(text) => text
            .ok()
            .and_then(|t| t.trim().parse().ok())
            .ok_or_else(|| Error::invalid("last-event-id", "is not a revision"))?,
    };
    let fits = app.watch_fit(&id, after).await?;
    // An error ends the stream: the client comes back with what it has seen.
    let events = fits.take_while(|fit| std::future::ready(fit.is_ok())).filter_map(async |fit| {
        let fit = fit.ok()?;
        let event = Event::default().event("fit").id(fit.revision.to_string());
        event.json_data(Fit::from(fit)).ok().map(Ok)
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE)))
}

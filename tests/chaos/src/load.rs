//! The honest load: a few clients that use everything, and write down what is acknowledged.

mod captures;
mod fits;
pub(crate) mod rollouts;
pub(crate) mod sessions;
pub(crate) mod uploads;

use std::sync::Arc;

use bytes::Bytes;
use reqwest::Method;
use tokio::task::JoinSet;

use crate::{
    honest::{Answer, Refusal, send},
    ledger::Fate,
    run::Run,
};

/// Starts all clients; each ends by itself when the load ends.
pub(crate) fn start(run: &Arc<Run>) -> JoinSet<()> {
    let mut clients = JoinSet::new();
    clients.spawn_local(captures::client(run.clone(), 0));
    clients.spawn_local(captures::client(run.clone(), 1));
    clients.spawn_local(uploads::client(run.clone(), 2));
    clients.spawn_local(fits::client(run.clone(), 3));
    clients.spawn_local(rollouts::grpc_client(run.clone(), 4));
    clients.spawn_local(rollouts::json_client(run.clone(), 5));
    clients.spawn_local(sessions::client(run.clone(), 6));
    clients
}

impl Run {
    /// Stores the twin of the rollouts.
    pub(crate) async fn import_twin(&self) -> anyhow::Result<()> {
        let twin = self.api().import(self.references.twin()).await?;
        self.ledger.twin(&twin.name, &twin.digest, false);
        *self.twin.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = twin.name;
        Ok(())
    }

    /// Uploads an archive and records it in the ledger. A second answer to the same request has to
    /// name the same capture.
    pub(crate) async fn upload(
        &self,
        over_http: bool,
        number: usize,
        display_name: &str,
        request_id: &str,
    ) -> Option<String> {
        let archive = &self.references.archives[number];
        let (api, http) = (self.api(), self.http());
        let name = self.expect("an upload", async || {
            if !over_http {
                let stored = api.upload_as(&archive.content, display_name, request_id).await?;
                return Ok((stored.name, stored.digest));
            }
            let path = format!("/v1/captures?display_name={display_name}");
            let request = http
                .request(Method::POST, &path)
                .header("content-type", "application/zip")
                .header("idempotency-key", request_id)
                .body(archive.content.clone());
            let stored = json(&send(request).await?.1)?;
            let text = |field: &str| stored[field].as_str().unwrap_or_default().to_owned();
            Ok((text("name"), text("digest")))
        });
        let (name, digest) = name.await?;
        if digest != archive.digest {
            let case = format_args!("{name} has {digest}, sent was {}", archive.digest);
            self.tally.broken("content is stored as it was sent", case);
        }
        Some(name)
    }

    /// Deletes a capture, a twin or a fit, by its name: for good, or to the trash. It stays if it is in
    /// use. Returns true if the first attempt was answered with success.
    pub(crate) async fn delete(&self, name: &str, purge: bool) -> bool {
        let http = self.http();
        let path = format!("/v1/{name}{}", if purge { "?purge=true" } else { "" });
        self.ledger.fate(name, Fate::Leaving);
        let mut attempts = 0;
        let answer = self.insist("a deletion", async || {
            attempts += 1;
            send(http.request(Method::DELETE, &path)).await
        });
        let fate = match answer.await {
            Some(Ok(_)) => Fate::Deleted,
            // An attempt before this one was carried out and not answered.
            Some(Err(refusal)) if refusal.is("NOT_FOUND") || refusal.is("IN_TRASH") => {
                Fate::Deleted
            }
            Some(Err(refusal)) => {
                self.tally.log(format_args!("{name} stays: {refusal:?}"));
                Fate::Kept
            }
            None => Fate::Leaving,
        };
        if fate == Fate::Deleted {
            self.tally.count("acknowledged: deletions");
        }
        self.ledger.fate(name, fate);
        fate == Fate::Deleted && attempts == 1
    }

    /// Restores what was deleted by one attempt. Returns true if it is back: the first attempt was
    /// answered with success, so that no attempt is still under way that could change its fate.
    pub(crate) async fn restore(&self, name: &str) -> bool {
        let http = self.http();
        self.ledger.fate(name, Fate::Leaving);
        let mut attempts = 0;
        let answer = self.insist("a restoration", async || {
            attempts += 1;
            send(http.request(Method::POST, &format!("/v1/{name}/undelete"))).await
        });
        let fate = match answer.await {
            Some(Ok(_)) if attempts == 1 => Fate::Kept,
            // It was purged, when it was due or for the disk.
            Some(Err(refusal)) if attempts == 1 && refusal.is("NOT_FOUND") => Fate::Deleted,
            Some(Err(refusal)) if !refusal.is("NOT_FOUND") => {
                let case = format_args!("a restoration of {name}: {refusal:?}");
                self.tally.broken("honest calls are not refused", case);
                Fate::Leaving
            }
            _ => Fate::Leaving,
        };
        match fate {
            Fate::Kept => self.tally.count("acknowledged: restorations"),
            Fate::Deleted => self.tally.count("honest calls: restorations that came too late"),
            Fate::Leaving => {}
        }
        self.ledger.fate(name, fate);
        fate == Fate::Kept
    }

    /// Content over HTTP.
    pub(crate) async fn content(&self, name: &str) -> Option<Bytes> {
        self.part(name, "content").await
    }

    /// A part of a resource.
    pub(crate) async fn part(&self, name: &str, part: &str) -> Option<Bytes> {
        let http = self.http();
        let path = format!("/v1/{name}/{part}");
        let download =
            async || -> Answer<Bytes> { Ok(send(http.request(Method::GET, &path)).await?.1) };
        self.expect("a download", download).await
    }
}

/// JSON of a good answer.
pub(crate) fn json(body: &[u8]) -> Answer<serde_json::Value> {
    serde_json::from_slice(body).map_err(|e| Refusal::Later(format!("an answer of no JSON: {e}")))
}

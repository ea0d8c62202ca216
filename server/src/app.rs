//! The use cases, free of transport: HTTP and gRPC both call them. Arguments are checked here, so
//! that both refuse the same requests with the same words.

mod captures;
mod disk;
mod evaluations;
mod fits;
mod geometry;
mod ingests;
mod jobs;
mod keys;
mod labels;
mod members;
mod requirements;
mod results;
mod twins;
mod upload;
mod uploads;
mod watch;
mod workers;

use std::{str::FromStr, sync::Arc};

use bendtwin_core::{
    ids::{InvalidName, ServerId},
    settings::layers,
};
use bendtwin_store::Store;
use serde::de::DeserializeOwned;
use tokio_util::sync::CancellationToken;

pub(crate) use crate::error::{Error, Result};
use crate::{
    access::KeyRing, dispatch::Dispatch, memory::Memory, metrics::Metrics, options::Options,
    play::Plays, readiness::Readiness, tls::Certificates, tokens::Tokens,
};

pub(crate) use fits::FitOrder;
pub(crate) use geometry::Geometry;
pub(crate) use ingests::{IngestPart, IngestUpload};
pub(crate) use jobs::{Attempt, LeasedJob, News, Offer};
pub(crate) use keys::KeyOrder;
pub(crate) use labels::Listing;
use members::Members;
pub(crate) use requirements::of as requirements_of;
pub(crate) use upload::Body;
pub(crate) use uploads::{ALGORITHMS, Append, Checksum, NewUpload, capture_name};

/// The application. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct App {
    inner: Arc<Inner>,
}

#[derive(Debug)]
pub(crate) struct Inner {
    /// The id of this start.
    pub(crate) id: ServerId,
    pub(crate) options: Options,
    pub(crate) store: Store,
    pub(crate) dispatch: Dispatch,
    pub(crate) tokens: Tokens,
    pub(crate) keys: KeyRing,
    pub(crate) metrics: Metrics,
    pub(crate) readiness: Readiness,
    pub(crate) memory: Memory,
    pub(crate) plays: Plays,
    members: Members,
    /// Cancelled when the server begins to stop: streams end then.
    pub(crate) stopping: CancellationToken,
    pub(crate) certificates: Certificates,
}

impl std::ops::Deref for App {
    type Target = Inner;
    fn deref(&self) -> &Inner {
        &self.inner
    }
}

impl App {
    pub(crate) fn new(options: Options, store: Store, certificates: Certificates) -> Self {
        let metrics = Metrics::new();
        let memory = Memory::new(options.memory_bytes());
        let (of_store, counted) = (store.clone(), metrics.clone());
        let dialer = certificates.dialer();
        let inner = Inner {
            id: ServerId::generate(),
            members: Members::default(),
            dispatch: Dispatch::new(&options, of_store, counted, memory.clone(), dialer),
            tokens: Tokens::new(options.worker_token.as_deref()),
            keys: KeyRing::new(store.clone()),
            metrics,
            readiness: Readiness::default(),
            memory,
            plays: Plays::new(&options.limits),
            stopping: CancellationToken::new(),
            certificates,
            options,
            store,
        };
        Self { inner: Arc::new(inner) }
    }
}

/// Parses a resource name.
pub(crate) fn name<T: FromStr<Err = InvalidName>>(text: &str) -> Result<T> {
    text.parse().map_err(Error::Name)
}

/// Parses the name of an optional filter; empty means none.
pub(crate) fn optional_name<T: FromStr<Err = InvalidName>>(text: &str) -> Result<Option<T>> {
    if text.is_empty() { Ok(None) } else { name(text).map(Some) }
}

/// Checks an idempotency key; empty means none.
fn request_id(text: String) -> Result<Option<String>> {
    const MAX_LENGTH: usize = 128;
    if text.is_empty() {
        return Ok(None);
    }
    if text.chars().count() > MAX_LENGTH || text.chars().any(char::is_control) {
        let rule = format!("must be up to {MAX_LENGTH} characters without control characters");
        return Err(Error::invalid("request_id", rule));
    }
    Ok(Some(text))
}

/// Parses a BLAKE3 digest; empty means none.
pub(crate) fn digest(text: &str) -> Result<Option<bendtwin_store::Digest>> {
    if text.is_empty() {
        return Ok(None);
    }
    bendtwin_store::Digest::from_hex(text)
        .map(Some)
        .map_err(|_| Error::invalid("digest", "is not 64 hexadecimal digits of a BLAKE3 digest"))
}

/// Settings of a request; the defaults if the document is empty.
fn read_settings<T: DeserializeOwned + Default>(json: &str, limit: usize) -> Result<T> {
    if json.len() > limit {
        return Err(Error::invalid("settings_json", format!("is longer than {limit} bytes")));
    }
    if json.trim().is_empty() {
        return Ok(T::default());
    }
    let document =
        serde_json::from_str(json).map_err(|e| Error::Settings(vec![format!("no JSON: {e}")]))?;
    layers::read(document).map_err(Error::Settings)
}

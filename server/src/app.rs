//! The use cases, free of transport: HTTP, gRPC and plays call methods of [`App`] alone, and nothing
//! outside of this module reaches the store, the routing or the memory behind it, but for the gate
//! of requests (`access/`). Arguments are checked here, so that all refuse the same requests with
//! the same words.

mod captures;
mod fits;
mod ingests;
mod jobs;
mod keys;
mod labels;
mod operations;
mod projects;
mod receive;
mod renewed;
mod requirements;
mod rights;
mod shares;
mod simulation;
mod storage;
mod sweeps;
mod twins;
mod uploads;
mod watch;
mod workers;

use std::{str::FromStr, sync::Arc, time::Duration};

use bendtwin_core::{
    ids::{InvalidName, ServerId},
    settings::layers,
};
use bendtwin_play::Plays;
use bendtwin_store::Store;
use serde::de::DeserializeOwned;
use tokio::sync::Notify;
use tokio_util::sync::{CancellationToken, WaitForCancellationFutureOwned};

use crate::{
    access::{Gate, KeyRing, Refusals, Tokens},
    dispatch::Dispatch,
    memory::Memory,
    metrics::Metrics,
    options::Options,
    sign_in::SignIn,
    tls::Certificates,
};
pub(crate) use crate::{
    dispatch::{
        InParts, Parts, Plan, Register, Registered, ReplyHold, RollOut, Step, Whole, WorkerView,
    },
    error::{Error, Result},
};

pub(crate) use fits::FitOrder;
pub(crate) use ingests::{IngestPart, IngestUpload};
pub(crate) use jobs::{LeasedJob, News, Offer};
use keys::usage::KnownUsage;
pub(crate) use keys::{KeyOrder, WhoAmI};
pub(crate) use labels::Listing;
pub(crate) use operations::Check;
use operations::{Readiness, StoredNumbers};
pub(crate) use projects::ProjectOrder;
pub(crate) use receive::Body;
pub(crate) use requirements::of as requirements_of;
pub(crate) use rights::{name, name_of_worker, whole_name};
pub(crate) use shares::ShareOrder;
use shares::SharedPlays;
pub(crate) use sweeps::Sweeps;
use twins::Drawing;
pub(crate) use twins::{Exported, Geometry, Shown, SurfaceReply};
pub(crate) use uploads::{ALGORITHMS, Append, Checksum, NewUpload, capture_name};
use workers::Members;

/// The application. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct App {
    inner: Arc<Inner>,
}

/// What the use cases work with; its fields are theirs alone.
#[derive(Debug)]
pub(crate) struct Inner {
    /// The id of this start.
    id: ServerId,
    options: Options,
    store: Store,
    dispatch: Dispatch,
    tokens: Tokens,
    keys: KeyRing,
    /// Sign-in of people, if the server has an identity provider.
    sign_in: Option<SignIn>,
    /// Refused sign-ins in the audit, and failed ones in the log.
    refused_sign_ins: Refusals,
    failed_sign_ins: Refusals,
    metrics: Metrics,
    readiness: Readiness,
    stored_numbers: StoredNumbers,
    memory: Memory,
    drawing: Drawing,
    plays: Plays,
    shared_plays: SharedPlays,
    members: Members,
    known_usage: KnownUsage,
    /// Notified when the disk may be short of space that the trash has.
    room_wanted: Notify,
    /// Cancelled when the server begins to stop: streams end then.
    stopping: CancellationToken,
    certificates: Certificates,
}

/// For the use cases: outside of this module there is nothing to see.
impl std::ops::Deref for App {
    type Target = Inner;
    fn deref(&self) -> &Inner {
        &self.inner
    }
}

impl App {
    pub(crate) fn new(
        options: Options,
        store: Store,
        certificates: Certificates,
        metrics: Metrics,
        sign_in: Option<SignIn>,
    ) -> Self {
        let memory = Memory::new(options.memory_bytes());
        let stopping = CancellationToken::new();
        let dispatch = Dispatch::new(
            &options,
            store.clone(),
            metrics.clone(),
            memory.clone(),
            certificates.dialer(),
            stopping.clone(),
        );
        let inner = Inner {
            id: ServerId::generate(),
            members: Members::default(),
            known_usage: KnownUsage::default(),
            room_wanted: Notify::new(),
            dispatch,
            tokens: Tokens::new(options.worker_token.as_deref()),
            keys: KeyRing::new(store.clone(), options.quotas.to_store()),
            sign_in,
            refused_sign_ins: Refusals::default(),
            failed_sign_ins: Refusals::default(),
            metrics,
            readiness: Readiness::default(),
            stored_numbers: StoredNumbers::default(),
            memory,
            drawing: Drawing::default(),
            shared_plays: SharedPlays::default(),
            plays: Plays::new(options.limits.plays(), stopping.clone()),
            stopping,
            certificates,
            options,
            store,
        };
        Self { inner: Arc::new(inner) }
    }

    /// The options of the server.
    pub(crate) fn options(&self) -> &Options {
        &self.options
    }

    /// The gate of requests, which lets the token and the keys of this server in.
    pub(crate) fn gate(&self, token: Option<&str>) -> Gate {
        Gate::new(token, self.keys.clone(), self.store.clone())
    }

    /// Waits until the server begins to stop.
    pub(crate) fn stopped(&self) -> WaitForCancellationFutureOwned {
        self.stopping.clone().cancelled_owned()
    }

    /// True once the server has begun to stop.
    pub(crate) fn is_stopping(&self) -> bool {
        self.stopping.is_cancelled()
    }

    /// Begins to stop: ends streams, and waits up to `limit` for plays to close their sessions while
    /// workers still run.
    pub(crate) async fn stop(&self, limit: Duration) {
        self.stopping.cancel();
        let _ = tokio::time::timeout(limit, self.plays.ended()).await;
    }

    /// Stores what is known only here, and closes the store.
    pub(crate) async fn close(&self) {
        if let Err(error) = self.keys.record_uses().await {
            tracing::warn!(%error, "the last uses of keys are not recorded");
        }
        if let Err(error) = self.store.servers().forget(self.id).await {
            tracing::warn!(%error, "other servers wait for a lease until they take this one for gone");
        }
        self.store.close().await;
    }
}

/// Parses the name of an optional filter, which selects among what the caller reaches; empty means
/// none.
fn optional_name<T: FromStr<Err = InvalidName>>(text: &str) -> Result<Option<T>> {
    if text.is_empty() { Ok(None) } else { text.parse().map(Some).map_err(Error::Name) }
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

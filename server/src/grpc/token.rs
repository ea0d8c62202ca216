//! The worker token and the worker's key, checked before a call of `WorkerLink` is decoded.

use bendtwin_contract::worker_key;
use bendtwin_core::ids::WorkerId;
use tonic::{Request, Status, service::Interceptor};

use crate::{
    access::Bearer,
    app::{self, App, Error},
};

/// Interceptor that refuses calls without a valid worker token, and notes on the others whose it
/// is.
#[derive(Clone, Debug)]
pub(super) struct TokenCheck(pub(super) App);

/// A valid token, as a call showed it, and the key of the worker that calls.
#[derive(Clone)]
pub(super) struct Credentials {
    pub(super) bearer: Bearer,
    pub(super) token: String,
    key: String,
}

impl Credentials {
    /// The worker of this name, if it is the one that calls.
    ///
    /// # Errors
    /// If the name is invalid, or the key belongs to another worker.
    pub(super) fn worker(&self, name: &str) -> app::Result<WorkerId> {
        let worker = app::name(name)?;
        if worker_key::proves(&self.key, worker) {
            return Ok(worker);
        }
        Err(Error::WorkerKeyMismatch(worker.to_string()))
    }

    /// True if the key is the one of this worker.
    pub(super) fn is(&self, worker: WorkerId) -> bool {
        worker_key::proves(&self.key, worker)
    }
}

impl Interceptor for TokenCheck {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        let entry = |name| request.metadata().get(name).and_then(|v| v.to_str().ok());
        let token = entry("authorization")
            .and_then(|v| v.strip_prefix("Bearer "))
            .ok_or(Error::BadToken)?;
        let bearer = self.0.bearer(token).ok_or(Error::BadToken)?;
        let key = entry(worker_key::METADATA).unwrap_or_default().to_owned();
        let shown = Credentials { bearer, token: token.to_owned(), key };
        request.extensions_mut().insert(shown);
        Ok(request)
    }
}

/// The token that a call showed.
pub(super) fn shown<T>(request: &Request<T>) -> app::Result<Credentials> {
    request.extensions().get().cloned().ok_or(Error::BadToken)
}

//! The worker token, checked before a call of `WorkerLink` is decoded.

use tonic::{Request, Status, service::Interceptor};

use crate::{
    app::{self, App, Error},
    tokens::Bearer,
};

/// Interceptor that refuses calls without a valid worker token, and notes on the others whose it
/// is.
#[derive(Clone, Debug)]
pub(super) struct TokenCheck(pub(super) App);

/// A valid token, as a call showed it.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) bearer: Bearer,
    pub(super) token: String,
}

impl Interceptor for TokenCheck {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        let token = request
            .metadata()
            .get("authorization")
            .and_then(|v| v.to_str().ok())
            .and_then(|v| v.strip_prefix("Bearer "))
            .ok_or(Error::BadToken)?;
        let bearer = self.0.tokens.bearer(token).ok_or(Error::BadToken)?;
        let shown = Shown { bearer, token: token.to_owned() };
        request.extensions_mut().insert(shown);
        Ok(request)
    }
}

/// The token that a call showed.
pub(super) fn shown<T>(request: &Request<T>) -> app::Result<Shown> {
    request.extensions().get().cloned().ok_or(Error::BadToken)
}

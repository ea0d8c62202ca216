//! Sign-in of people, with the identity provider of the server.

use std::time::Duration;

use bendtwin_proto::v1::{
    self, CreateSignInRequest, DeleteSignInRequest, GetCallerRequest, StartDeviceSignInRequest,
    sign_in_service_client::SignInServiceClient,
};
use jiff::Timestamp;
use serde::Serialize;

use crate::{Error, Key, MadeKey, client::Channel, resources::resource};

resource! { v1::Caller =>
/// A caller, as the server knows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Caller {
    /// Owner of what it makes: `local` with the token of the server, empty where none is required.
    pub owner: String,
    /// Scopes, sorted.
    pub scopes: Vec<String>,
    /// Name of the key; empty without one.
    pub key: String,
    /// True if the key comes from a sign-in.
    pub is_sign_in: bool,
    /// Time from which the key is refused, if there is one.
    pub expire_time: Option<Timestamp>,
}
}

/// A sign-in that a person has to confirm in a browser.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceCode {
    /// Shown by [`SignIns::create`]; a secret.
    pub device_code: String,
    /// What the person enters.
    pub user_code: String,
    /// Where.
    pub verification_uri: String,
    /// The same with the code in it; empty if the provider has no such address.
    pub verification_uri_complete: String,
    /// Least time between two attempts.
    pub interval: Duration,
    /// Time after which the code is not accepted any more.
    pub expires_in: Duration,
}

/// Delay before another attempt if none is stated, and its increase if attempts are too frequent.
const MORE: Duration = Duration::from_secs(5);

/// Calls about sign-ins.
#[derive(Clone, Debug)]
pub struct SignIns {
    service: SignInServiceClient<Channel>,
}

impl SignIns {
    pub(crate) fn new(service: SignInServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Begins a sign-in that a person confirms in a browser, anywhere.
    ///
    /// # Errors
    /// If the server has no identity provider, or that has no sign-in for devices; or if either does
    /// not answer.
    pub async fn start_device(&self) -> Result<DeviceCode, Error> {
        let reply = self.service.clone().start_device_sign_in(StartDeviceSignInRequest {}).await?;
        let v1::StartDeviceSignInResponse {
            device_code,
            user_code,
            verification_uri,
            verification_uri_complete,
            interval_s,
            expires_in_s,
        } = reply.into_inner();
        let time = |seconds: f64| Duration::try_from_secs_f64(seconds).map_err(Error::malformed);
        Ok(DeviceCode {
            device_code,
            user_code,
            verification_uri,
            verification_uri_complete,
            interval: time(interval_s)?.max(Duration::from_millis(100)),
            expires_in: time(expires_in_s)?,
        })
    }

    /// The key of a sign-in; as long as the person has not confirmed it, or something fails that may
    /// pass, the delay until the next attempt. `delay` is that before this one: first the interval of
    /// the code.
    ///
    /// # Errors
    /// If the person refused, or may not use the server; or if the code has expired.
    pub async fn create(
        &self,
        code: &DeviceCode,
        delay: Duration,
    ) -> Result<Result<MadeKey, Duration>, Error> {
        let device_code = code.device_code.clone();
        let request = CreateSignInRequest { device_code, ..CreateSignInRequest::default() };
        let reply = match self.service.clone().create_sign_in(request).await.map_err(Error::from) {
            Ok(reply) => reply.into_inner(),
            Err(error) => return next_delay(&error, delay).map(Err).ok_or(error),
        };
        let key: Key = reply.key.ok_or_else(|| Error::malformed("no key"))?.try_into()?;
        Ok(Ok(MadeKey { key, secret_key: reply.secret_key }))
    }

    /// Signs out: revokes the key that this client shows if it comes from a sign-in.
    ///
    /// # Errors
    /// If the key is refused, or the server cannot be asked.
    pub async fn delete(&self) -> Result<(), Error> {
        self.service.clone().delete_sign_in(DeleteSignInRequest {}).await?;
        Ok(())
    }

    /// The caller that this client is to the server.
    ///
    /// # Errors
    /// If the server refuses what the client shows, or cannot be asked.
    pub async fn caller(&self) -> Result<Caller, Error> {
        self.service.clone().get_caller(GetCallerRequest {}).await?.into_inner().try_into()
    }
}

/// Delay before the next attempt, if there is to be one after this error; `last` is the previous one.
fn next_delay(error: &Error, last: Duration) -> Option<Duration> {
    match error.reason() {
        "SIGN_IN_PENDING" => Some(last),
        // For all further attempts (RFC 8628, 3.5).
        "SIGN_IN_SLOW_DOWN" => Some(last + MORE),
        _ if error.retry_after().is_some() || error.is_transient() => {
            Some(last.max(error.retry_after().unwrap_or(MORE)))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use bendtwin_core::Category;
    use tonic_types::StatusExt as _;

    use super::*;

    #[test]
    fn what_may_pass_is_tried_again() {
        let next = |category, reason, last| {
            next_delay(&Error::new(category, reason, "text"), Duration::from_secs(last))
                .map(|delay| delay.as_secs())
        };
        let refused = Category::FailedPrecondition;
        assert_eq!(next(refused, "SIGN_IN_PENDING", 1), Some(1));
        assert_eq!(next(refused, "SIGN_IN_SLOW_DOWN", 10), Some(15));
        assert_eq!(next(refused, "SIGN_IN_SLOW_DOWN", 15), Some(20));
        assert_eq!(next(Category::Unavailable, "SIGN_IN_PROVIDER_AWAY", 2), Some(5));
        assert_eq!(next(Category::PermissionDenied, "SIGN_IN_REFUSED", 5), None);
        let busy = tonic::Status::with_error_details(
            tonic::Code::ResourceExhausted,
            "busy",
            tonic_types::ErrorDetails::with_retry_info(Some(Duration::from_secs(7))),
        );
        assert_eq!(next_delay(&Error::from(busy), Duration::ZERO).unwrap().as_secs(), 7);
        let without = tonic::Status::resource_exhausted("busy");
        assert_eq!(next_delay(&Error::from(without), Duration::ZERO), None);
    }
}

//! Errors of a sign-in.

use std::time::Duration;

use bendtwin_core::Problem;

/// Delay before another attempt where something has to become free or come back.
const SOON: Duration = Duration::from_secs(5);
/// Longest text of the provider that is passed on [characters].
const LONGEST: usize = 200;

/// Reason for which nobody was signed in.
#[derive(Clone, Debug, thiserror::Error, Problem)]
pub(crate) enum Error {
    #[error(
        "people cannot sign in here, because the server has no identity provider (option sign_in): \
         use a key, or the token of the server"
    )]
    #[problem(FailedPrecondition, "SIGN_IN_OFF")]
    Off,
    #[error("the identity provider does not answer: {0}: retry; keys are accepted meanwhile")]
    #[problem(Unavailable, "SIGN_IN_PROVIDER_AWAY", retry = SOON)]
    Away(String),
    #[error("the identity provider sent {what} that cannot be used: {fault}: tell the operator")]
    #[problem(FailedPrecondition, "SIGN_IN_PROVIDER_UNUSABLE")]
    Unusable { what: &'static str, fault: String },
    #[error("the identity provider refused: {0}: sign in again")]
    #[problem(PermissionDenied, "SIGN_IN_REFUSED")]
    Refused(String),
    #[error("nobody has confirmed the code yet: retry in {} s", .delay.as_secs())]
    #[problem(FailedPrecondition, "SIGN_IN_PENDING", retry = *delay)]
    Pending { delay: Duration },
    #[error(
        "the ID token is not accepted: {0}: sign in again, and tell the operator if it stays so"
    )]
    #[problem(PermissionDenied, "SIGN_IN_TOKEN_INVALID")]
    Token(String),
    #[error("{0}: ask the operator of this server")]
    #[problem(PermissionDenied, "SIGN_IN_NOT_ALLOWED")]
    NotAllowed(String),
    #[error("too many sign-ins have begun: retry in {} s", SOON.as_secs())]
    #[problem(ResourceExhausted, "SIGN_IN_BUSY", retry = SOON)]
    Busy,
    #[error(
        "the identity provider has no sign-in for devices: make a key in place of it, with \
         `bendtwin key create`"
    )]
    #[problem(FailedPrecondition, "SIGN_IN_NO_DEVICES")]
    NoDevices,
}

/// Text of the provider, as text of one line.
pub(super) fn plain(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_control()).take(LONGEST).collect()
}

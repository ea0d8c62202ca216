//! Errors of a sign-in.

use std::time::Duration;

use bendtwin_core::Problem;

/// Delay before another attempt where something has to become free or come back.
const SOON: Duration = Duration::from_secs(5);
/// Increase of the delay between two questions whether a code is confirmed (RFC 8628, 3.5).
pub(super) const MORE: Duration = Duration::from_secs(5);
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
    #[error(
        "the identity provider does not accept this server as its client: {0}: tell the operator, who \
         compares sign_in.client_id and sign_in.client_secret_file with what the provider has"
    )]
    #[problem(FailedPrecondition, "SIGN_IN_CLIENT_REFUSED")]
    Client(String),
    #[error("nobody has confirmed the code yet: retry in {} s", .delay.as_secs())]
    #[problem(FailedPrecondition, "SIGN_IN_PENDING", retry = *delay)]
    Pending { delay: Duration },
    #[error(
        "nobody has confirmed the code yet, and it was asked for too often: ask {} s less often",
        MORE.as_secs()
    )]
    #[problem(FailedPrecondition, "SIGN_IN_SLOW_DOWN", retry = *delay)]
    SlowDown { delay: Duration },
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
        "the identity provider has no device sign-in: use a key (`bendtwin key create`), or sign in \
         with the console"
    )]
    #[problem(FailedPrecondition, "SIGN_IN_NO_DEVICES")]
    NoDevices,
}

/// Text of the provider, as text of one line.
pub(super) fn plain(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_control()).take(LONGEST).collect()
}

/// Text of the provider that people read in a terminal and type elsewhere: letters, digits and signs,
/// without characters that change how a terminal shows the others.
pub(super) fn shown(text: &str) -> String {
    let is_shown = |c: &char| c.is_alphanumeric() || c.is_ascii_graphic() || *c == ' ';
    plain(text).chars().filter(is_shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_has_nothing_that_changes_the_terminal() {
        assert_eq!(shown("AB\u{1b}[2J-\u{202e}CD\u{200b}\u{feff}\u{e0041}\u{ad}\n"), "AB[2J-CD");
        assert_eq!(shown("WDJB-MJHT"), "WDJB-MJHT");
    }
}

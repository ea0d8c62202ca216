//! Connections that failed for their TLS, as sentences that say what to do.

use std::{error::Error, io};

use bendtwin_core::Problem;
use rustls::{AlertDescription, CertificateError, Error as Fault, InvalidMessage};

/// Alerts of a server that refuses the certificate of a client.
const REFUSALS: [AlertDescription; 7] = [
    AlertDescription::CertificateRequired,
    AlertDescription::CertificateExpired,
    AlertDescription::CertificateRevoked,
    AlertDescription::UnknownCA,
    AlertDescription::BadCertificate,
    AlertDescription::CertificateUnknown,
    AlertDescription::UnsupportedCertificate,
];

/// Ways to name an authority in commands.
const IN_COMMANDS: &str = "--ca FILE, BENDTWIN_CA";

/// Failure of a connection for its TLS.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Problem)]
#[error("{message}")]
#[problem(FailedPrecondition, "TLS_CERTIFICATE_REFUSED", if *kind == Kind::CertificateRefused)]
#[problem(
    FailedPrecondition,
    "TLS_CLIENT_CERTIFICATE_REFUSED",
    if *kind == Kind::ClientCertificateRefused
)]
#[problem(FailedPrecondition, "TLS_NOT_SPOKEN", if *kind == Kind::NotSpoken)]
#[problem(FailedPrecondition, "TLS_FAILED")]
pub struct TlsError {
    kind: Kind,
    message: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// This side refuses the certificate of the other one.
    CertificateRefused,
    /// The other side refuses the certificate of this one.
    ClientCertificateRefused,
    /// The other side does not speak TLS.
    NotSpoken,
    Failed,
}

impl TlsError {
    /// The failure behind an error of a connection to `host`; none if the connection failed for
    /// another reason.
    pub fn find(error: &(dyn Error + 'static), host: &str) -> Option<Self> {
        let mut next = Some(error);
        while let Some(error) = next {
            if let Some(found) = Self::of(error, host) {
                return Some(found);
            }
            next = error.source();
        }
        None
    }

    fn of(error: &(dyn Error + 'static), host: &str) -> Option<Self> {
        if let Some(found) = error.downcast_ref::<Self>() {
            return Some(found.clone());
        }
        if let Some(fault) = error.downcast_ref::<Fault>() {
            return Some(Self::of_fault(fault, host));
        }
        // The source of such an error is that of the error inside, which would be left out.
        let inner = error.downcast_ref::<io::Error>()?.get_ref()?;
        Self::find(inner, host).or_else(|| Self::of_text(&inner.to_string(), host))
    }

    /// HTTP/2 shares an error among its streams as text alone.
    fn of_text(text: &str, host: &str) -> Option<Self> {
        let alerts = REFUSALS.map(Fault::AlertReceived);
        let alert = alerts.iter().find(|alert| alert.to_string() == text)?;
        Some(Self::of_fault(alert, host))
    }

    /// With the advice to name an authority in this variable, where commands do not.
    #[must_use]
    pub fn with_authority_in(self, variable: &str) -> Self {
        Self { message: self.message.replace(IN_COMMANDS, variable), ..self }
    }

    /// The failure of a handshake with a server that ended the connection.
    pub(crate) fn ended(host: &str) -> Self {
        let message = format!(
            "{host} ended the connection instead of answering in TLS: if it has none, use \
             http:// in its address"
        );
        Self { kind: Kind::NotSpoken, message }
    }

    /// The failure of a client that has no settings for TLS.
    pub(crate) fn without_settings(host: &str) -> Self {
        let message = format!(
            "{host} is to be called over TLS, for which certificates are needed and none were given"
        );
        Self { kind: Kind::Failed, message }
    }

    /// The failure to call a host by a name that no certificate can have.
    pub(crate) fn no_name(host: &str) -> Self {
        let message = format!("`{host}` is neither a name nor an address that a certificate has");
        Self { kind: Kind::CertificateRefused, message }
    }

    pub(crate) fn of_fault(fault: &Fault, host: &str) -> Self {
        let (kind, message) = match fault {
            Fault::InvalidCertificate(fault) => {
                (Kind::CertificateRefused, of_certificate(fault, host))
            }
            Fault::InvalidMessage(InvalidMessage::InvalidContentType) => {
                (Kind::NotSpoken, format!("{host} does not speak TLS: use http:// in its address"))
            }
            Fault::AlertReceived(alert) => match of_alert(*alert, host) {
                Some(message) => (Kind::ClientCertificateRefused, message),
                None => (Kind::Failed, format!("{host} ended the TLS connection: {alert:?}")),
            },
            fault => (Kind::Failed, format!("no TLS connection to {host}: {fault}")),
        };
        Self { kind, message }
    }
}

/// Advice for a certificate that this side refuses.
fn of_certificate(fault: &CertificateError, host: &str) -> String {
    use CertificateError as C;
    match fault {
        C::UnknownIssuer => format!(
            "the certificate of {host} is of an authority that is not trusted here: name the \
             certificate of that authority ({IN_COMMANDS})"
        ),
        C::BadSignature => format!(
            "the certificate of {host} is not of the authority that was named but of another one \
             of that name: name the right one ({IN_COMMANDS})"
        ),
        C::NotValidForName => wrong_name(host, &[]),
        C::NotValidForNameContext { presented, .. } => wrong_name(host, presented),
        C::Expired | C::ExpiredContext { .. } => format!(
            "the certificate of {host} has expired: have it replaced there, or check the clock of \
             this machine"
        ),
        C::NotValidYet | C::NotValidYetContext { .. } => format!(
            "the certificate of {host} does not hold yet: check the clocks of both machines"
        ),
        C::InvalidPurpose | C::InvalidPurposeContext { .. } => format!(
            "the certificate of {host} is not for this use: have one issued that is for \
             servers and clients alike (`bendtwin ca issue`)"
        ),
        C::Revoked => format!(
            "the certificate of {host} was revoked by its authority: have another one issued \
             (`bendtwin ca issue … --renew`)"
        ),
        C::UnknownRevocationStatus => format!(
            "the certificate of {host} is of an authority whose revocation list is not known here: \
             append it to the file of the list (--crl FILE, --worker-tls-crl FILE)"
        ),
        fault => format!("the certificate of {host} is not accepted: {fault}"),
    }
}

fn wrong_name(host: &str, names: &[String]) -> String {
    // As in `DnsName("a.example")` or `IpAddress(127.0.0.1)`.
    let bare = |name: &String| {
        let inner = name.split_once('(').map_or(&**name, |(_, rest)| rest.trim_end_matches(')'));
        inner.trim_matches('"').to_owned()
    };
    let names: Vec<_> = names.iter().map(bare).collect();
    let names = if names.is_empty() { "others".to_owned() } else { names.join(", ") };
    format!(
        "the certificate of the server at {host} is not for this name but for {names}: use one of \
         its names in the address, or have a certificate issued that has this one"
    )
}

/// Advice for an own certificate that the other side refuses.
fn of_alert(alert: AlertDescription, host: &str) -> Option<String> {
    use AlertDescription as A;
    let fault = match alert {
        A::CertificateRequired => "demands a certificate of this side, and got none",
        A::CertificateExpired => "refuses the certificate of this side, which has expired",
        A::CertificateRevoked => "refuses the certificate of this side, which was revoked",
        A::UnknownCA => "refuses the certificate of this side, which is of another authority",
        alert if REFUSALS.contains(&alert) => "refuses the certificate of this side",
        _ => return None,
    };
    Some(format!(
        "{host} {fault}: give one that its authority issued (--certificate FILE --key FILE; \
         `bendtwin ca issue`)"
    ))
}

#[cfg(test)]
mod tests;

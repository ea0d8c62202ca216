//! Facts that a certificate states: its names, and the time for which it holds.

use std::net::IpAddr;

use jiff::{SignedDuration, Timestamp};
use rustls::pki_types::CertificateDer;
use x509_parser::{
    certificate::X509Certificate, extensions::GeneralName, prelude::FromDer as _, x509::X509Name,
};

/// Time before the end of a certificate from which everyone warns, at most a third of the time for which it is
/// valid.
const SOON: SignedDuration = SignedDuration::from_hours(14 * 24);

/// Facts that a certificate states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Certificate {
    /// Serial number at the issuer, in hexadecimal digits.
    pub serial: String,
    /// Common name of its subject, perhaps empty.
    pub common_name: String,
    /// Common name of its issuer, perhaps empty.
    pub issuer: String,
    /// Hosts and addresses that it is for.
    pub hosts: Vec<String>,
    /// Start of its validity.
    pub not_before: Timestamp,
    /// End of its validity.
    pub not_after: Timestamp,
    /// True if it is one of an authority.
    pub is_authority: bool,
}

/// State of a certificate at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validity {
    /// Not valid yet.
    NotYet,
    /// Valid.
    Valid,
    /// Valid, but its end is near: its files should have been replaced.
    Soon,
    /// No longer valid.
    Expired,
}

impl Certificate {
    /// Facts of a certificate; none if it cannot be read.
    pub fn of(der: &CertificateDer<'_>) -> Option<Self> {
        let (_, parsed) = X509Certificate::from_der(der).ok()?;
        let names = parsed.subject_alternative_name().ok().flatten();
        let names = names.iter().flat_map(|names| &names.value.general_names);
        let validity = parsed.validity();
        Some(Self {
            serial: serial_text(parsed.raw_serial()),
            common_name: common_name(parsed.subject()),
            issuer: common_name(parsed.issuer()),
            hosts: names.filter_map(host).collect(),
            not_before: time(validity.not_before.timestamp()),
            not_after: time(validity.not_after.timestamp()),
            is_authority: parsed.is_ca(),
        })
    }

    /// Name for people: its first host, or else its common name.
    pub fn name(&self) -> &str {
        self.hosts.first().unwrap_or(&self.common_name)
    }

    /// Time before its end from which everyone warns.
    fn soon(&self) -> SignedDuration {
        SOON.min(self.not_after.duration_since(self.not_before) / 3)
    }

    /// State at a time.
    pub fn validity(&self, now: Timestamp) -> Validity {
        if now < self.not_before {
            Validity::NotYet
        } else if now > self.not_after {
            Validity::Expired
        } else if self.not_after.duration_since(now) < self.soon() {
            Validity::Soon
        } else {
            Validity::Valid
        }
    }
}

/// Logs which certificate is shown from now on, by whom and until when.
pub fn tell(shown_by: &'static str, certificate: Option<&Certificate>) {
    let Some(certificate) = certificate else {
        tracing::warn!(shown_by, "the certificate cannot be read: others may refuse it");
        return;
    };
    let (hosts, end) = (certificate.hosts.join(", "), certificate.not_after);
    match certificate.validity(Timestamp::now()) {
        Validity::Expired => {
            tracing::error!(shown_by, hosts, %end, "the certificate has expired: replace its files");
        }
        Validity::NotYet => {
            tracing::error!(shown_by, hosts, begin = %certificate.not_before,
                "the certificate does not hold yet: is the clock of this machine right?");
        }
        Validity::Soon => {
            tracing::warn!(shown_by, hosts, %end, "the certificate ends soon: replace its files");
        }
        Validity::Valid => tracing::info!(shown_by, hosts, %end, "certificate"),
    }
}

/// Digits of a serial number, without the zero that keeps it from being negative.
pub(crate) fn serial_text(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(&[0]).filter(|rest| !rest.is_empty()).unwrap_or(bytes);
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The time of a second; the last representable one if out of range.
pub(crate) fn time(seconds: i64) -> Timestamp {
    Timestamp::from_second(seconds).unwrap_or(Timestamp::MAX)
}

pub(crate) fn common_name(name: &X509Name<'_>) -> String {
    let found = name.iter_common_name().find_map(|name| name.as_str().ok());
    printable(found.unwrap_or_default())
}

fn host(name: &GeneralName<'_>) -> Option<String> {
    match name {
        GeneralName::DNSName(name) => Some(printable(name)),
        GeneralName::IPAddress(bytes) => {
            let v4 = <[u8; 4]>::try_from(*bytes).map(IpAddr::from);
            let v6 = || <[u8; 16]>::try_from(*bytes).map(IpAddr::from);
            v4.or_else(|_| v6()).ok().map(|address| address.to_string())
        }
        _ => None,
    }
}

/// Names stand in logs and messages: without what would break their lines.
fn printable(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(200).collect()
}

#[cfg(test)]
mod tests;

//! Certificate revocation lists (RFC 5280): read, compared with the authorities that signed them,
//! and the facts that they state. Authorities make them.

use std::{collections::BTreeMap, path::Path};

use jiff::{SignedDuration, Timestamp};
use rustls::pki_types::{CertificateDer, CertificateRevocationListDer};
use x509_parser::{
    certificate::X509Certificate, prelude::FromDer as _,
    revocation_list::CertificateRevocationList as Parsed,
};

use crate::{
    FileError,
    certificate::{common_name, serial_text, time},
    files::{self, unusable},
};

/// Time before the end of a list from which the log warns.
const SOON: SignedDuration = SignedDuration::from_hours(14 * 24);

/// Facts that a revocation list states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RevocationList {
    /// Common name of the authority that signed it, perhaps empty.
    pub issuer: String,
    /// Number of the list, which grows from list to list; 0 if it states none.
    pub number: u64,
    /// Time from which a later list is to be had.
    pub next_update: Option<Timestamp>,
    /// Revoked certificates: when they were, by their serial numbers.
    pub revoked: BTreeMap<String, Timestamp>,
}

impl RevocationList {
    /// Facts of a list; none if it cannot be read.
    pub fn of(der: &CertificateRevocationListDer<'_>) -> Option<Self> {
        Some(Self::of_parsed(&parse(der)?))
    }

    fn of_parsed(parsed: &Parsed<'_>) -> Self {
        let revoked = parsed.iter_revoked_certificates();
        let number = parsed.crl_number();
        Self {
            issuer: common_name(parsed.issuer()),
            number: number.and_then(|n| n.iter_u64_digits().next()).unwrap_or(0),
            next_update: parsed.next_update().map(|end| time(end.timestamp())),
            revoked: revoked
                .map(|entry| {
                    (serial_text(entry.raw_serial()), time(entry.revocation_date.timestamp()))
                })
                .collect(),
        }
    }
}

/// Lists of a file, each checked: it is signed by one of these authorities, of which everyone has
/// one, and its time is not over.
pub(crate) fn load(
    path: &Path,
    authorities: &[CertificateDer<'_>],
) -> Result<(Vec<CertificateRevocationListDer<'static>>, Vec<RevocationList>), FileError> {
    let lists = files::revocation_lists(path)?;
    let mut facts = Vec::new();
    let mut without: Vec<_> = authorities
        .iter()
        .filter_map(|der| X509Certificate::from_der(der).ok())
        .map(|(_, authority)| authority)
        .collect();
    for der in &lists {
        let list = parse(der).ok_or_else(|| unusable(path, "it has a list that is damaged"))?;
        let of_list = RevocationList::of_parsed(&list);
        let signs = |authority: &X509Certificate<'_>| {
            authority.subject().as_raw() == list.issuer().as_raw()
                && list.verify_signature(authority.public_key()).is_ok()
        };
        let Some(place) = without.iter().position(signs) else {
            return Err(unusable(path, of_no_authority(&of_list)));
        };
        without.swap_remove(place);
        if let Some(end) = of_list.next_update.filter(|end| *end <= Timestamp::now()) {
            let issuer = &of_list.issuer;
            let fault = format!(
                "the list of {issuer} ended at {end:.0}: have that authority make a new one \
                 (`bendtwin ca revoke FOLDER`), or check the clock of this machine"
            );
            return Err(unusable(path, fault));
        }
        facts.push(of_list);
    }
    if let Some(authority) = without.first() {
        let fault = format!(
            "it has no list of {}, whose certificates are accepted: append that authority's list",
            common_name(authority.subject())
        );
        return Err(unusable(path, fault));
    }
    Ok((lists, facts))
}

/// Says in the log what lists are in force from now on.
pub fn tell_lists(listener: &'static str, lists: &[RevocationList]) {
    for list in lists {
        let (issuer, number, revoked) = (&list.issuer, list.number, list.revoked.len());
        tracing::info!(listener, issuer, number, revoked, "revocation list");
        let end = list.next_update.filter(|end| end.duration_since(Timestamp::now()) < SOON);
        if let Some(end) = end {
            tracing::warn!(listener, issuer, %end,
                "the revocation list ends soon, and no start takes it then: replace its file");
        }
    }
}

fn of_no_authority(list: &RevocationList) -> String {
    format!(
        "the list of `{}` is not signed by an authority whose certificates are accepted, or is the \
         second one of it: name the file that `bendtwin ca revoke` wrote beside its ca.pem",
        list.issuer
    )
}

fn parse<'a>(der: &'a CertificateRevocationListDer<'_>) -> Option<Parsed<'a>> {
    Parsed::from_der(der).ok().map(|(_, list)| list)
}

#[cfg(test)]
mod tests;

//! A private certification authority in a folder: `ca.pem`, which may be given to everyone,
//! `ca.key`, which must stay secret, the certificates that it issued, and `crl.pem`, the list of
//! those that it has revoked. It is for the servers and the workers of one installation; others
//! have no reason to trust it.

mod error;
mod files;
mod name;
mod renewal;
mod revocation;

use std::{
    net::IpAddr,
    path::{Path, PathBuf},
};

use jiff::{SignedDuration, Timestamp};
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};
use time::OffsetDateTime;

pub use self::{
    error::Error,
    revocation::{Issued, Revocation, issued},
};
use crate::{Certificate, files as pem};

/// Validity of an authority's certificate [days].
pub const AUTHORITY_DAYS: u32 = 3650;
/// Usual validity of the certificates that it issues [days].
pub const DAYS: u32 = 365;
/// Time before now at which a certificate begins to hold: clocks differ.
const EARLIER: SignedDuration = SignedDuration::from_hours(1);
const DAY: SignedDuration = SignedDuration::from_hours(24);
/// Hosts of a server for which none are given: those of this machine.
const OWN_HOSTS: [&str; 3] = ["localhost", "127.0.0.1", "::1"];

/// An authority with its key.
pub struct Authority {
    folder: PathBuf,
    issuer: Issuer<'static, KeyPair>,
    certificate: Certificate,
}

/// Certificate to be issued.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// Name of the holder, which is that of the files, and the first host of the certificate.
    pub name: String,
    /// Further hosts and addresses. Without any, a server gets those of this machine.
    pub hosts: Vec<String>,
    /// Role of the holder.
    pub role: Role,
    /// Validity [days], which may begin and end in the past for tests.
    pub days: i64,
    /// True to replace a certificate of that name.
    pub renew: bool,
}

/// Role of the holder of a certificate. Both begin connections and accept them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A server.
    Server,
    /// A worker.
    Worker,
}

/// Files that were written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The file of the certificate.
    pub certificate: PathBuf,
    /// The file of its key, which only this user can read.
    pub key: PathBuf,
    /// Facts of the certificate.
    pub facts: Certificate,
}

impl Authority {
    /// Makes an authority in a folder, which is made if missing, and its list of revoked
    /// certificates, which has none.
    ///
    /// # Errors
    /// If there is one, or a file cannot be written.
    pub fn create(folder: &Path) -> Result<Written, Error> {
        let (certificate, key) = Self::paths(folder);
        files::refuse_present(&[&certificate, &key, &Self::list_path(folder)])?;
        files::make_folder(folder)?;
        let now = Timestamp::now();
        let mut params = CertificateParams::default();
        let pair = KeyPair::generate()?;
        // Authorities are found by their names, so that two must not have the same.
        let mark: String = pair.public_key_raw().iter().rev().take(6).map(hex).collect();
        let name = format!("BendTwin authority {mark}");
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, name);
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
        params.not_before = moment(now, -EARLIER)?;
        params.not_after = moment(now, DAY * i32::try_from(AUTHORITY_DAYS).unwrap_or(i32::MAX))?;
        let signed = params.self_signed(&pair)?;
        files::write_pair(&certificate, &signed.pem(), &key, &pair.serialize_pem())?;
        Self::open(folder)?.revoke(&[])?;
        let facts = Certificate::of(signed.der()).ok_or(Error::Unreadable)?;
        Ok(Written { certificate, key, facts })
    }

    /// Opens the authority of a folder.
    ///
    /// # Errors
    /// If there is no authority, or its files cannot be used.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let (certificate, key) = Self::paths(folder);
        if !certificate.exists() {
            return Err(Error::Missing { folder: folder.to_owned() });
        }
        let der = pem::certificates(&certificate)?;
        let der = der.first().ok_or(Error::Unreadable)?;
        // Refused if others can use it.
        let pair = KeyPair::try_from(&pem::key(&key)?)?;
        let facts = Certificate::of(der).ok_or(Error::Unreadable)?;
        let issuer = Issuer::from_ca_cert_der(der, pair)?;
        Ok(Self { folder: folder.to_owned(), issuer, certificate: facts })
    }

    /// The authority's own certificate and key in a folder.
    pub fn paths(folder: &Path) -> (PathBuf, PathBuf) {
        (folder.join("ca.pem"), folder.join("ca.key"))
    }

    /// Issues a certificate, with a new key.
    ///
    /// # Errors
    /// If the order has faults, files of that name exist, or they cannot be written.
    pub fn issue(&self, order: &Order) -> Result<Written, Error> {
        name::check(&order.name)?;
        let mut hosts = vec![order.name.clone()];
        if order.hosts.is_empty() && order.role == Role::Server {
            hosts.extend(OWN_HOSTS.map(str::to_owned));
        }
        for host in &order.hosts {
            if host.parse::<IpAddr>().is_err() {
                name::check_host(host)?;
            }
            if !hosts.contains(host) {
                hosts.push(host.clone());
            }
        }
        let certificate = self.folder.join(format!("{}.pem", order.name));
        let key = self.folder.join(format!("{}.key", order.name));
        let pair = KeyPair::generate()?;
        let signed = self.params(order, hosts)?.signed_by(&pair, &self.issuer)?;
        let facts = Certificate::of(signed.der()).ok_or(Error::Unreadable)?;
        if facts.not_after > self.certificate.not_after {
            return Err(Error::TooLong { days: order.days, end: self.certificate.not_after });
        }
        if !order.renew {
            files::refuse_present(&[&certificate, &key])?;
        }
        self.record(&facts, &signed.pem())?;
        files::write_pair(&certificate, &signed.pem(), &key, &pair.serialize_pem())?;
        Ok(Written { certificate, key, facts })
    }

    fn params(&self, order: &Order, hosts: Vec<String>) -> Result<CertificateParams, Error> {
        let mut params = CertificateParams::new(hosts)?;
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, order.name.clone());
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages =
            vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
        params.use_authority_key_identifier_extension = true;
        let length = SignedDuration::from_hours(24).checked_mul(days(order.days)?);
        let length = length.ok_or(Error::Days(order.days))?;
        let now = Timestamp::now();
        // One whose time is over begins before its end.
        params.not_before = moment(now, length.min(SignedDuration::ZERO) - EARLIER)?;
        params.not_after = moment(now, length)?;
        Ok(params)
    }
}

fn hex(byte: &u8) -> String {
    format!("{byte:02x}")
}

fn days(days: i64) -> Result<i32, Error> {
    let fits = |days: &i32| days.unsigned_abs() <= AUTHORITY_DAYS;
    i32::try_from(days).ok().filter(fits).ok_or(Error::Days(days))
}

fn moment(now: Timestamp, later: SignedDuration) -> Result<OffsetDateTime, Error> {
    let moment = now.checked_add(later).map_err(|_| Error::Unreadable)?;
    OffsetDateTime::from_unix_timestamp(moment.as_second()).map_err(|_| Error::Unreadable)
}

#[cfg(test)]
mod tests;

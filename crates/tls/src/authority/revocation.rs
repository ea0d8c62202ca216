//! Certificates that an authority has issued, and the list of those that it has revoked (`crl.pem`).
//! Each certificate is also kept in `issued/` under its serial number, because a renewal replaces
//! the file of its name, and the previous one stays valid until its end.

use std::{
    collections::BTreeMap,
    fs::File,
    io,
    path::{Path, PathBuf},
};

use jiff::Timestamp;
use rcgen::{CertificateRevocationListParams, KeyIdMethod, RevokedCertParams, SerialNumber};

use super::{Authority, Error, files, moment};
use crate::{Certificate, RevocationList, files as pem};

/// Certificate that an authority issued.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Issued {
    /// Facts of the certificate.
    pub facts: Certificate,
    /// Time of its revocation, if it was revoked.
    pub revoked: Option<Timestamp>,
}

/// List of revoked certificates as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Revocation {
    /// The file.
    pub list: PathBuf,
    /// Number of the list.
    pub number: u64,
    /// Certificates that were asked for; those revoked before keep their times.
    pub asked: Vec<Issued>,
    /// Number of all revoked certificates.
    pub total: usize,
}

/// Certificates that the authority of a folder issued, in the order of their names and ends. The
/// authority's key is not needed.
///
/// # Errors
/// If there is no authority, or its files cannot be read.
pub fn issued(folder: &Path) -> Result<Vec<Issued>, Error> {
    let (ca, _) = Authority::paths(folder);
    if !ca.exists() {
        return Err(Error::Missing { folder: folder.to_owned() });
    }
    let authority = of_file(&ca)?;
    let list = read_list(&Authority::list_path(folder), &authority)?;
    let mut by_serial = BTreeMap::new();
    let mut add = |facts: Certificate| {
        if !facts.is_authority && facts.issuer == authority.common_name {
            by_serial.insert(facts.serial.clone(), facts);
        }
    };
    for path in certificate_files(&record_folder(folder))? {
        add(of_file(&path)?);
    }
    // Certificates from before there were records, beside files of others.
    for path in certificate_files(folder)? {
        if let Ok(facts) = of_file(&path) {
            add(facts);
        }
    }
    let revoked = |facts: &Certificate| list.as_ref()?.revoked.get(&facts.serial).copied();
    let all = by_serial.into_values();
    let mut all: Vec<_> = all.map(|facts| Issued { revoked: revoked(&facts), facts }).collect();
    all.sort_by(|a, b| {
        let of = |issued: &Issued| (issued.facts.common_name.clone(), issued.facts.not_after);
        of(a).cmp(&of(b))
    });
    Ok(all)
}

impl Authority {
    /// The list of revoked certificates in a folder.
    pub fn list_path(folder: &Path) -> PathBuf {
        folder.join("crl.pem")
    }

    /// Revokes certificates, each by its file, its name (all certificates of that name) or its serial
    /// number, and writes the list. Without any the list is written as it stands.
    ///
    /// # Errors
    /// If this authority did not issue one of them, or files cannot be read or written; nothing is
    /// revoked then.
    pub fn revoke(&self, wanted: &[String]) -> Result<Revocation, Error> {
        let (_, key) = Self::paths(&self.folder);
        let unwritable = |source| Error::Unwritable { path: key.clone(), source };
        // Two that revoke at the same time would each leave out what the other one adds.
        let key_file = File::open(&key).map_err(unwritable)?;
        key_file.lock().map_err(unwritable)?;
        let path = Self::list_path(&self.folder);
        let before = read_list(&path, &self.certificate)?;
        let number = before.as_ref().map_or(0, |list| list.number) + 1;
        let mut revoked = before.map(|list| list.revoked).unwrap_or_default();
        let now = Timestamp::now();
        let mut asked = Vec::new();
        for facts in self.find(wanted)? {
            let at = *revoked.entry(facts.serial.clone()).or_insert(now);
            asked.push(Issued { facts, revoked: Some(at) });
        }
        let signed = CertificateRevocationListParams {
            this_update: moment(now, jiff::SignedDuration::ZERO)?,
            // The list is a file that people hand out: nothing would make another one in time, and
            // one that ended would lock the whole installation out.
            next_update: moment(self.certificate.not_after, jiff::SignedDuration::ZERO)?,
            crl_number: SerialNumber::from(number),
            issuing_distribution_point: None,
            revoked_certs: revoked.iter().map(entry).collect::<Result<_, Error>>()?,
            key_identifier_method: KeyIdMethod::Sha256,
        }
        .signed_by(&self.issuer)?;
        files::write(&path, &signed.pem()?, 0o644)?;
        Ok(Revocation { list: path, number, asked, total: revoked.len() })
    }

    /// Notes a certificate, before anybody has it.
    pub(crate) fn record(&self, facts: &Certificate, pem: &str) -> Result<(), Error> {
        let folder = record_folder(&self.folder);
        files::make_folder(&folder)?;
        files::write(&folder.join(format!("{}.pem", facts.serial)), pem, 0o644)
    }

    fn find(&self, wanted: &[String]) -> Result<Vec<Certificate>, Error> {
        let all = issued(&self.folder)?;
        let mut found = Vec::new();
        for word in wanted {
            let path = Path::new(word);
            let mut these = Vec::new();
            if path.is_file() {
                let facts = of_file(path)?;
                if facts.issuer != self.certificate.common_name || facts.is_authority {
                    return Err(Error::OfAnother { path: path.to_owned(), issuer: facts.issuer });
                }
                these.push(facts);
            } else {
                let serial = word.replace(':', "").to_ascii_lowercase();
                let is_it =
                    |facts: &Certificate| facts.common_name == *word || facts.serial == serial;
                these.extend(all.iter().map(|one| one.facts.clone()).filter(is_it));
            }
            if these.is_empty() {
                return Err(Error::Unknown { what: word.clone(), folder: self.folder.clone() });
            }
            found.extend(these);
        }
        Ok(found)
    }
}

fn record_folder(folder: &Path) -> PathBuf {
    folder.join("issued")
}

pub(super) fn of_file(path: &Path) -> Result<Certificate, Error> {
    let der = pem::certificates(path)?;
    der.first().and_then(Certificate::of).ok_or(Error::Unreadable)
}

/// The list of an authority; none if there is no file.
fn read_list(path: &Path, authority: &Certificate) -> Result<Option<RevocationList>, Error> {
    if !path.exists() {
        return Ok(None);
    }
    let der = pem::revocation_lists(path)?;
    let list = der.first().and_then(RevocationList::of).ok_or(Error::Unreadable)?;
    if list.issuer != authority.common_name {
        return Err(Error::OfAnother { path: path.to_owned(), issuer: list.issuer });
    }
    Ok(Some(list))
}

fn certificate_files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let unreadable = |source| Error::Unwritable { path: folder.to_owned(), source };
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(unreadable)?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(unreadable)?.path();
        if path.extension().is_some_and(|extension| extension == "pem") {
            found.push(path);
        }
    }
    Ok(found)
}

fn entry((serial, at): (&String, &Timestamp)) -> Result<RevokedCertParams, Error> {
    let digits = serial.as_bytes().chunks(2);
    let bytes = digits.map(|pair| {
        let pair = str::from_utf8(pair).ok()?;
        u8::from_str_radix(pair, 16).ok()
    });
    let bytes: Option<Vec<u8>> = bytes.collect();
    Ok(RevokedCertParams {
        serial_number: SerialNumber::from(bytes.ok_or(Error::Unreadable)?),
        revocation_time: moment(*at, jiff::SignedDuration::ZERO)?,
        reason_code: None,
        invalidity_date: None,
    })
}

#[cfg(test)]
mod tests;

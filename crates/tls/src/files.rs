//! Files of certificates and keys in PEM form, and the reasons for which they cannot be used.

use std::{
    fs::File,
    io::{self, Read as _},
    path::{Path, PathBuf},
};

use bendtwin_core::Problem;
use rustls::{
    RootCertStore,
    pki_types::{CertificateDer, CertificateRevocationListDer, PrivateKeyDer, pem::PemObject as _},
};

/// Largest file that is read [bytes]; chains and bundles of authorities are far smaller.
const MAX_BYTES: u64 = 4 << 20;

/// Reason for which a file of certificates or a key cannot be used.
#[derive(Debug, thiserror::Error, Problem)]
#[problem(FailedPrecondition, "TLS_FILE_UNUSABLE")]
pub enum FileError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}: name a PEM file that this user may read", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file has no certificate.
    #[error(
        "there is no certificate in {}: it must be a PEM file with `-----BEGIN CERTIFICATE-----`, \
         the own certificate first and those that issued it after it", path.display()
    )]
    NoCertificate {
        /// The file.
        path: PathBuf,
    },
    /// The file has no key.
    #[error(
        "there is no key in {}: it must be a PEM file with `-----BEGIN PRIVATE KEY-----` and \
         without a passphrase", path.display()
    )]
    NoKey {
        /// The file.
        path: PathBuf,
    },
    /// The file has no revocation list.
    #[error(
        "there is no revocation list in {}: it must be a PEM file with `-----BEGIN X509 CRL-----` \
         (`bendtwin ca revoke` writes crl.pem)", path.display()
    )]
    NoRevocationList {
        /// The file.
        path: PathBuf,
    },
    /// Other users of the machine can use the key.
    #[error(
        "other users can use {0}, which has a private key (mode {mode:03o}): `chmod o= {0}`, and \
         have another key made if they may have read this one", path.display()
    )]
    #[problem(FailedPrecondition, "KEY_FILE_OPEN")]
    KeyOpen {
        /// The file.
        path: PathBuf,
        /// Permissions of the file.
        mode: u32,
    },
    /// The key is that of another certificate.
    #[error(
        "the key in {} is not that of the first certificate in {}: name the two files that were \
         made together", key.display(), certificate.display()
    )]
    KeyMismatch {
        /// The file of the certificate.
        certificate: PathBuf,
        /// The file of the key.
        key: PathBuf,
    },
    /// The content cannot be used.
    #[error("{} cannot be used: {fault}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// The reason.
        fault: String,
    },
}

/// Certificates of a file, in its order; at least one.
///
/// # Errors
/// If it cannot be read or has none.
pub fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, FileError> {
    let text = read(File::open(path), path)?;
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
    let found = found.map_err(|fault| unusable(path, fault))?;
    if found.is_empty() {
        return Err(FileError::NoCertificate { path: path.to_owned() });
    }
    Ok(found)
}

/// The key of a file. Its group may be able to read it, as with keys that an administrator shares
/// with the accounts of services; other users must not.
///
/// # Errors
/// If it cannot be read, has no key, or other users can use it.
pub fn key(path: &Path) -> Result<PrivateKeyDer<'static>, FileError> {
    let file = File::open(path);
    #[cfg(unix)]
    if let Ok(file) = &file {
        use std::os::unix::fs::PermissionsExt as _;
        let metadata = file.metadata().map_err(|source| unreadable(path, source))?;
        let mode = metadata.permissions().mode() & 0o777;
        if mode & 0o007 != 0 {
            return Err(FileError::KeyOpen { path: path.to_owned(), mode });
        }
    }
    let text = read(file, path)?;
    let mut keys = PrivateKeyDer::pem_slice_iter(&text);
    match keys.next() {
        Some(key) => key.map_err(|fault| unusable(path, fault)),
        None => Err(FileError::NoKey { path: path.to_owned() }),
    }
}

/// The authorities of a file.
///
/// # Errors
/// If it cannot be read, has no certificate, or one that cannot be an authority's.
pub fn authorities(path: &Path) -> Result<RootCertStore, FileError> {
    let mut roots = RootCertStore::empty();
    for certificate in certificates(path)? {
        roots.add(certificate).map_err(|fault| unusable(path, fault))?;
    }
    Ok(roots)
}

/// Revocation lists of a file; at least one. Their signatures are not checked.
///
/// # Errors
/// If it cannot be read or has none.
pub fn revocation_lists(
    path: &Path,
) -> Result<Vec<CertificateRevocationListDer<'static>>, FileError> {
    let text = read(File::open(path), path)?;
    let found: Result<Vec<_>, _> = CertificateRevocationListDer::pem_slice_iter(&text).collect();
    let found = found.map_err(|fault| unusable(path, fault))?;
    if found.is_empty() {
        return Err(FileError::NoRevocationList { path: path.to_owned() });
    }
    Ok(found)
}

/// Content of a file, of bounded size.
pub(crate) fn read(file: io::Result<File>, path: &Path) -> Result<Vec<u8>, FileError> {
    let mut content = Vec::new();
    let read = file.and_then(|file| file.take(MAX_BYTES).read_to_end(&mut content));
    read.map_err(|source| unreadable(path, source))?;
    Ok(content)
}

fn unreadable(path: &Path, source: io::Error) -> FileError {
    FileError::Unreadable { path: path.to_owned(), source }
}

pub(crate) fn unusable(path: &Path, fault: impl std::fmt::Display) -> FileError {
    FileError::Unusable { path: path.to_owned(), fault: fault.to_string() }
}

#[cfg(test)]
mod tests;

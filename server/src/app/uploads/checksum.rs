//! Checksums of single requests, which detect damage by a connection before it costs a whole
//! upload.

use base64::{Engine as _, prelude::BASE64_STANDARD};
use sha1::{Digest as _, Sha1};
use sha2::Sha256;

use super::super::{Error, Result};

/// The algorithms, as clients name them.
pub(crate) const ALGORITHMS: [&str; 3] = ["sha1", "sha256", "blake3"];

/// A declared checksum, and the checksum of the bytes so far.
pub(crate) struct Checksum {
    hasher: Hasher,
    declared: Vec<u8>,
}

enum Hasher {
    Sha1(Sha1),
    Sha256(Sha256),
    Blake3(Box<blake3::Hasher>),
}

impl Checksum {
    /// Reads `algorithm base64`.
    pub(crate) fn parse(text: &str) -> Result<Self> {
        let invalid = |fault: String| Error::invalid("upload-checksum", fault);
        let (algorithm, value) = text.trim().split_once(' ').unwrap_or((text, ""));
        let (hasher, size) = match algorithm {
            "sha1" => (Hasher::Sha1(Sha1::new()), 20),
            "sha256" => (Hasher::Sha256(Sha256::new()), 32),
            "blake3" => (Hasher::Blake3(Box::default()), 32),
            _ => {
                let known = ALGORITHMS.join(", ");
                return Err(invalid(format!("has an unknown algorithm: use one of {known}")));
            }
        };
        let declared = BASE64_STANDARD.decode(value.trim()).ok().filter(|v| v.len() == size);
        let fault = || invalid(format!("is not the Base64 of {size} bytes of {algorithm}"));
        Ok(Self { hasher, declared: declared.ok_or_else(fault)? })
    }

    /// Adds bytes.
    pub(crate) fn update(&mut self, bytes: &[u8]) {
        match &mut self.hasher {
            Hasher::Sha1(hasher) => hasher.update(bytes),
            Hasher::Sha256(hasher) => hasher.update(bytes),
            Hasher::Blake3(hasher) => drop(hasher.update(bytes)),
        }
    }

    /// Compares the checksum of the bytes with the declared one.
    pub(crate) fn verify(self) -> Result<()> {
        let same = match self.hasher {
            Hasher::Sha1(hasher) => hasher.finalize().as_slice() == self.declared,
            Hasher::Sha256(hasher) => hasher.finalize().as_slice() == self.declared,
            Hasher::Blake3(hasher) => hasher.finalize().as_bytes()[..] == self.declared,
        };
        if same { Ok(()) } else { Err(Error::ChecksumMismatch) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the protocol, and the same bytes by the others.
    #[test]
    fn checksums_are_compared() {
        let sha256 = BASE64_STANDARD.encode(Sha256::digest(b"hello world"));
        let blake3 = BASE64_STANDARD.encode(blake3::hash(b"hello world").as_bytes());
        for declared in [
            "sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=".to_owned(),
            format!("sha256 {sha256}"),
            format!("blake3 {blake3}"),
        ] {
            let checksum = |bytes: &[u8]| {
                let mut checksum = Checksum::parse(&declared).unwrap();
                checksum.update(bytes);
                checksum.verify()
            };
            checksum(b"hello world").unwrap();
            assert!(matches!(checksum(b"hello worlds"), Err(Error::ChecksumMismatch)));
        }
    }

    #[test]
    fn what_is_none_is_refused() {
        for text in ["", "sha1", "sha1 ?", "sha1 AAAA", "md5 AAAA", "SHA1 AAAA"] {
            assert!(Checksum::parse(text).is_err(), "{text}");
        }
    }
}

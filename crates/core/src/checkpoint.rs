//! The envelope of every checkpoint: what kind it is, which build wrote it, and which work it
//! belongs to. Every build that has the version of the kind resumes from it, so that an upgrade does
//! not cost the work of hours; the build is there for people who examine a file.
//!
//! | bytes | content |
//! |---|---|
//! | 4 | magic word of the kind |
//! | 4 | version of the kind, u32 |
//! | 32 | digest of the work's inputs |
//! | 1 + n | length and text of the build |
//! | rest | payload |
//!
//! Integers are little-endian. The payload belongs to the crate that writes it.

use crate::BUILD;

/// A kind of checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Name for messages, `fit` say.
    pub name: &'static str,
    /// First bytes of every checkpoint of this kind.
    pub magic: [u8; 4],
    /// Raised by every change of the payload or of what the work computes from it.
    pub version: u32,
}

/// Reason for which a checkpoint is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Another kind of file.
    #[error("it is no {0} checkpoint")]
    Kind(&'static str),
    /// Fewer bytes than the envelope has.
    #[error("it is cut short")]
    CutShort,
    /// Another version.
    #[error("it has version {found}, this build reads {read}")]
    Version {
        /// Version of the checkpoint.
        found: u32,
        /// Version that this build reads.
        read: u32,
    },
    /// Other inputs.
    #[error("it belongs to other inputs")]
    OtherWork,
}

impl Kind {
    /// Seals a payload. `digest` is a digest of all inputs of the work apart from the build.
    pub fn seal(&self, digest: &[u8; 32], payload: &[u8]) -> Vec<u8> {
        let build = BUILD.as_bytes();
        let mut bytes = Vec::with_capacity(4 + 4 + 32 + 1 + build.len() + payload.len());
        bytes.extend(self.magic);
        bytes.extend(self.version.to_le_bytes());
        bytes.extend(digest);
        bytes.push(BUILD_LENGTH);
        bytes.extend(build);
        bytes.extend(payload);
        bytes
    }

    /// Payload of a checkpoint of this kind and version that any build wrote for the work of `digest`.
    ///
    /// # Errors
    /// If it is anything else; nothing is read past the first difference.
    pub fn open<'a>(&self, bytes: &'a [u8], digest: &[u8; 32]) -> Result<&'a [u8], Refusal> {
        let rest = bytes.strip_prefix(&self.magic).ok_or(Refusal::Kind(self.name))?;
        let (version, rest) = rest.split_first_chunk().ok_or(Refusal::CutShort)?;
        let found = u32::from_le_bytes(*version);
        if found != self.version {
            return Err(Refusal::Version { found, read: self.version });
        }
        let (owner, rest) = rest.split_first_chunk::<32>().ok_or(Refusal::CutShort)?;
        let (length, rest) = rest.split_first().ok_or(Refusal::CutShort)?;
        let (_build, payload) =
            rest.split_at_checked(usize::from(*length)).ok_or(Refusal::CutShort)?;
        if owner == digest { Ok(payload) } else { Err(Refusal::OtherWork) }
    }
}

const BUILD_LENGTH: u8 = {
    assert!(BUILD.len() <= u8::MAX as usize, "the name of the build is stored behind one byte");
    BUILD.len() as u8
};

#[cfg(test)]
mod tests;

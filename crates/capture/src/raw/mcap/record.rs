//! MCAP's records, found without believing what they say about their lengths.
//!
//! The reader of the `mcap` crate (0.26) trusts its file: for a text it allocates the length that the
//! file claims, up to 4 GiB, it panics on an attachment that is cut off, and it reads every image to
//! pass over it. Here a length is compared with what there is before anything is allocated, and images
//! are found without being read.

use std::borrow::Cow;

use super::place::Part;
use crate::Error;

/// Opcode and length.
const HEAD: u64 = 9;

/// Bytes of a record that are read while the file is searched: enough for the header of any image.
pub(super) const PREFIX: u64 = 2048;

/// Bytes that records may be read from.
#[derive(Clone, Copy)]
pub(super) enum Region<'a> {
    /// The file from here to there.
    File { start: u64, end: u64 },
    /// A chunk that was compressed.
    Memory(&'a [u8]),
}

/// A record whose length is known to fit its region.
pub(super) struct Record<'a> {
    pub(super) opcode: u8,
    /// Offset of its content, in the file or in the chunk.
    pub(super) start: u64,
    /// Bytes of its content.
    pub(super) length: u64,
    /// The first of them.
    pub(super) prefix: Cow<'a, [u8]>,
}

impl Record<'_> {
    /// Offset of the next record.
    pub(super) fn end(&self) -> u64 {
        self.start + self.length
    }
}

impl<'a> Region<'a> {
    pub(super) fn start(&self) -> u64 {
        match self {
            Self::File { start, .. } => *start,
            Self::Memory(_) => 0,
        }
    }

    /// The record at a position; `None` at the region's end.
    pub(super) fn record(&self, part: &Part, at: u64) -> Result<Option<Record<'a>>, Error> {
        let end = match self {
            Self::File { end, .. } => *end,
            Self::Memory(bytes) => bytes.len() as u64,
        };
        let left = end.saturating_sub(at);
        if left == 0 {
            return Ok(None);
        }
        let cut = || part.damaged("it ends within a record");
        let bytes = self.read(part, at, (HEAD + PREFIX).min(left))?;
        let mut fields = Fields(&bytes);
        let (opcode, length) = fields.take(1).zip(fields.u64()).ok_or_else(cut)?;
        let opcode = opcode[0];
        if length > left.saturating_sub(HEAD) {
            return Err(cut());
        }
        if opcode == 0 {
            return Err(part.damaged("it has a record of no kind"));
        }
        let head = HEAD as usize;
        let prefix = head..head + length.min(PREFIX) as usize;
        let prefix = match bytes {
            Cow::Borrowed(bytes) => bytes.get(prefix).map(Cow::Borrowed),
            Cow::Owned(bytes) => bytes.get(prefix).map(|bytes| Cow::Owned(bytes.to_vec())),
        };
        Ok(Some(Record { opcode, start: at + HEAD, length, prefix: prefix.ok_or_else(cut)? }))
    }

    /// Some bytes, which must lie inside.
    pub(super) fn read(&self, part: &Part, at: u64, length: u64) -> Result<Cow<'a, [u8]>, Error> {
        match self {
            Self::File { .. } => part.read(at, length).map(Cow::Owned),
            Self::Memory(bytes) => {
                let range = usize::try_from(at)
                    .ok()
                    .zip(usize::try_from(at.saturating_add(length)).ok())
                    .and_then(|(from, to)| bytes.get(from..to));
                range
                    .map(Cow::Borrowed)
                    .ok_or_else(|| part.damaged("a message lies outside its chunk"))
            }
        }
    }
}

/// Fields of a record, little-endian, one after another.
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    pub(super) fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }

    fn number(&mut self, n: usize) -> Option<u64> {
        Some(self.take(n)?.iter().rev().fold(0, |n, b| (n << 8) | u64::from(*b)))
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.number(2).map(|n| n as u16)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.number(4).map(|n| n as u32)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.number(8)
    }

    pub(super) fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        self.take(length).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}

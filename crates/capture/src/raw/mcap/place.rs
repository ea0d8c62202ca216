//! Places of messages, and fetching them again.

use super::chunk::Chunk;
use crate::{Error, files::SharedFile};

/// Place of a message's content.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Number of its chunk, if that is compressed.
    pub(super) chunk: Option<u32>,
    /// Start in the file or in the chunk.
    pub(super) start: u64,
    /// Length [bytes].
    pub(super) length: u64,
}

/// The file, and the compressed chunk that was last looked into. Clones read side by side.
#[derive(Clone, Debug)]
pub(super) struct Store {
    at: String,
    file: SharedFile,
    open: Option<(u32, Vec<u8>)>,
}

impl Store {
    pub(super) fn new(at: String, file: SharedFile) -> Self {
        Self { at, file, open: None }
    }

    /// The file's name, for messages.
    pub(super) fn name(&self) -> &str {
        &self.at
    }

    /// Bytes of the file.
    pub(super) fn len(&self) -> u64 {
        self.file.len()
    }

    pub(super) fn damaged(&self, fault: impl Into<String>) -> Error {
        Error::Damaged { at: self.at.clone(), fault: fault.into() }
    }

    /// Bytes of the file; `length` must have been compared with a limit.
    pub(super) fn read(&self, at: u64, length: u64) -> Result<Vec<u8>, Error> {
        if at.checked_add(length).is_none_or(|end| end > self.file.len()) {
            return Err(self.damaged("it ends within a record"));
        }
        let mut bytes = vec![0; usize::try_from(length).unwrap_or(0)];
        match self.file.read_exact_at(&mut bytes, at) {
            Ok(()) => Ok(bytes),
            Err(e) => Err(self.damaged(e.to_string())),
        }
    }

    /// The records of a compressed chunk.
    pub(super) fn unpack(&self, chunk: &Chunk) -> Result<Vec<u8>, Error> {
        let packed = self.read(chunk.start, chunk.length)?;
        chunk.unpack(&packed).map_err(|fault| self.damaged(fault))
    }

    /// A message of at most `cap` bytes.
    pub(super) fn message(
        &mut self,
        place: &Place,
        chunks: &[Chunk],
        cap: u64,
    ) -> Result<Vec<u8>, Error> {
        let Place { chunk, start, length } = *place;
        if length > cap {
            let what = format!("a message in `{}`", self.at);
            return Err(Error::TooLarge { what, bytes: length, limit: cap });
        }
        let Some(number) = chunk else { return self.read(start, length) };
        if self.open.as_ref().is_none_or(|(open, _)| *open != number) {
            // The old one goes before the new one comes.
            self.open = None;
            let chunk = chunks.get(number as usize);
            let chunk = chunk.ok_or_else(|| self.damaged("a message lies in no chunk"))?;
            self.open = Some((number, self.unpack(chunk)?));
        }
        let bytes = self.open.as_ref().and_then(|(_, bytes)| {
            let from = usize::try_from(start).ok()?;
            bytes.get(from..from.checked_add(usize::try_from(length).ok()?)?)
        });
        bytes.map(<[u8]>::to_vec).ok_or_else(|| self.damaged("a message lies outside its chunk"))
    }
}

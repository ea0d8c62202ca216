//! Places of messages, and fetching them again.

use std::sync::Arc;

use super::{
    chunk::Chunk,
    messages::Wire,
    open::{Closed, OpenChunks},
    zstd,
};
use crate::{Error, files::Section};

/// Place of a message's content.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The file, by its number.
    pub(super) part: u32,
    /// Number of its chunk, if that is compressed.
    pub(super) chunk: Option<u32>,
    /// Start in the file or in the chunk.
    pub(super) start: u64,
    /// Length [bytes].
    pub(super) length: u64,
}

/// A file of the recording.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) bytes: Section,
}

impl Part {
    /// Bytes of the file.
    pub(super) fn len(&self) -> u64 {
        self.bytes.len()
    }

    pub(super) fn damaged(&self, fault: impl Into<String>) -> Error {
        Error::Damaged { at: self.name.clone(), fault: fault.into() }
    }

    pub(super) fn wrong_message(&self, topic: &str) -> Error {
        self.damaged(format!("a message of `{topic}` is not as its schema says"))
    }

    /// Bytes of the file; `length` must have been compared with a limit.
    pub(super) fn read(&self, at: u64, length: u64) -> Result<Vec<u8>, Error> {
        if at.checked_add(length).is_none_or(|end| end > self.len()) {
            return Err(self.damaged("it ends within a record"));
        }
        let mut bytes = vec![0; usize::try_from(length).unwrap_or(0)];
        match self.bytes.read_exact_at(&mut bytes, at) {
            Ok(()) => Ok(bytes),
            Err(e) => Err(self.damaged(e.to_string())),
        }
    }

    /// The records of a compressed chunk.
    pub(super) fn unpack(&self, chunk: &Chunk) -> Result<Vec<u8>, Error> {
        let packed = self.read(chunk.start, chunk.length)?;
        chunk.unpack(&packed).map_err(|fault| self.damaged(fault))
    }
}

/// The files, and compressed chunks that were looked into. Clones read side by side.
#[derive(Clone, Debug)]
pub(super) struct Store {
    parts: Arc<Vec<Part>>,
    open: OpenChunks,
}

impl Store {
    pub(super) fn new(parts: Vec<Part>) -> Self {
        Self { parts: Arc::new(parts), open: OpenChunks::default() }
    }

    /// Name of the first file, for messages.
    pub(super) fn name(&self) -> &str {
        self.parts.first().map_or("", |part| &part.name)
    }

    /// Bytes of all files.
    pub(super) fn len(&self) -> u64 {
        self.parts.iter().map(Part::len).fold(0, u64::saturating_add)
    }

    /// Content of a message, of at most `cap` bytes, unpacked if it was compressed by itself.
    pub(super) fn content(
        &mut self,
        place: &Place,
        chunks: &[Chunk],
        cap: u64,
        wire: Wire,
    ) -> Result<Vec<u8>, Error> {
        let bytes = self.message(place, chunks, cap)?;
        if !is_packed(wire, &bytes) {
            return Ok(bytes);
        }
        let part = self.part(place.part)?;
        unpacked(&bytes, cap).map_err(|fault| part.damaged(fault))
    }

    fn part(&self, number: u32) -> Result<&Part, Error> {
        self.parts.get(number as usize).ok_or_else(|| self.missing())
    }

    fn missing(&self) -> Error {
        Error::Damaged { at: self.name().to_owned(), fault: "a file is missing".to_owned() }
    }

    fn message(&mut self, place: &Place, chunks: &[Chunk], cap: u64) -> Result<Vec<u8>, Error> {
        let Place { part, chunk, start, length } = *place;
        let part = self.part(part)?;
        if length > cap {
            let what = format!("a message in `{}`", part.name);
            return Err(Error::TooLarge { what, bytes: length, limit: cap });
        }
        let Some(number) = chunk else { return part.read(start, length) };
        let parts = Arc::clone(&self.parts);
        let part = parts.get(place.part as usize);
        let part = part.ok_or_else(|| self.missing())?;
        let records = self.open.get(number, chunks, |chunk| part.unpack(chunk));
        let records = records.map_err(|closed| match closed {
            Closed::Missing => part.damaged("a message lies in no chunk"),
            Closed::Scattered => part.damaged(
                "its messages are scattered over compressed chunks, which have to be unpacked again and again: write \
                 it anew in the order of time, for example with `mcap sort`",
            ),
            Closed::Failed(error) => error,
        })?;
        let end = start.checked_add(length).and_then(|end| usize::try_from(end).ok());
        let message = usize::try_from(start).ok().zip(end);
        match message.and_then(|(from, end)| records.get(from..end)) {
            Some(bytes) => Ok(bytes.to_vec()),
            None => Err(part.damaged("a message lies outside its chunk")),
        }
    }
}

/// A message that was compressed by itself, unpacked to at most `cap` bytes.
pub(super) fn unpacked(packed: &[u8], cap: u64) -> Result<Vec<u8>, String> {
    let content = unpacked_start(packed, cap.saturating_add(1))?;
    if content.len() as u64 > cap {
        return Err(format!("a compressed message unpacks to more than {cap} bytes"));
    }
    Ok(content)
}

/// The first `most` bytes of such a message.
pub(super) fn unpacked_start(packed: &[u8], most: u64) -> Result<Vec<u8>, String> {
    zstd::unpack(packed, most, zstd::MOST_WINDOW)
        .map_err(|fault| format!("a compressed message does not unpack: {fault}"))
}

/// `true` for a message of ROS 2 that was compressed by itself, as `ros2 bag record
/// --compression-mode message` writes it. CDR begins with other bytes than Zstandard.
pub(super) fn is_packed(wire: Wire, bytes: &[u8]) -> bool {
    wire == Wire::Ros2 && bytes.starts_with(zstd::MAGIC)
}

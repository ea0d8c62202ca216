//! A file of a capture that is read where it lies: in a folder, as a section of an archive, or in
//! memory. Clones read side by side.

use std::{
    io::{Error, ErrorKind, Read, Result},
    sync::Arc,
};

use super::storage::SharedFile;

/// Bytes of one file, from any place.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    bytes: Bytes,
    start: u64,
    length: u64,
}

#[derive(Clone, Debug)]
enum Bytes {
    File(SharedFile),
    Memory(Arc<Vec<u8>>),
}

impl Section {
    /// A file as a whole.
    pub(crate) fn of_file(file: SharedFile) -> Self {
        let length = file.len();
        Self { bytes: Bytes::File(file), start: 0, length }
    }

    /// Bytes in memory as a whole.
    pub(crate) fn of_memory(bytes: Vec<u8>) -> Self {
        let length = bytes.len() as u64;
        Self { bytes: Bytes::Memory(Arc::new(bytes)), start: 0, length }
    }

    /// Bytes `start..start + length` of an archive in a file.
    pub(super) fn within_file(file: SharedFile, start: u64, length: u64) -> Self {
        Self { bytes: Bytes::File(file), start, length }
    }

    /// Bytes `start..start + length` of an archive in memory.
    pub(super) fn within_memory(bytes: Arc<Vec<u8>>, start: u64, length: u64) -> Self {
        Self { bytes: Bytes::Memory(bytes), start, length }
    }

    /// Bytes of the file.
    pub(crate) fn len(&self) -> u64 {
        self.length
    }

    /// Fills the buffer from a position.
    ///
    /// # Errors
    /// If the file ends before the buffer does, or the system fails.
    pub(crate) fn read_exact_at(&self, buffer: &mut [u8], at: u64) -> Result<()> {
        let cut = || Error::from(ErrorKind::UnexpectedEof);
        let end = at.checked_add(buffer.len() as u64).filter(|end| *end <= self.length);
        if end.is_none() {
            return Err(cut());
        }
        let from = self.start.checked_add(at).ok_or_else(cut)?;
        match &self.bytes {
            Bytes::File(file) => file.read_exact_at(buffer, from),
            Bytes::Memory(bytes) => {
                let from = usize::try_from(from).map_err(|_| cut())?;
                let part = from.checked_add(buffer.len()).and_then(|to| bytes.get(from..to));
                buffer.copy_from_slice(part.ok_or_else(cut)?);
                Ok(())
            }
        }
    }

    /// A reader from the beginning.
    pub(crate) fn reader(&self) -> SectionReader<'_> {
        SectionReader { section: self, at: 0 }
    }
}

/// Reads a [`Section`] from its beginning to its end.
pub(crate) struct SectionReader<'a> {
    section: &'a Section,
    at: u64,
}

impl Read for SectionReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let left = self.section.length.saturating_sub(self.at);
        let count = buffer.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        self.section.read_exact_at(&mut buffer[..count], self.at)?;
        self.at += count as u64;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_ends_where_it_ends() {
        let section = Section::within_memory(Arc::new((0..10).collect()), 3, 4);
        let mut all = Vec::new();
        section.reader().read_to_end(&mut all).unwrap();
        assert_eq!((section.len(), all), (4, vec![3, 4, 5, 6]));
        let mut two = [0; 2];
        section.read_exact_at(&mut two, 2).unwrap();
        assert_eq!(two, [5, 6]);
        assert!(section.read_exact_at(&mut two, 3).is_err());
        assert!(section.read_exact_at(&mut two, u64::MAX).is_err());
    }
}

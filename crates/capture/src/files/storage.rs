//! The bytes behind an archive: a file that several readers share, or memory.

use std::{
    fs::File,
    io::{BufReader, Cursor, Error, Read, Result, Seek, SeekFrom},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use super::section::Section;

/// A file with a separate position: clones read side by side without disturbing each other.
#[derive(Clone, Debug)]
pub(crate) struct SharedFile {
    file: Arc<File>,
    length: u64,
    position: u64,
}

impl SharedFile {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file: Arc::new(file), length, position: 0 })
    }

    /// Fills the buffer from a position.
    pub(crate) fn read_exact_at(&self, mut buffer: &mut [u8], mut position: u64) -> Result<()> {
        while !buffer.is_empty() {
            let n = read_at(&self.file, buffer, position)?;
            if n == 0 {
                return Err(Error::from(std::io::ErrorKind::UnexpectedEof));
            }
            position += n as u64;
            buffer = &mut buffer[n..];
        }
        Ok(())
    }

    /// Bytes that it had when it was opened.
    pub(crate) fn len(&self) -> u64 {
        self.length
    }
}

#[cfg(unix)]
fn read_at(file: &File, buffer: &mut [u8], position: u64) -> Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, buffer, position)
}

#[cfg(windows)]
fn read_at(file: &File, buffer: &mut [u8], position: u64) -> Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, buffer, position)
}

impl Read for SharedFile {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let n = read_at(&self.file, buffer, self.position)?;
        self.position += n as u64;
        Ok(n)
    }
}

impl Seek for SharedFile {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        let target = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
            SeekFrom::Current(by) => self.position.checked_add_signed(by),
        };
        self.position = target.ok_or_else(|| Error::other("it points before its beginning"))?;
        Ok(self.position)
    }
}

/// Bytes that an archive is read from.
#[derive(Debug)]
pub(super) enum Storage<'a> {
    File(BufReader<SharedFile>),
    Memory(Cursor<&'a [u8]>),
    /// Unpacked once, shared by all readers.
    Unpacked(Cursor<Unpacked>),
}

/// Bytes that clones share.
#[derive(Clone, Debug)]
pub(super) struct Unpacked(pub(super) Arc<Vec<u8>>);

impl AsRef<[u8]> for Unpacked {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Storage<'_> {
    /// Bytes in all.
    pub(super) fn length(&self) -> u64 {
        match self {
            Self::File(reader) => reader.get_ref().len(),
            Self::Memory(reader) => reader.get_ref().len() as u64,
            Self::Unpacked(reader) => reader.get_ref().0.len() as u64,
        }
    }

    /// Bytes `start..start + length` as a separate file; none if they are borrowed.
    pub(super) fn section(&self, start: u64, length: u64) -> Option<Section> {
        match self {
            Self::File(reader) => {
                Some(Section::within_file(reader.get_ref().clone(), start, length))
            }
            Self::Unpacked(reader) => {
                Some(Section::within_memory(reader.get_ref().0.clone(), start, length))
            }
            Self::Memory(_) => None,
        }
    }

    /// The first bytes, at most `count`; the position is the start again.
    pub(super) fn first(&mut self, count: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.seek(SeekFrom::Start(0))?;
        self.by_ref().take(count).read_to_end(&mut bytes)?;
        self.seek(SeekFrom::Start(0))?;
        Ok(bytes)
    }

    /// The last bytes, at most `count`; the position is the start again.
    pub(super) fn last(&mut self, count: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.seek(SeekFrom::Start(self.length().saturating_sub(count)))?;
        self.by_ref().take(count).read_to_end(&mut bytes)?;
        self.seek(SeekFrom::Start(0))?;
        Ok(bytes)
    }
}

impl Clone for Storage<'_> {
    fn clone(&self) -> Self {
        match self {
            Self::File(reader) => Self::File(BufReader::new(reader.get_ref().clone())),
            Self::Memory(reader) => Self::Memory(reader.clone()),
            Self::Unpacked(reader) => Self::Unpacked(reader.clone()),
        }
    }
}

impl Read for Storage<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match self {
            Self::File(reader) => reader.read(buffer),
            Self::Memory(reader) => reader.read(buffer),
            Self::Unpacked(reader) => reader.read(buffer),
        }
    }
}

impl Seek for Storage<'_> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        match self {
            Self::File(reader) => reader.seek(to),
            Self::Memory(reader) => reader.seek(to),
            Self::Unpacked(reader) => reader.seek(to),
        }
    }
}

/// A reader that stops at a number of bytes.
#[derive(Clone, Debug)]
pub(super) struct Metered<R> {
    pub(super) inner: R,
    pub(super) left: Arc<AtomicU64>,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let n = self.inner.read(buffer)?;
        let left = self.left.load(Ordering::Relaxed);
        if left != u64::MAX {
            let left = left.checked_sub(n as u64);
            let left = left.ok_or_else(|| Error::other("its directory is too long"))?;
            self.left.store(left, Ordering::Relaxed);
        }
        Ok(n)
    }
}

impl<R: Seek> Seek for Metered<R> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.inner.seek(to)
    }
}

//! The files of a capture, from a folder or an archive (ZIP, tar), read into memory one by one
//! under the caps of [`Limits`]. Nothing is ever extracted to disk.

pub(crate) mod contents;
mod listing;
pub(crate) mod other;
mod part;
mod section;
mod storage;
mod tar;
mod zip;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::File,
    io::{BufReader, Cursor, Read},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use self::storage::Storage;
pub(crate) use self::{
    listing::{Contents, shortened},
    section::Section,
    storage::SharedFile,
};
use crate::{Error, Limits, limits::Budget};

/// Numbers of an archive's files by their names.
type Names = BTreeMap<String, usize>;

#[derive(Clone)]
enum Source<'a> {
    Folder(PathBuf),
    Zip(Box<zip::Zip<'a>>),
    Tar(Storage<'a>, Arc<Vec<tar::Member>>),
}

/// Bytes by which an archive's format is recognized.
const MAGIC: u64 = 512;
/// Bytes of what is compressed with gzip that have to be sound before it is called no archive.
const INSIDE: u64 = 1 << 20;

/// `true` if an entry's name stays inside the archive on every system.
pub(crate) fn is_plain(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    !drive && !name.starts_with(['/', '\\']) && name.split(['/', '\\']).all(|part| part != "..")
}

/// Files by their names relative to the capture's root.
pub(crate) struct Files<'a> {
    /// The folder's or archive's own name, without extension.
    pub(crate) name: String,
    pub(crate) limits: Limits,
    pub(crate) budget: Budget,
    source: Source<'a>,
    /// Empty for a folder.
    entries: Arc<Names>,
    /// Put before every name: the folder inside the archive that holds the capture.
    prefix: String,
    /// The folder of these files among those that were opened.
    origin: String,
    /// Size of the archive [bytes]; none for a folder.
    length: Option<u64>,
    /// Names of the files that were read, if anybody wants to know.
    read: Option<Arc<Mutex<BTreeSet<String>>>>,
}

/// A JSON document longer than this describes no recording.
pub(crate) const MAX_DOCUMENT: u64 = 16 << 20;

impl<'a> Files<'a> {
    /// Opens a folder or an archive.
    pub(crate) fn open(path: &Path, limits: &Limits) -> Result<Self, Error> {
        let at = path.display().to_string();
        let io = |source: std::io::Error| match source.kind() {
            std::io::ErrorKind::NotFound => Error::NotFound(at.clone()),
            _ => Error::Io { at: at.clone(), source },
        };
        let metadata = std::fs::metadata(path).map_err(io)?;
        if metadata.is_dir() {
            // A folder's name may contain dots, and `.` has no name at all.
            let full = path.canonicalize().map_err(io)?;
            let name = full.file_name().unwrap_or_default().to_string_lossy();
            let source = Source::Folder(path.to_owned());
            return Ok(Self::over(&name, source, Names::new(), None, limits));
        }
        let file = BufReader::new(SharedFile::open(path).map_err(io)?);
        let whole = path.file_name().unwrap_or_default().to_string_lossy();
        Self::archive(stem(&whole), &whole, Storage::File(file), limits)
    }

    /// Opens an archive in memory.
    pub(crate) fn from_bytes(name: &str, bytes: &'a [u8], limits: &Limits) -> Result<Self, Error> {
        Self::archive(name, name, Storage::Memory(Cursor::new(bytes)), limits)
    }

    fn over(
        name: &str,
        source: Source<'a>,
        entries: Names,
        length: Option<u64>,
        limits: &Limits,
    ) -> Self {
        Self {
            name: name.to_owned(),
            limits: limits.clone(),
            budget: Budget::new(limits),
            source,
            entries: Arc::new(entries),
            prefix: String::new(),
            origin: String::new(),
            length,
            read: None,
        }
    }

    /// Opens an archive, of whichever format it is; `at` is the name of its file.
    fn archive(
        name: &str,
        at: &str,
        mut storage: Storage<'a>,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let io = |source| Error::Io { at: at.to_owned(), source };
        let length = storage.length();
        let mut limits = limits.clone();
        let mut start = storage.first(MAGIC).map_err(io)?;
        let is_gzip = start.starts_with(other::GZIP);
        if is_gzip {
            // What is no archive need not be unpacked to its end.
            let inside = tar::first(storage.clone(), INSIDE)?;
            if !tar::is_tar(&inside) {
                return Err(other::gzip(at, &inside));
            }
            storage = tar::unpack(at, storage, &mut limits)?;
            start = storage.first(MAGIC).map_err(io)?;
        }
        let mut budget = Budget::new(&limits);
        let (source, names) = if tar::is_tar(&start) {
            let (members, names) = tar::open(storage.clone(), &limits, &mut budget)?;
            (Source::Tar(storage, Arc::new(members)), names)
        } else if start.starts_with(b"PK") {
            let (archive, names) = zip::open(name, storage, &limits, &mut budget)?;
            (Source::Zip(Box::new(archive)), names)
        } else {
            let unknown = || Error::UnknownKind {
                name: at.to_owned(),
                there: "which is neither a ZIP nor a tar archive".to_owned(),
            };
            return Err(other::recognise(at, &mut storage).unwrap_or_else(unknown));
        };
        let files = Self::over(name, source, names, Some(length), &limits);
        Ok(Self { budget, ..files })
    }

    /// Another reader of the same files, with a separate budget.
    pub(crate) fn fork(&self) -> Self {
        Self {
            name: self.name.clone(),
            limits: self.limits.clone(),
            budget: Budget::new(&self.limits),
            source: self.source.clone(),
            entries: self.entries.clone(),
            prefix: self.prefix.clone(),
            origin: self.origin.clone(),
            length: self.length,
            read: self.read.clone(),
        }
    }

    /// Keeps the names of the files that are read from here on.
    pub(crate) fn keep_names(&mut self) {
        self.read = Some(Arc::default());
    }

    /// Names of the files that were read since [`Files::keep_names`], as [`Files::full_name`] has
    /// them.
    pub(crate) fn names_read(&self) -> BTreeSet<String> {
        let read = self.read.as_ref();
        read.map(|names| names.lock().unwrap_or_else(PoisonError::into_inner).clone())
            .unwrap_or_default()
    }

    /// The folder that holds the capture, from the root of all files; ends with `/` unless empty.
    pub(crate) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// Name of a file from the root of what was opened.
    pub(crate) fn full_name(&self, name: &str) -> String {
        format!("{}{}{name}", self.origin, self.prefix)
    }

    /// Why there is no capture, from what lies there.
    pub(crate) fn unknown(&self) -> Error {
        let contents = self.list("");
        for name in &contents.files {
            let known = match &self.source {
                Source::Folder(root) => {
                    let file = SharedFile::open(&root.join(name)).ok();
                    let mut storage = file.map(|file| Storage::File(BufReader::new(file)));
                    storage.as_mut().and_then(|file| other::recognise(name, file))
                }
                Source::Zip(_) | Source::Tar(..) => other::packed(name),
            };
            if let Some(known) = known {
                return known;
            }
        }
        Error::UnknownKind {
            name: self.name.clone(),
            there: format!("which {}", contents.in_words()),
        }
    }

    /// Size of the archive [bytes]; none for a folder.
    pub(crate) fn length(&self) -> Option<u64> {
        self.length
    }

    /// Number of files of an archive; none for a folder.
    pub(crate) fn entry_count(&self) -> Option<usize> {
        self.length.map(|_| self.entries.len())
    }

    /// `true` if a file of this name exists.
    pub(crate) fn has(&self, name: &str) -> bool {
        let full = format!("{}{name}", self.prefix);
        match &self.source {
            Source::Folder(root) => root.join(full).is_file(),
            Source::Zip(_) | Source::Tar(..) => self.entries.contains_key(&full),
        }
    }

    /// Refuses counts of frames and points beyond the limits.
    pub(crate) fn check_counts(&self, frames: usize, points: usize) -> Result<(), Error> {
        at_most("frames", frames, self.limits.frames)?;
        at_most("tracked points", points, self.limits.points)
    }

    /// Refuses counts of control points beyond the limits.
    pub(crate) fn check_controls(&self, controls: usize) -> Result<(), Error> {
        at_most("control points", controls, self.limits.controls)
    }

    /// Refuses counts of sequences beyond the limits.
    pub(crate) fn check_sequences(&self, sequences: usize) -> Result<(), Error> {
        at_most("sequences", sequences, self.limits.sequences)
    }

    /// Reads a file that must exist.
    pub(crate) fn read(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        self.find(name)?.ok_or_else(|| Error::MissingFile(name.to_owned()))
    }

    /// Reads a JSON document that must exist.
    pub(crate) fn read_document(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        self.find_document(name)?.ok_or_else(|| Error::MissingFile(name.to_owned()))
    }

    /// Reads a JSON document that may be missing; parsed, it takes several times its size.
    pub(crate) fn find_document(&mut self, name: &str) -> Result<Option<Vec<u8>>, Error> {
        let Some(mut bytes) = self.find(name)? else { return Ok(None) };
        let size = bytes.len() as u64;
        if size > MAX_DOCUMENT {
            let what = format!("`{name}`");
            return Err(Error::TooLarge { what, bytes: size, limit: MAX_DOCUMENT });
        }
        unmark(name, &mut bytes)?;
        Ok(Some(bytes))
    }

    /// Reads a file that may be missing.
    pub(crate) fn find(&mut self, name: &str) -> Result<Option<Vec<u8>>, Error> {
        self.find_within(name, self.limits.file_bytes)
    }

    /// Reads a file that may be missing and may not be longer than `cap` bytes.
    pub(crate) fn find_within(&mut self, name: &str, cap: u64) -> Result<Option<Vec<u8>>, Error> {
        let bytes = self.read_within(name, cap.min(self.limits.file_bytes))?;
        if let Some(error) = bytes.as_ref().and_then(|bytes| other::disguised(name, bytes)) {
            return Err(error);
        }
        if bytes.is_some() {
            self.note_read(name);
        }
        Ok(bytes)
    }

    /// A file that must exist, to be read where it lies; one that is compressed in an archive is
    /// read into memory.
    pub(crate) fn section(&mut self, name: &str) -> Result<Section, Error> {
        self.refuse_disguised(name)?;
        let full = format!("{}{name}", self.prefix);
        let found = match &mut self.source {
            Source::Folder(root) => {
                let io = |source| Error::Io { at: full.clone(), source };
                Some(Section::of_file(SharedFile::open(&root.join(&full)).map_err(io)?))
            }
            Source::Zip(archive) => match self.entries.get(&full) {
                Some(&index) => zip::section(archive, index, &full)?,
                None => None,
            },
            Source::Tar(storage, members) => {
                let member = self.entries.get(&full).and_then(|index| members.get(*index));
                match member {
                    Some(&member) => tar::section(storage, member, &full)?,
                    None => None,
                }
            }
        };
        let Some(section) = found else { return self.read(name).map(Section::of_memory) };
        self.note_read(name);
        Ok(section)
    }

    /// Keeps the name of a file that is read, if anybody wants to know.
    fn note_read(&self, name: &str) {
        if let Some(names) = &self.read {
            let name = self.full_name(name);
            names.lock().unwrap_or_else(PoisonError::into_inner).insert(name);
        }
    }

    /// Refuses a file that stands in for another: a pointer of Git LFS, a web page.
    ///
    /// # Errors
    /// If it is one of those; that it cannot be read is for its reader to say.
    pub(crate) fn refuse_disguised(&mut self, name: &str) -> Result<(), Error> {
        match self.find_within(name, other::LONGEST_POINTER) {
            Err(error @ Error::OtherFormat { .. }) => Err(error),
            _ => Ok(()),
        }
    }

    fn read_within(&mut self, name: &str, cap: u64) -> Result<Option<Vec<u8>>, Error> {
        let full = format!("{}{name}", self.prefix);
        if let Source::Folder(root) = &self.source {
            let path = root.join(&full);
            let Ok(metadata) = std::fs::metadata(&path) else { return Ok(None) };
            if !metadata.is_file() {
                return Ok(None);
            }
            let io = |source| Error::Io { at: full.clone(), source };
            let file = File::open(&path).map_err(io)?;
            return read_capped(name, file, metadata.len(), cap, &mut self.budget).map(Some);
        }
        let Some(&index) = self.entries.get(&full) else { return Ok(None) };
        let (names, limits) = ([full.as_str(), name], &self.limits);
        match &mut self.source {
            Source::Folder(_) => Ok(None),
            Source::Zip(archive) => {
                zip::read(archive, index, names, cap, limits, &mut self.budget).map(Some)
            }
            Source::Tar(storage, members) => {
                let Some(&member) = members.get(index) else { return Ok(None) };
                tar::read(storage, member, names, cap, &mut self.budget).map(Some)
            }
        }
    }
}

/// Takes off the mark that some editors put before UTF-8, and refuses UTF-16.
pub(crate) fn unmark(name: &str, bytes: &mut Vec<u8>) -> Result<(), Error> {
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        let fault = "it is UTF-16 text: save it as UTF-8".to_owned();
        return Err(Error::Document { at: name.to_owned(), fault });
    }
    Ok(())
}

/// A file's name without the extension of an archive.
fn stem(name: &str) -> &str {
    let lower = name.to_ascii_lowercase();
    let double = [".tar.gz", ".tar.bz2"].iter().find(|ending| lower.ends_with(**ending));
    let end = double.map_or_else(|| name.rfind('.'), |ending| Some(name.len() - ending.len()));
    match end {
        Some(end) if end > 0 => name.get(..end).unwrap_or(name),
        _ => name,
    }
}

/// Refuses more of something than a limit allows.
pub(crate) fn at_most(what: &'static str, count: usize, limit: usize) -> Result<(), Error> {
    if count > limit {
        return Err(Error::TooMany { what, count: count as u64, limit: limit as u64 });
    }
    Ok(())
}

/// Reads exactly the announced bytes; the announcement is checked first and not trusted after.
fn read_capped(
    name: &str,
    reader: impl Read,
    size: u64,
    limit: u64,
    budget: &mut Budget,
) -> Result<Vec<u8>, Error> {
    if size > limit {
        return Err(Error::TooLarge { what: format!("`{name}`"), bytes: size, limit });
    }
    budget.take(size, &format!("`{name}`"))?;
    let damaged = |fault: String| Error::Damaged { at: name.to_owned(), fault };
    // Grows as bytes arrive: a header that lies about its size costs nothing.
    let mut bytes = Vec::new();
    reader.take(size + 1).read_to_end(&mut bytes).map_err(|e| damaged(e.to_string()))?;
    if bytes.len() as u64 != size {
        return Err(damaged(format!("it announces {size} bytes but holds {}", bytes.len())));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests;

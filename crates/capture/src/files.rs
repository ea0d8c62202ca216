//! The files of a capture, from a folder or a ZIP archive, read into memory one
//! by one under the caps of [`Limits`]. Nothing is ever extracted to disk.

mod part;
mod storage;

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufReader, Cursor, Read},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use zip::{ZipArchive, result::ZipError};

pub(crate) use self::storage::SharedFile;
use self::storage::{Metered, Storage};
use crate::{Error, Limits, limits::Budget};

#[derive(Clone)]
enum Source<'a> {
    Folder(PathBuf),
    Zip(Box<ZipArchive<Metered<Storage<'a>>>>),
}

/// Bytes that looking for an archive's directory may read, and those of an
/// entry apart from its name.
const DIRECTORY_SEARCH: u64 = 256 << 10;
const DIRECTORY_ENTRY: usize = 256;

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
    /// Entry index of each name; empty for a folder.
    entries: Arc<BTreeMap<String, usize>>,
    /// Put before every name: the folder inside the archive that holds the capture.
    prefix: String,
    /// Size of the archive [bytes]; none for a folder.
    length: Option<u64>,
}

/// A JSON document longer than this describes no recording.
pub(crate) const MAX_DOCUMENT: u64 = 16 << 20;

/// Most folders between the root of an archive or folder and a capture.
const MAX_NESTING: usize = 2;

impl<'a> Files<'a> {
    /// Opens a folder or an archive.
    pub(crate) fn open(path: &Path, limits: &Limits) -> Result<Self, Error> {
        let at = path.display().to_string();
        let io = |source: std::io::Error| match source.kind() {
            std::io::ErrorKind::NotFound => Error::NotFound(at.clone()),
            _ => Error::Io { at: at.clone(), source },
        };
        let metadata = std::fs::metadata(path).map_err(io)?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        if metadata.is_dir() {
            // A folder's name may contain dots, and `.` has no name at all.
            let full = path.canonicalize().map_err(io)?;
            let name = full.file_name().unwrap_or_default().to_string_lossy();
            return Ok(Self {
                name: name.into_owned(),
                limits: limits.clone(),
                budget: Budget::new(limits),
                source: Source::Folder(path.to_owned()),
                entries: Arc::default(),
                prefix: String::new(),
                length: None,
            });
        }
        let file = BufReader::new(SharedFile::open(path).map_err(io)?);
        Self::zip(&stem, Storage::File(file), limits)
    }

    /// Opens an archive in memory.
    pub(crate) fn from_bytes(name: &str, bytes: &'a [u8], limits: &Limits) -> Result<Self, Error> {
        Self::zip(name, Storage::Memory(Cursor::new(bytes)), limits)
    }

    /// Another reader of the same files, with a budget of its own.
    pub(crate) fn fork(&self) -> Self {
        Self {
            name: self.name.clone(),
            limits: self.limits.clone(),
            budget: Budget::new(&self.limits),
            source: self.source.clone(),
            entries: self.entries.clone(),
            prefix: self.prefix.clone(),
            length: self.length,
        }
    }

    fn zip(name: &str, mut reader: Storage<'a>, limits: &Limits) -> Result<Self, Error> {
        let length = reader.length();
        let mut magic = [0; 2];
        let is_zip = reader.read_exact(&mut magic).is_ok() && &magic == b"PK";
        if !is_zip {
            return Err(Error::UnknownKind(name.to_owned()));
        }
        let mut budget = Budget::new(limits);
        // The directory is read whole before its entries can be counted.
        let longest = (DIRECTORY_ENTRY + limits.name_bytes) as u64;
        let left = DIRECTORY_SEARCH
            .saturating_add((limits.archive_entries as u64).saturating_mul(longest));
        let left = Arc::new(AtomicU64::new(left));
        let metered = Metered { inner: reader, left: left.clone() };
        let mut archive = ZipArchive::new(metered).map_err(|e| unusable(name, e))?;
        left.store(u64::MAX, Ordering::Relaxed);
        let directory = archive.metadata();
        let entries = directory.len();
        if entries > limits.archive_entries {
            return Err(Error::ArchiveEntries { entries, limit: limits.archive_entries });
        }
        if directory.has_duplicate_names() {
            return Err(Error::ArchiveDuplicate);
        }
        // Sizes in the directory mean something only where no byte belongs to two entries.
        if archive.has_overlapping_entries().map_err(|e| unusable(name, e))? {
            return Err(Error::ArchiveOverlap);
        }
        let mut unpacked = 0_u64;
        let mut names = BTreeMap::new();
        for index in 0..entries {
            let entry = directory.entry(index).map_err(|e| unusable(name, e))?;
            let raw = String::from_utf8_lossy(entry.name_raw()).into_owned();
            if raw.len() > limits.name_bytes {
                return Err(Error::ArchiveName(
                    raw.chars().take(80).chain("...".chars()).collect(),
                ));
            }
            let enclosed = entry.enclosed_name().and_then(|p| p.to_str().map(str::to_owned));
            let Some(enclosed) = enclosed.filter(|_| is_plain(&raw)) else {
                return Err(Error::ArchiveName(raw));
            };
            unpacked = unpacked.saturating_add(entry.size());
            if !entry.is_dir() {
                names.insert(enclosed.replace('\\', "/"), index);
            }
        }
        budget.take(entries as u64 * 256, "the archive's directory")?;
        let limit = limits.unpacked_of(length);
        if unpacked > limit {
            let what = "the archive's unpacked content".to_owned();
            return Err(Error::TooLarge { what, bytes: unpacked, limit });
        }
        Ok(Self {
            name: name.to_owned(),
            limits: limits.clone(),
            budget,
            source: Source::Zip(Box::new(archive)),
            entries: Arc::new(names),
            prefix: String::new(),
            length: Some(length),
        })
    }

    /// Moves the root to the one place where a file of this name lies, at most
    /// two folders deep.
    ///
    /// # Errors
    /// If there are several.
    pub(crate) fn enter(&mut self, marker: &str) -> Result<bool, Error> {
        let found: Vec<String> = match &self.source {
            Source::Folder(root) => {
                if root.join(marker).is_file() {
                    return Ok(true);
                }
                let inner = std::fs::read_dir(root)
                    .map_err(|source| Error::Io { at: self.name.clone(), source })?;
                inner
                    .take(self.limits.archive_entries)
                    .filter_map(|entry| {
                        let entry = entry.ok()?;
                        let name = entry.file_name().to_str()?.to_owned();
                        entry.path().join(marker).is_file().then(|| format!("{name}/"))
                    })
                    .collect()
            }
            Source::Zip(_) => {
                if self.entries.contains_key(marker) {
                    return Ok(true);
                }
                let ending = format!("/{marker}");
                let prefixes = self.entries.keys().filter(|n| !n.starts_with("__MACOSX/"));
                prefixes
                    .filter_map(|n| n.strip_suffix(&ending))
                    .filter(|p| p.split('/').count() <= MAX_NESTING)
                    .map(|p| format!("{p}/"))
                    .collect()
            }
        };
        match found.as_slice() {
            [] => Ok(false),
            [one] => {
                self.prefix.clone_from(one);
                if let Some(name) = one.trim_end_matches('/').rsplit('/').next() {
                    name.clone_into(&mut self.name);
                }
                Ok(true)
            }
            several => {
                let names: Vec<&str> =
                    several.iter().take(5).map(|p| p.trim_end_matches('/')).collect();
                Err(Error::Several(names.join(", ")))
            }
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
            Source::Zip(_) => self.entries.contains_key(&full),
        }
    }

    /// `true` if some file's name starts so (`color/`, say).
    pub(crate) fn has_under(&self, folder: &str) -> bool {
        let full = format!("{}{folder}", self.prefix);
        match &self.source {
            Source::Folder(root) => root.join(full).is_dir(),
            Source::Zip(_) => self.entries.keys().any(|n| n.starts_with(&full)),
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
        let bytes = self.find(name)?;
        match bytes.as_ref().map(|b| b.len() as u64).filter(|len| *len > MAX_DOCUMENT) {
            Some(bytes) => {
                Err(Error::TooLarge { what: format!("`{name}`"), bytes, limit: MAX_DOCUMENT })
            }
            None => Ok(bytes),
        }
    }

    /// Reads a file that may be missing.
    pub(crate) fn find(&mut self, name: &str) -> Result<Option<Vec<u8>>, Error> {
        self.find_within(name, self.limits.file_bytes)
    }

    /// Reads a file that may be missing and may not be longer than `cap` bytes.
    pub(crate) fn find_within(&mut self, name: &str, cap: u64) -> Result<Option<Vec<u8>>, Error> {
        let cap = cap.min(self.limits.file_bytes);
        let full = format!("{}{name}", self.prefix);
        match &mut self.source {
            Source::Folder(root) => {
                let path = root.join(&full);
                let Ok(metadata) = std::fs::metadata(&path) else { return Ok(None) };
                if !metadata.is_file() {
                    return Ok(None);
                }
                let io = |source| Error::Io { at: full.clone(), source };
                let file = File::open(&path).map_err(io)?;
                read_capped(name, file, metadata.len(), cap, &mut self.budget).map(Some)
            }
            Source::Zip(archive) => {
                let Some(&index) = self.entries.get(&full) else { return Ok(None) };
                let entry = archive.by_index(index).map_err(|e| unusable(&full, e))?;
                let kind = match entry.unix_mode().map(|m| m & 0o170_000) {
                    _ if entry.encrypted() => Some("encrypted"),
                    _ if entry.is_symlink() => Some("a link"),
                    Some(0 | 0o100_000) | None => None,
                    Some(_) => Some("a special file"),
                };
                if let Some(kind) = kind {
                    return Err(Error::ArchiveEntryKind { at: full, kind });
                }
                let size = entry.size();
                let ratio = size / entry.compressed_size().max(1);
                if size >= self.limits.ratio_from_bytes && ratio > self.limits.compression_ratio {
                    let limit = self.limits.compression_ratio;
                    return Err(Error::ArchiveRatio { at: full, ratio, limit });
                }
                read_capped(name, entry, size, cap, &mut self.budget).map(Some)
            }
        }
    }
}

/// Why an archive or an entry of it cannot be read.
fn unusable(at: &str, error: ZipError) -> Error {
    match error {
        ZipError::UnsupportedArchive(ZipError::PASSWORD_REQUIRED) => {
            Error::ArchiveEntryKind { at: at.to_owned(), kind: "encrypted" }
        }
        other => Error::ArchiveDamaged(other.to_string()),
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

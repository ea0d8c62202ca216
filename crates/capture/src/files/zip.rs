//! ZIP archives: the directory is checked as a whole before a file is read.

use std::{
    collections::BTreeMap,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use ruzstd::decoding::StreamingDecoder;
use zip::{CompressionMethod, ZipArchive, result::ZipError};

use super::{
    Names, is_plain, read_capped,
    section::Section,
    storage::{Metered, Storage},
};
use crate::{Error, Limits, limits::Budget};

/// Bytes that looking for an archive's directory may read, and those of an
/// entry apart from its name.
pub(super) const DIRECTORY_SEARCH: u64 = 256 << 10;
pub(super) const DIRECTORY_ENTRY: usize = 256;

/// Window of Zstandard allowed for entries of any size: the window that every decoder has to
/// support (RFC 8878).
const MOST_WINDOW: u64 = 8 << 20;

pub(super) type Zip<'a> = ZipArchive<Metered<Storage<'a>>>;

/// Opens an archive; the names of its files with their numbers.
pub(super) fn open<'a>(
    name: &str,
    storage: Storage<'a>,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<(Zip<'a>, Names), Error> {
    let length = storage.length();
    // The directory is read whole before its entries can be counted.
    let left = Arc::new(AtomicU64::new(directory_bytes(limits)));
    let metered = Metered { inner: storage, left: left.clone() };
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
        check_length(&raw, limits)?;
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
    check_unpacked(unpacked, length, limits)?;
    Ok((archive, names))
}

/// Bytes that the directory of an archive may have.
pub(super) fn directory_bytes(limits: &Limits) -> u64 {
    let longest = (DIRECTORY_ENTRY + limits.name_bytes) as u64;
    DIRECTORY_SEARCH.saturating_add((limits.archive_entries as u64).saturating_mul(longest))
}

pub(super) fn check_length(name: &str, limits: &Limits) -> Result<(), Error> {
    if name.len() > limits.name_bytes {
        return Err(Error::ArchiveName(name.chars().take(80).chain("...".chars()).collect()));
    }
    Ok(())
}

/// Refuses more unpacked bytes than an archive of `length` bytes may hold.
pub(super) fn check_unpacked(unpacked: u64, length: u64, limits: &Limits) -> Result<(), Error> {
    let limit = limits.unpacked_of(length);
    if unpacked > limit {
        let what = "the archive's unpacked content".to_owned();
        return Err(Error::TooLarge { what, bytes: unpacked, limit });
    }
    Ok(())
}

/// Reads the file with this number; `full` is its name in the archive, `name` that in the capture.
pub(super) fn read(
    archive: &mut Zip<'_>,
    index: usize,
    [full, name]: [&str; 2],
    cap: u64,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Vec<u8>, Error> {
    let entry = archive.by_index_raw(index).map_err(|e| unusable(full, e))?;
    let kind = match entry.unix_mode().map(|m| m & 0o170_000) {
        _ if entry.encrypted() => Some("encrypted"),
        _ if entry.is_symlink() => Some("a link"),
        Some(0 | 0o100_000) | None => None,
        Some(_) => Some("a special file"),
    };
    if let Some(kind) = kind {
        return Err(Error::ArchiveEntryKind { at: full.to_owned(), kind });
    }
    let size = entry.size();
    let ratio = size / entry.compressed_size().max(1);
    if size >= limits.ratio_from_bytes && ratio > limits.compression_ratio {
        let limit = limits.compression_ratio;
        return Err(Error::ArchiveRatio { at: full.to_owned(), ratio, limit });
    }
    let method = entry.compression();
    let crc = entry.crc32();
    match method {
        CompressionMethod::ZSTD => {
            let window = size.min(cap).max(MOST_WINDOW);
            let decoder = StreamingDecoder::new_with_max_window_size(entry, window)
                .map_err(|e| Error::Damaged { at: name.to_owned(), fault: e.to_string() })?;
            let bytes = read_capped(name, decoder, size, cap, budget)?;
            if crc32fast::hash(&bytes) != crc {
                let fault = "its checksum is wrong".to_owned();
                return Err(Error::Damaged { at: name.to_owned(), fault });
            }
            Ok(bytes)
        }
        CompressionMethod::Stored
        | CompressionMethod::Deflated
        | CompressionMethod::Deflate64
        | CompressionMethod::Bzip2 => {
            drop(entry);
            let entry = archive.by_index(index).map_err(|e| unusable(full, e))?;
            read_capped(name, entry, size, cap, budget)
        }
        other => Err(Error::ArchiveCompression { at: full.to_owned(), method: method_name(other) }),
    }
}

/// The file with this number where it lies; none if it is compressed.
pub(super) fn section(
    archive: &mut Zip<'_>,
    index: usize,
    full: &str,
) -> Result<Option<Section>, Error> {
    let entry = archive.by_index_raw(index).map_err(|e| unusable(full, e))?;
    let is_plain_file = !entry.encrypted() && !entry.is_symlink();
    let is_stored = entry.compression() == CompressionMethod::Stored;
    let (start, length) = (entry.data_start(), entry.size());
    let whole = entry.compressed_size() == length;
    drop(entry);
    let start = start.filter(|_| is_plain_file && is_stored && whole);
    let Some(start) = start else { return Ok(None) };
    let storage = archive.clone().into_inner().inner;
    if start.checked_add(length).is_none_or(|end| end > storage.length()) {
        return Err(Error::ArchiveDamaged(format!("it ends within `{full}`")));
    }
    Ok(storage.section(start, length))
}

/// A compression that is not read, as its users call it.
fn method_name(method: CompressionMethod) -> String {
    for (known, name) in [
        (CompressionMethod::LZMA, "LZMA"),
        (CompressionMethod::XZ, "xz"),
        (CompressionMethod::PPMD, "PPMd"),
        (CompressionMethod::AES, "AES encryption"),
    ] {
        if method == known {
            return name.to_owned();
        }
    }
    let text = format!("{method:?}");
    let number: String = text.chars().filter(char::is_ascii_digit).collect();
    format!("method {number}")
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

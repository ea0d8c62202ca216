//! Tar archives, also compressed with gzip: one pass over the headers finds all files, after which
//! each is read from its place. A compressed one has no places, so it is unpacked in memory first.

use std::{
    collections::BTreeMap,
    io::{Cursor, Read as _, Seek as _, SeekFrom},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use flate2::read::MultiGzDecoder;
use tar::{Archive, EntryType};

use super::{
    Names, is_plain, read_capped,
    section::Section,
    storage::{Metered, Storage, Unpacked},
    zip::{check_length, check_unpacked, directory_bytes},
};
use crate::{Error, Limits, limits::Budget};

/// Bytes of a header; files are padded to a multiple of them.
const BLOCK: u64 = 512;

/// Bytes unpacked between two checks of the total.
const STEP: u64 = 1 << 20;

/// Place of a file in the archive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    start: u64,
    size: u64,
    /// Kind of an entry that is no regular file.
    kind: Option<&'static str>,
}

/// `true` if an archive begins so.
pub(super) fn is_tar(start: &[u8]) -> bool {
    start.get(257..262) == Some(b"ustar")
}

/// Finds all files of an archive.
pub(super) fn open(
    mut storage: Storage<'_>,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<(Vec<Member>, Names), Error> {
    let length = storage.length();
    storage.rewind().map_err(|e| damaged(&e))?;
    // The parser reads long names into memory: they count as the directory.
    let left = Arc::new(AtomicU64::new(directory_bytes(limits)));
    let mut archive = Archive::new(Metered { inner: storage, left: left.clone() });
    let (mut members, mut names) = (Vec::new(), BTreeMap::new());
    let (mut unpacked, mut end) = (0_u64, 0);
    for entry in archive.entries_with_seek().map_err(|e| damaged(&e))? {
        let entry = entry.map_err(|e| damaged(&e))?;
        if members.len() >= limits.archive_entries {
            let entries = members.len() + 1;
            return Err(Error::ArchiveEntries { entries, limit: limits.archive_entries });
        }
        let raw = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
        check_length(&raw, limits)?;
        if !is_plain(&raw) || raw.contains('\0') {
            return Err(Error::ArchiveName(raw));
        }
        let (start, size) = (entry.raw_file_position(), entry.size());
        end = start.saturating_add(size);
        if end > length {
            return Err(Error::ArchiveDamaged(format!("it ends within `{raw}`")));
        }
        let mut member = Member { start, size, kind: None };
        member.kind = match entry.header().entry_type() {
            EntryType::Directory | EntryType::XGlobalHeader => continue,
            EntryType::Regular | EntryType::Continuous => None,
            // A second name of a file that comes before it.
            EntryType::Link => {
                let target = entry.link_name_bytes().unwrap_or_default();
                let target = plain(&String::from_utf8_lossy(&target));
                let known = names.get(&target).and_then(|index: &usize| members.get(*index));
                match known {
                    Some(target) => {
                        member = *target;
                        target.kind
                    }
                    None => Some("a link to a file that is not in it"),
                }
            }
            EntryType::Symlink => Some("a link"),
            EntryType::GNUSparse => Some("a sparse file"),
            _ => Some("a special file"),
        };
        unpacked = unpacked.saturating_add(member.size);
        if names.insert(plain(&raw), members.len()).is_some() {
            return Err(Error::ArchiveDuplicate);
        }
        members.push(member);
    }
    left.store(u64::MAX, Ordering::Relaxed);
    // Blocks of zeros end an archive: one without was cut off between two files.
    if end.div_ceil(BLOCK).saturating_mul(BLOCK) >= length {
        return Err(Error::ArchiveDamaged("it has no end".to_owned()));
    }
    budget.take(members.len() as u64 * 256, "the archive's directory")?;
    check_unpacked(unpacked, length, limits)?;
    Ok((members, names))
}

/// A name without the parts that say nothing: `tar -C folder .` writes `./color/0.png`.
fn plain(name: &str) -> String {
    let parts = name.split(['/', '\\']).filter(|part| !part.is_empty() && *part != ".");
    parts.collect::<Vec<_>>().join("/")
}

/// Reads a file; `full` is its name in the archive, `name` that in the capture.
pub(super) fn read(
    storage: &mut Storage<'_>,
    member: Member,
    [full, name]: [&str; 2],
    cap: u64,
    budget: &mut Budget,
) -> Result<Vec<u8>, Error> {
    if let Some(kind) = member.kind {
        return Err(Error::ArchiveEntryKind { at: full.to_owned(), kind });
    }
    storage.seek(SeekFrom::Start(member.start)).map_err(|e| damaged(&e))?;
    read_capped(name, storage.take(member.size), member.size, cap, budget)
}

/// The first bytes of what is compressed with gzip, at most `count`.
pub(super) fn first(storage: Storage<'_>, count: u64) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let read = MultiGzDecoder::new(storage).take(count).read_to_end(&mut bytes);
    read.map_err(|e| damaged(&e)).map(|_| bytes)
}

/// A file of an archive where it lies; none if the archive is borrowed memory.
pub(super) fn section(
    storage: &Storage<'_>,
    member: Member,
    full: &str,
) -> Result<Option<Section>, Error> {
    if let Some(kind) = member.kind {
        return Err(Error::ArchiveEntryKind { at: full.to_owned(), kind });
    }
    Ok(storage.section(member.start, member.size))
}

/// Unpacks gzip in memory, and takes what that needs from the limits of all that follows.
pub(super) fn unpack<'a>(
    name: &str,
    storage: Storage<'a>,
    limits: &mut Limits,
) -> Result<Storage<'a>, Error> {
    let length = storage.length();
    // Memory that grows may be twice what it holds.
    let limit = limits.unpacked_of(length).min(limits.total_bytes / 2);
    let mut decoder = MultiGzDecoder::new(storage);
    let mut bytes = Vec::new();
    loop {
        let read = decoder.by_ref().take(STEP).read_to_end(&mut bytes).map_err(|e| damaged(&e))?;
        if read == 0 {
            break;
        }
        let unpacked = bytes.len() as u64;
        let ratio = unpacked / length.max(1);
        if unpacked >= limits.ratio_from_bytes && ratio > limits.compression_ratio {
            let limit = limits.compression_ratio;
            return Err(Error::ArchiveRatio { at: name.to_owned(), ratio, limit });
        }
        if unpacked > limit {
            return Err(Error::UnpackedInMemory { at: name.to_owned(), limit });
        }
    }
    bytes.shrink_to_fit();
    limits.total_bytes = limits.total_bytes.saturating_sub(bytes.len() as u64);
    Ok(Storage::Unpacked(Cursor::new(Unpacked(Arc::new(bytes)))))
}

fn damaged(error: &std::io::Error) -> Error {
    Error::ArchiveDamaged(error.to_string())
}

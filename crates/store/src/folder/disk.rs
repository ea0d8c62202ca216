//! The disk of the data folder, and a reserve on it. On a full disk nothing could be deleted, as
//! the database grows a little before it shrinks. So a file of some MiB reserves space: it is
//! removed when the database meets a full disk, which lets deletions and the ends of jobs through,
//! and made again once there is space. Until then new content is refused.

use std::{
    fs::{self, File},
    io::{self, ErrorKind, Write as _},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use rustix::fs::{FallocateFlags, fallocate, statvfs};

use crate::{Error, Result};

/// Size of the reserve [bytes].
pub(crate) const RESERVE: u64 = 16 << 20;
/// Free space below which a change of the database may fail [bytes].
const LOW: u64 = 4 << 20;

/// Space of the disk that has the data folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Disk {
    /// Space that this process may still use [bytes].
    pub free_bytes: u64,
    /// Size of the file system [bytes].
    pub total_bytes: u64,
}

impl Disk {
    /// The disk of a folder.
    pub(crate) fn of(folder: &Path) -> Result<Self> {
        let found = statvfs(folder).map_err(io::Error::from)?;
        Ok(Self {
            free_bytes: found.f_bavail.saturating_mul(found.f_frsize),
            total_bytes: found.f_blocks.saturating_mul(found.f_frsize),
        })
    }
}

/// The reserve of a data folder.
#[derive(Debug)]
pub(crate) struct Reserve {
    folder: PathBuf,
    file: PathBuf,
    /// Held while it is made: one caller makes it for all.
    making: Mutex<()>,
}

impl Reserve {
    /// The reserve of a folder, made if there is space for it.
    pub(crate) fn open(data_dir: &Path) -> Self {
        let (folder, file) = (data_dir.to_owned(), data_dir.join("reserve"));
        let reserve = Self { folder, file, making: Mutex::default() };
        if !reserve.refill() {
            tracing::warn!(
                "the disk is full: new content is refused until {} MiB are free",
                (RESERVE + 2 * LOW) >> 20
            );
        }
        reserve
    }

    fn is_held(&self) -> bool {
        fs::metadata(&self.file).is_ok_and(|file| file.len() == RESERVE)
    }

    /// Gives the reserve up if the disk is as good as full. Called before changes of the database.
    pub(crate) fn release_if_low(&self) {
        if Disk::of(&self.folder).is_ok_and(|disk| disk.free_bytes < LOW) {
            self.release();
        }
    }

    /// Releases the reserve. Returns false if there was no reserve.
    pub(crate) fn release(&self) -> bool {
        let released = fs::remove_file(&self.file).is_ok();
        if released {
            tracing::error!("the disk is full: new content is refused until there is space again");
        }
        released
    }

    /// Refuses new content on a full disk.
    pub(crate) fn admit(&self) -> Result<()> {
        if self.refill() { Ok(()) } else { Err(Error::DiskFull) }
    }

    /// Makes the reserve if there is more free space than it needs. Returns true if it exists.
    fn refill(&self) -> bool {
        let _making = self.making.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_held() {
            return true;
        }
        let has_room = |disk: Disk| disk.free_bytes >= RESERVE + 2 * LOW;
        if !Disk::of(&self.folder).is_ok_and(has_room) {
            return false;
        }
        // Under another name until it is complete.
        let partial = self.file.with_extension("partial");
        let made = allocate(&partial).and_then(|()| fs::rename(&partial, &self.file));
        if let Err(error) = &made {
            tracing::warn!(%error, "the reserve of the disk cannot be made");
            fs::remove_file(&partial).ok();
        }
        made.is_ok()
    }
}

/// Makes a file of the size of the reserve, with all of its space allocated on the disk.
fn allocate(path: &Path) -> io::Result<()> {
    let mut file = File::create(path)?;
    if fallocate(&file, FallocateFlags::empty(), 0, RESERVE).is_err() {
        // A file system without it may compress zeros away.
        let mut noise = blake3::Hasher::new().finalize_xof();
        let mut block = vec![0; 1 << 20];
        for _ in 0..RESERVE >> 20 {
            noise.fill(&mut block);
            file.write_all(&block)?;
        }
    }
    Ok(())
}

/// True if the disk, or the quota on it, is used up.
pub(crate) fn is_full(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
}

#[cfg(test)]
mod tests;

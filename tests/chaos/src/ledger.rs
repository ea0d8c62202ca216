//! Everything that was acknowledged, with what it has to be at the end.

use std::{
    collections::BTreeMap,
    fmt,
    fs::File,
    io::Write as _,
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
    time::Instant,
};

/// Fate of a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// Must exist.
    Kept,
    /// The deletion was requested and not acknowledged: may exist.
    Leaving,
    /// Must not exist.
    Deleted,
}

/// A stored capture or imported twin.
#[derive(Clone, Debug)]
pub(crate) struct Stored {
    /// BLAKE3 of its content.
    pub(crate) digest: String,
    pub(crate) fate: Fate,
    /// True for a file that means harm, whose job may end anyhow.
    pub(crate) is_hostile: bool,
    /// Number of the archive that was added to it.
    pub(crate) supplement: Option<usize>,
}

impl Stored {
    fn new(digest: &str, is_hostile: bool) -> Self {
        Self { digest: digest.to_owned(), fate: Fate::Kept, is_hostile, supplement: None }
    }
}

/// A fit.
#[derive(Clone, Debug)]
pub(crate) struct Ordered {
    /// Number of the reference that it has to repeat.
    pub(crate) work: usize,
    pub(crate) cancelled: bool,
    pub(crate) fate: Fate,
}

/// A resumable upload that is not complete.
#[derive(Clone, Debug)]
pub(crate) struct Begun {
    /// Number of the archive.
    pub(crate) archive: usize,
    /// Bytes that are acknowledged.
    pub(crate) offset: u64,
}

/// The acknowledged things, by name.
#[derive(Debug, Default)]
pub(crate) struct Things {
    pub(crate) captures: BTreeMap<String, Stored>,
    pub(crate) twins: BTreeMap<String, Stored>,
    pub(crate) fits: BTreeMap<String, Ordered>,
    /// Uploads by path.
    pub(crate) uploads: BTreeMap<String, Begun>,
}

/// The ledger, in memory and as lines of a file.
#[derive(Debug)]
pub(crate) struct Ledger {
    things: Mutex<Things>,
    file: Mutex<File>,
    started: Instant,
}

impl Ledger {
    pub(crate) fn new(folder: &Path) -> std::io::Result<Self> {
        let file = Mutex::new(File::create(folder.join("ledger.log"))?);
        Ok(Self { things: Mutex::default(), file, started: Instant::now() })
    }

    pub(crate) fn things(&self) -> MutexGuard<'_, Things> {
        self.things.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn line(&self, line: impl fmt::Display) {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // The ledger counts in memory; the file is for people.
        writeln!(file, "{:9.3} {line}", self.started.elapsed().as_secs_f64()).ok();
    }

    /// A capture was acknowledged.
    pub(crate) fn capture(&self, name: &str, digest: &str, is_hostile: bool) {
        self.line(format_args!("{name} {digest} hostile={is_hostile}"));
        self.things().captures.insert(name.to_owned(), Stored::new(digest, is_hostile));
    }

    /// A file that was added to a capture was acknowledged.
    pub(crate) fn supplement(&self, name: &str, archive: usize) {
        self.line(format_args!("{name} supplement={archive}"));
        if let Some(stored) = self.things().captures.get_mut(name) {
            stored.supplement = Some(archive);
        }
    }

    /// An imported twin was acknowledged.
    pub(crate) fn twin(&self, name: &str, digest: &str, is_hostile: bool) {
        self.line(format_args!("{name} {digest} hostile={is_hostile}"));
        self.things().twins.insert(name.to_owned(), Stored::new(digest, is_hostile));
    }

    /// A fit was acknowledged.
    pub(crate) fn fit(&self, name: &str, work: usize) {
        self.line(format_args!("{name} work={work}"));
        let ordered = Ordered { work, cancelled: false, fate: Fate::Kept };
        self.things().fits.insert(name.to_owned(), ordered);
    }

    /// The cancellation of a fit is about to be asked for.
    pub(crate) fn cancelled(&self, name: &str) {
        self.line(format_args!("{name} cancelled"));
        if let Some(fit) = self.things().fits.get_mut(name) {
            fit.cancelled = true;
        }
    }

    /// Bytes of an upload were acknowledged.
    pub(crate) fn received(&self, path: &str, archive: usize, offset: u64) {
        self.line(format_args!("{path} offset={offset}"));
        self.things().uploads.insert(path.to_owned(), Begun { archive, offset });
    }

    /// An upload has ended.
    pub(crate) fn upload_ended(&self, path: &str) {
        self.line(format_args!("{path} ended"));
        self.things().uploads.remove(path);
    }

    /// The deletion of a capture, a twin or a fit is asked for, refused or acknowledged.
    pub(crate) fn fate(&self, name: &str, fate: Fate) {
        self.line(format_args!("{name} {fate:?}"));
        let mut things = self.things();
        if let Some(stored) = things.captures.get_mut(name) {
            stored.fate = fate;
        }
        if let Some(stored) = things.twins.get_mut(name) {
            stored.fate = fate;
        }
        if let Some(fit) = things.fits.get_mut(name) {
            fit.fate = fate;
        }
    }
}

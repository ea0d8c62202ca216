//! Authorities for tests, each in a folder of its own.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use bendtwin_ca::{Authority, Order, Role};

use crate::PairPaths;

/// The folder of an authority.
pub(crate) struct Folder {
    pub(crate) dir: Arc<tempfile::TempDir>,
    /// Validity of what it issues [days].
    pub(crate) days: i64,
}

impl Folder {
    pub(crate) fn new() -> Self {
        let dir = Arc::new(tempfile::tempdir().unwrap());
        Authority::create(dir.path()).unwrap();
        Self { dir, days: 1 }
    }

    pub(crate) fn path(&self) -> &Path {
        self.dir.path()
    }

    pub(crate) fn ca(&self) -> PathBuf {
        Authority::paths(self.path()).0
    }

    /// A certificate for a name and this machine.
    pub(crate) fn issue(&self, name: &str) -> PairPaths {
        let (name, days) = (name.to_owned(), self.days);
        let order = Order { name, hosts: Vec::new(), role: Role::Server, days, renew: true };
        let written = Authority::open(self.path()).unwrap().issue(&order).unwrap();
        PairPaths { certificate: written.certificate, key: written.key }
    }
}

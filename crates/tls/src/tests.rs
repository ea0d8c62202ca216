//! Authorities for tests, each in a temporary folder.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{
    MutualPaths, PairPaths,
    authority::{Authority, Order, Role},
};

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

    /// The file of revoked certificates.
    pub(crate) fn crl(&self) -> PathBuf {
        Authority::list_path(self.path())
    }

    /// Revokes certificates by their names.
    pub(crate) fn revoke(&self, names: &[&str]) {
        let names: Vec<_> = names.iter().map(|name| (*name).to_owned()).collect();
        Authority::open(self.path()).unwrap().revoke(&names).unwrap();
    }

    /// The files of a peer that reads the list.
    pub(crate) fn peer(&self, name: &str) -> MutualPaths {
        MutualPaths { pair: self.issue(name), ca: self.ca(), crl: Some(self.crl()) }
    }

    /// A certificate for a name and this machine.
    pub(crate) fn issue(&self, name: &str) -> PairPaths {
        let (name, days) = (name.to_owned(), self.days);
        let order = Order { name, hosts: Vec::new(), role: Role::Server, days, renew: true };
        let written = Authority::open(self.path()).unwrap().issue(&order).unwrap();
        PairPaths { certificate: written.certificate, key: written.key }
    }
}

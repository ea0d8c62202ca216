//! Tokens of workers: the shared token, and one for each of the server's own processes, valid as
//! long as the process lives.

use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use blake3::Hash;

/// A worker process that the server started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Child(pub(crate) u64);

/// Holder of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bearer {
    /// A worker started by others, with the shared token.
    External,
    /// A worker started by the server.
    Child(Child),
}

/// The tokens that are valid now. Only hashes are compared: equality of
/// [`Hash`]es takes the same time wherever they differ.
#[derive(Debug, Default)]
pub(crate) struct Tokens {
    shared: Option<Hash>,
    children: Mutex<HashMap<Child, Hash>>,
}

impl Tokens {
    pub(crate) fn new(shared: Option<&str>) -> Self {
        let shared = shared.map(|token| blake3::hash(token.as_bytes()));
        Self { shared, children: Mutex::default() }
    }

    /// A fresh token for a process about to be started.
    pub(crate) fn issue(&self, child: Child) -> String {
        // 244 random bits from the system.
        let token = format!("{}{}", uuid::Uuid::new_v4().simple(), uuid::Uuid::new_v4().simple());
        self.children().insert(child, blake3::hash(token.as_bytes()));
        token
    }

    pub(crate) fn revoke(&self, child: Child) {
        self.children().remove(&child);
    }

    /// The holder of a token, if it is valid.
    pub(crate) fn bearer(&self, token: &str) -> Option<Bearer> {
        let hash = blake3::hash(token.as_bytes());
        if self.shared == Some(hash) {
            return Some(Bearer::External);
        }
        let children = self.children();
        children.iter().find(|(_, h)| **h == hash).map(|(child, _)| Bearer::Child(*child))
    }

    fn children(&self) -> std::sync::MutexGuard<'_, HashMap<Child, Hash>> {
        self.children.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

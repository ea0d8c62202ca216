//! Folders among the files of a capture, each with separate files.

use std::sync::Arc;

use super::{Files, Source};
use crate::limits::Budget;

impl Files<'_> {
    /// The files in a folder of the root, or in the root itself for `.`, with a separate budget.
    pub(crate) fn part(&self, folder: &str) -> Self {
        let (within, name) = match folder {
            "." => (self.prefix.clone(), self.name.as_str()),
            _ => (format!("{}{folder}/", self.prefix), folder),
        };
        let (source, entries) = match &self.source {
            Source::Folder(root) => (Source::Folder(root.join(&within)), self.entries.clone()),
            Source::Zip(_) | Source::Tar(..) => {
                let own = self.entries.iter().filter_map(|(name, index)| {
                    Some((name.strip_prefix(&within)?.to_owned(), *index))
                });
                (self.source.clone(), Arc::new(own.collect()))
            }
        };
        Self {
            name: name.to_owned(),
            limits: self.limits.clone(),
            budget: Budget::new(&self.limits),
            source,
            entries,
            prefix: String::new(),
            origin: format!("{}{within}", self.origin),
            length: self.length,
            read: self.read.clone(),
        }
    }
}

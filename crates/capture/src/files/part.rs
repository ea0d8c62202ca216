//! Folders among the files of a capture, each with files of its own.

use std::{collections::BTreeSet, sync::Arc};

use super::{Files, Source};
use crate::{Error, limits::Budget};

impl<'a> Files<'a> {
    /// Names of the folders in the root, in their order.
    pub(crate) fn folders(&self) -> Result<BTreeSet<String>, Error> {
        match &self.source {
            Source::Folder(root) => {
                let io = |source| Error::Io { at: self.name.clone(), source };
                let mut names = BTreeSet::new();
                let entries = std::fs::read_dir(root.join(&self.prefix)).map_err(io)?;
                for entry in entries.take(self.limits.archive_entries) {
                    let entry = entry.map_err(io)?;
                    if entry.path().is_dir()
                        && let Some(name) = entry.file_name().to_str()
                    {
                        names.insert(name.to_owned());
                    }
                }
                Ok(names)
            }
            Source::Zip(_) => {
                let inside = self.entries.keys().filter_map(|n| n.strip_prefix(&self.prefix));
                Ok(inside.filter_map(|n| n.split_once('/')).map(|(f, _)| f.to_owned()).collect())
            }
        }
    }

    /// The files in a folder of the root, or in the root itself for `.`, with a budget of their own.
    pub(crate) fn part(&self, folder: &str) -> Self {
        let (within, name) = match folder {
            "." => (self.prefix.clone(), self.name.as_str()),
            _ => (format!("{}{folder}/", self.prefix), folder),
        };
        let (source, entries) = match &self.source {
            Source::Folder(root) => (Source::Folder(root.join(&within)), self.entries.clone()),
            Source::Zip(_) => {
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
            length: self.length,
        }
    }
}

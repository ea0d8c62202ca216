//! Names in the folders of a capture: where it lies, and what lies there instead of what was looked
//! for.

use std::{collections::VecDeque, ops::Bound};

use super::{Files, Source};
use crate::Error;

/// Most folders between the root of an archive or folder and a capture.
const MAX_NESTING: usize = 8;

/// Names that a message gives of one folder.
const NAMED: usize = 4;

/// Names in one folder, in the order of their bytes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contents {
    pub(crate) folders: Vec<String>,
    pub(crate) files: Vec<String>,
}

impl Contents {
    pub(crate) fn has(&self, file: &str) -> bool {
        self.files.iter().any(|name| name == file)
    }

    pub(crate) fn has_folder(&self, folder: &str) -> bool {
        self.folders.iter().any(|name| name == folder)
    }

    fn is_empty(&self) -> bool {
        self.folders.is_empty() && self.files.is_empty()
    }

    /// `has 2 folders (a, b) and 3 files (x.png, y.png, z.png)`.
    pub(crate) fn in_words(&self) -> String {
        let part = |names: &[String], one: &str| match names {
            [] => None,
            [name] => Some(format!("one {one} ({name})")),
            names => Some(format!("{} {one}s ({})", names.len(), shortened(names, names.len()))),
        };
        let parts = [part(&self.folders, "folder"), part(&self.files, "file")];
        match parts.into_iter().flatten().collect::<Vec<_>>().join(" and ").as_str() {
            "" => "is empty".to_owned(),
            parts => format!("has {parts}"),
        }
    }
}

impl Files<'_> {
    /// Names in a folder of the capture; `""` is its root. Hidden ones are passed over, and one that
    /// is not there is empty.
    pub(crate) fn list(&self, folder: &str) -> Contents {
        self.list_at(&format!("{}{folder}", self.prefix))
    }

    /// Names in a folder, from the root of all files.
    fn list_at(&self, folder: &str) -> Contents {
        let folder = folder.trim_end_matches('/');
        let mut found = Contents::default();
        match &self.source {
            Source::Folder(root) => {
                let Ok(entries) = std::fs::read_dir(root.join(folder)) else { return found };
                for entry in entries.take(self.limits.archive_entries).flatten() {
                    let Ok(name) = entry.file_name().into_string() else { continue };
                    let kind = entry.file_type().ok();
                    // A link counts as its target.
                    let is_link = kind.is_some_and(|kind| kind.is_symlink());
                    let is_folder = if is_link {
                        entry.path().is_dir()
                    } else {
                        kind.is_some_and(|kind| kind.is_dir())
                    };
                    if is_folder { &mut found.folders } else { &mut found.files }.push(name);
                }
                found.folders.sort_unstable();
                found.files.sort_unstable();
            }
            Source::Zip(_) | Source::Tar(..) => {
                let start = if folder.is_empty() { String::new() } else { format!("{folder}/") };
                let mut from = Bound::Included(start.clone());
                while let Some((name, _)) = self.entries.range((from, Bound::Unbounded)).next() {
                    let Some(rest) = name.strip_prefix(&start) else { break };
                    match rest.split_once('/') {
                        Some((inner, _)) => {
                            // All further names in it, since `0` follows `/`.
                            from = Bound::Included(format!("{start}{inner}0"));
                            found.folders.push(inner.to_owned());
                        }
                        None => {
                            from = Bound::Excluded(name.clone());
                            found.files.push(rest.to_owned());
                        }
                    }
                }
            }
        }
        let is_shown = |name: &String| !name.starts_with('.') && name != "__MACOSX";
        found.folders.retain(is_shown);
        found.files.retain(is_shown);
        found
    }

    /// Moves the root to the one folder that holds a capture.
    ///
    /// # Errors
    /// If several folders hold captures and no folder contains the others.
    pub(crate) fn settle(&mut self, is_capture: fn(&Contents) -> bool) -> Result<bool, Error> {
        let mut found = Vec::new();
        let mut queue = VecDeque::from([(0, String::new())]);
        let mut left = self.limits.archive_entries;
        while let Some((depth, folder)) = queue.pop_front() {
            let contents = self.list_at(&folder);
            left = left.saturating_sub(1 + contents.files.len() + contents.folders.len());
            if is_capture(&contents) {
                found.push(folder);
                continue;
            }
            // A home directory is no recording, and is not searched to its end.
            if depth >= MAX_NESTING || left == 0 {
                continue;
            }
            for inner in contents.folders {
                let path = if folder.is_empty() { inner } else { format!("{folder}/{inner}") };
                // A link may lead anywhere, also back.
                let is_link = match &self.source {
                    Source::Folder(root) => root.join(&path).is_symlink(),
                    _ => false,
                };
                if !is_link {
                    queue.push_back((depth + 1, path));
                }
            }
        }
        match found.as_slice() {
            [] => Ok(false),
            [one] => {
                if !one.is_empty() {
                    self.prefix = format!("{one}/");
                    one.rsplit('/').next().unwrap_or_default().clone_into(&mut self.name);
                }
                Ok(true)
            }
            several => Err(Error::Several(shortened(several, several.len()))),
        }
    }

    /// Content of a folder in words; of one that is not there, that of the nearest above.
    pub(crate) fn describe(&self, folder: &str) -> String {
        let folder = folder.trim_end_matches('/');
        let mut nearest = folder;
        let mut contents = self.list(nearest);
        while contents.is_empty() && !nearest.is_empty() {
            nearest = nearest.rsplit_once('/').map_or("", |(above, _)| above);
            contents = self.list(nearest);
        }
        let place = match nearest {
            "" => "the recording".to_owned(),
            _ => format!("`{nearest}`"),
        };
        let found = format!("{place} {}", contents.in_words());
        if nearest == folder { found } else { format!("there is no `{folder}`, and {found}") }
    }
}

/// The first few names of `count`.
pub(crate) fn shortened(names: &[String], count: usize) -> String {
    let mut named: Vec<&str> = names.iter().take(NAMED).map(String::as_str).collect();
    if count > named.len() {
        named.push("...");
    }
    named.join(", ")
}

//! Confinement of the process that reads a stranger's file: a defect in a reader must not reach
//! the network, other files, other processes or the worker's token.
//!
//! ```text
//!   environment     what the parent passes, which is almost nothing
//!   descriptors     standard input, output and error
//!   resources       memory, processor time, file sizes, open files, no core dumps  (rlimit)
//!   files           its own folder                                                 (Landlock)
//!   system calls    none of the network, other programs, other processes, mounts   (seccomp)
//! ```
//!
//! The process confines itself before it has read a byte of the file and before it has a second
//! thread. The confinement cannot be undone, and needs no privileges. Landlock and seccomp are
//! Linux's; [`Enforced`] says what the system supports.

#[cfg(target_os = "linux")]
mod calls;
mod descriptors;
#[cfg(target_os = "linux")]
mod files;
mod resources;

use std::{io, path::Path};

use serde::{Deserialize, Serialize};

/// Demand on the confinement of the process that reads captures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sandbox {
    /// All of it, or nothing is read.
    Required,
    /// All layers that the system supports; missing ones are logged.
    #[default]
    BestEffort,
}

/// Resources that the process may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resources {
    /// Memory [bytes].
    pub memory_bytes: u64,
    /// Processor time of all threads together [s].
    pub processor_s: u64,
    /// Size of one file that it writes [bytes].
    pub file_bytes: u64,
}

/// Completeness of one layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// All of it.
    Full,
    /// In part: the kernel is older than the requested features.
    Partial,
    /// The system lacks it.
    Missing,
}

/// Layers in force, beside the resources and descriptors that every system limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Enforced {
    /// Landlock: no files but those of its folder.
    pub files: Layer,
    /// seccomp: no network, programs, other processes and mounts.
    pub calls: Layer,
}

impl Enforced {
    /// Words for what lacks, if anything does.
    pub fn lacking(&self) -> Option<String> {
        let words = |layer, what: &str| match layer {
            Layer::Full => None,
            Layer::Partial => Some(format!("{what} only in part")),
            Layer::Missing => Some(format!("{what} not at all")),
        };
        let files = words(self.files, "files (Landlock)");
        let calls = words(self.calls, "system calls (seccomp)");
        let lacking: Vec<String> = files.into_iter().chain(calls).collect();
        (!lacking.is_empty()).then(|| lacking.join(", "))
    }

    /// True if both layers are in force, if only in the form of an older kernel.
    pub fn suffices(&self) -> bool {
        self.files != Layer::Missing && self.calls != Layer::Missing
    }
}

/// Confines this process irrevocably: from here on it can read and write files below `folder`, and
/// standard input, output and error.
///
/// # Errors
/// If a limit cannot be set, or this process already has other threads.
pub fn confine(folder: &Path, resources: &Resources) -> io::Result<Enforced> {
    descriptors::close_inherited();
    resources::limit(resources)?;
    confine_on_system(folder)
}

#[cfg(target_os = "linux")]
fn confine_on_system(folder: &Path) -> io::Result<Enforced> {
    // Other threads would keep their rights.
    if std::fs::read_dir("/proc/self/task").is_ok_and(|tasks| tasks.count() > 1) {
        return Err(io::Error::other("the process has other threads already"));
    }
    // Files last: before that the kernel can be asked for its features.
    let calls = calls::deny()?;
    Ok(Enforced { files: files::restrict_to(folder)?, calls })
}

#[cfg(not(target_os = "linux"))]
fn confine_on_system(_: &Path) -> io::Result<Enforced> {
    Ok(Enforced { files: Layer::Missing, calls: Layer::Missing })
}

/// Layers of this system, as far as they can be detected without confining anything.
pub fn available() -> Enforced {
    #[cfg(target_os = "linux")]
    return Enforced { files: files::available(), calls: calls::available() };
    #[cfg(not(target_os = "linux"))]
    Enforced { files: Layer::Missing, calls: Layer::Missing }
}

//! Errors of running a suite. A run that fails is no error of its suite: its record has the reason.

use std::path::{Path, PathBuf};

use bendtwin_core::{Category, Problem};

/// An error that prevents or ends the execution of a suite.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The suite is contradictory, or refers to names that do not exist.
    #[error("{}: {}", file.display(), faults.join("; "))]
    Suite {
        /// The suite's file.
        file: PathBuf,
        /// All faults, one sentence each.
        faults: Vec<String>,
    },
    /// `--only` matches no run.
    #[error("{0}")]
    Selection(String),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The plan was cancelled while captures were read.
    #[error("stopped while captures were read: the same command begins anew")]
    Cancelled,
    /// Another process uses the folder.
    #[error(
        "{}: another process works in this folder: wait for it, or choose another one", .0.display()
    )]
    Busy(PathBuf),
    /// A result could not be written as JSON, or a picture as PNG.
    #[error("{0}")]
    Writing(String),
}

impl Error {
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}

impl Problem for Error {
    fn category(&self) -> Category {
        match self {
            Self::Suite { .. } | Self::Selection(_) => Category::InvalidArgument,
            Self::File { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                Category::NotFound
            }
            Self::Cancelled => Category::Cancelled,
            Self::Busy(_) => Category::FailedPrecondition,
            Self::File { .. } | Self::Writing(_) => Category::Internal,
        }
    }

    fn reason(&self) -> &'static str {
        match self {
            Self::Suite { .. } => "INVALID_SUITE",
            Self::Selection(_) => "NO_SUCH_RUN",
            Self::File { .. } => "STUDY_FILE",
            Self::Cancelled => "CANCELLED",
            Self::Busy(_) => "STUDY_FOLDER_BUSY",
            Self::Writing(_) => "STUDY_NOT_WRITTEN",
        }
    }
}

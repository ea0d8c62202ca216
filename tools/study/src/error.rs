//! Errors of running a suite. A run that fails is no error of its suite: its record has the reason.

use std::path::{Path, PathBuf};

use bendtwin_core::Problem;

/// An error that prevents or ends the execution of a suite.
#[derive(Debug, thiserror::Error, Problem)]
pub enum Error {
    /// The suite is contradictory, or refers to names that do not exist.
    #[error("{}: {}", file.display(), faults.join("; "))]
    #[problem(InvalidArgument, "INVALID_SUITE")]
    Suite {
        /// The suite's file.
        file: PathBuf,
        /// All faults, one sentence each.
        faults: Vec<String>,
    },
    /// `--only` matches no run.
    #[error("{0}")]
    #[problem(InvalidArgument, "NO_SUCH_RUN")]
    Selection(String),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    #[problem(NotFound, "STUDY_FILE", if source.kind() == std::io::ErrorKind::NotFound)]
    #[problem(Internal, "STUDY_FILE")]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The plan was cancelled while captures were read.
    #[error("stopped while captures were read: the same command begins anew")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
    /// Another process uses the folder.
    #[error(
        "{}: another process works in this folder: wait for it, or choose another one", .0.display()
    )]
    #[problem(FailedPrecondition, "STUDY_FOLDER_BUSY")]
    Busy(PathBuf),
    /// A result could not be written as JSON, or a picture as PNG.
    #[error("{0}")]
    #[problem(Internal, "STUDY_NOT_WRITTEN")]
    Writing(String),
}

impl Error {
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}

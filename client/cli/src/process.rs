//! Settings of the process itself.

/// Files and folders that this process makes from now on are for its user alone: captures, twins,
/// and what a worker makes of them.
pub(crate) fn keep_files_private() {
    #[cfg(unix)]
    rustix::process::umask(rustix::fs::Mode::from_raw_mode(0o077));
}

/// Lets the process, and the workers that it starts, open as many files as the system allows: every connection is
/// one.
pub(crate) fn raise_descriptor_limit() {
    match rlimit::increase_nofile_limit(rlimit::INFINITY) {
        Ok(limit) => tracing::debug!(limit, "limit of open files"),
        Err(error) => tracing::warn!(%error, "cannot raise the limit of open files"),
    }
}

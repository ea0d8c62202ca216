//! The program of the workers, searched before anything else: a server that can never start one
//! would accept work that is never done.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
};

use crate::{options::WorkerPolicy, service::StartError};

/// The program to start workers with; none if others start them.
///
/// # Errors
/// [`StartError::Program`] if it is not there, or not a program.
pub(crate) fn program(policy: &WorkerPolicy) -> Result<Option<PathBuf>, StartError> {
    if policy.count == 0 {
        return Ok(None);
    }
    let Some(named) = &policy.program else {
        let this = env::current_exe();
        return this.map(Some).map_err(|e| refused(Path::new("this very program"), &e));
    };
    let found = find(named).map_err(|e| refused(named, &e))?;
    Ok(Some(found))
}

/// A name without a folder is looked for in the folders of `PATH`, as a shell does.
fn find(named: &Path) -> io::Result<PathBuf> {
    if named.components().count() > 1 || named.is_absolute() {
        return can_start(named).map(|()| named.to_owned());
    }
    let folders = env::var_os("PATH").unwrap_or_default();
    let mut fault = io::Error::new(io::ErrorKind::NotFound, "it is in no folder of PATH");
    for folder in env::split_paths(&folders) {
        let path = folder.join(named);
        match can_start(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => fault = error,
        }
    }
    Err(fault)
}

fn can_start(path: &Path) -> io::Result<()> {
    let denied = |why: &str| io::Error::new(io::ErrorKind::PermissionDenied, why.to_owned());
    let found = fs::metadata(path)?;
    if !found.is_file() {
        return Err(denied("it is no file"));
    }
    #[cfg(unix)]
    if std::os::unix::fs::PermissionsExt::mode(&found.permissions()) & 0o111 == 0 {
        return Err(denied("it may not be executed"));
    }
    Ok(())
}

fn refused(program: &Path, fault: &io::Error) -> StartError {
    StartError::Program { program: program.display().to_string(), fault: fault.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn policy(program: impl Into<PathBuf>) -> WorkerPolicy {
        WorkerPolicy { program: Some(program.into()), ..WorkerPolicy::default() }
    }

    #[test]
    fn programs_are_found_before_they_are_needed() {
        let dir = tempfile::tempdir().unwrap();
        let plain = dir.path().join("plain");
        fs::write(&plain, "no program").unwrap();
        for refused in [dir.path().join("missing"), plain, dir.path().into(), "no-such-name".into()]
        {
            let result = program(&policy(&refused));
            assert!(matches!(result, Err(StartError::Program { .. })), "{refused:?}");
        }
        assert_eq!(program(&policy("/bin/sh")).unwrap(), Some("/bin/sh".into()));
        assert!(program(&policy("sh")).unwrap().is_some_and(|p| p.is_absolute()));
        assert!(program(&WorkerPolicy::default()).unwrap().is_some());
        assert_eq!(program(&WorkerPolicy { count: 0, ..policy("missing") }).unwrap(), None);
    }
}

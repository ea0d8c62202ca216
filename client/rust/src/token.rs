//! The token or key that is shown to a server: in the environment, in a file that is named there, in
//! the file of a sign-in (`bendtwin login`), or, for servers of this user on this machine, in a file
//! that the server leaves by its port, which needs no configuration.

mod sign_in;

use std::{
    io::{self, Write as _},
    net::IpAddr,
    path::{Path, PathBuf},
};

use bendtwin_core::Category;
use url::Url;

use crate::Error;

pub use sign_in::{forget_sign_in, keep_sign_in, sign_in_of};

/// The environment variable with a token or a key.
pub const TOKEN_VARIABLE: &str = "BENDTWIN_TOKEN";
/// The environment variable with the path of a file that has one.
pub const FILE_VARIABLE: &str = "BENDTWIN_TOKEN_FILE";

/// Token or key to be shown to a server: that of `BENDTWIN_TOKEN`; else that in the file that
/// `BENDTWIN_TOKEN_FILE` names; else the key with which this user signed in at that server; else, if
/// the URL names this machine, the token that a server of this user left for its port.
///
/// # Errors
/// If the file cannot be used ([`read`]).
pub fn find(url: &str) -> Result<Option<String>, Error> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    if let Some(given) = set(TOKEN_VARIABLE).and_then(|token| token.into_string().ok()) {
        return Ok(Some(given));
    }
    if let Some(file) = set(FILE_VARIABLE) {
        return read(Path::new(&file)).map(Some);
    }
    match sign_in_of(url)? {
        Some(key) => Ok(Some(key)),
        None => Ok(Url::parse(url).ok().and_then(|url| left(&url))),
    }
}

/// The token or key in a file.
///
/// # Errors
/// If it cannot be read, is empty, or other users of the machine can read it.
pub fn read(path: &Path) -> Result<String, Error> {
    let unusable = |error| Error::file(path, &error);
    let file = std::fs::File::open(path).map_err(unusable)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = file.metadata().map_err(unusable)?.permissions().mode();
        if mode & 0o077 != 0 {
            let path = path.display();
            let message = format!(
                "other users can use {path}, which has a token or key (mode {:03o}): \
                 `chmod 600 {path}`, and have another key made if they may have read this one",
                mode & 0o777
            );
            return Err(Error::new(Category::FailedPrecondition, "KEY_FILE_OPEN", message));
        }
    }
    let text = io::read_to_string(file).map_err(unusable)?;
    match text.trim() {
        "" => Err(Error::invalid(format!("{}: there is no token or key in it", path.display()))),
        token => Ok(token.to_owned()),
    }
}

/// A new file for a key, which only this user can read.
///
/// # Errors
/// If it exists already, or cannot be made.
pub fn create_private(path: &Path) -> io::Result<std::fs::File> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// The port of a server on this machine; `None` for the address of any other, which may not get the token of one here.
pub fn local_port(url: &str) -> Option<u16> {
    let url = Url::parse(url).ok()?;
    let host = url.host_str()?;
    let address = host.trim_matches(['[', ']']).parse::<IpAddr>();
    if !host.eq_ignore_ascii_case("localhost") && !address.is_ok_and(|ip| ip.is_loopback()) {
        return None;
    }
    url.port_or_known_default()
}

/// The token that a server on this machine left.
fn left(url: &Url) -> Option<String> {
    let text = std::fs::read_to_string(path(local_port(url.as_str())?)?).ok()?;
    Some(text.trim().to_owned()).filter(|token| !token.is_empty())
}

/// Leaves the token of a server for clients of this user. Only the user can read it.
///
/// # Errors
/// If there is no folder for it, or it cannot be written.
pub fn publish(port: u16, token: &str) -> io::Result<()> {
    let no_home = || io::Error::new(io::ErrorKind::NotFound, "neither HOME nor XDG_STATE_HOME");
    write(&path(port).ok_or_else(no_home)?, token)
}

/// Writes a token to a file of this user, in a folder that is made if missing.
fn write(path: &Path, token: &str) -> io::Result<()> {
    let folder = path.parent().ok_or(io::ErrorKind::NotFound)?;
    let mut folders = std::fs::DirBuilder::new();
    folders.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut folders, 0o700);
    folders.create(folder)?;
    // As a new file, so that it has these permissions in any case, and is written whole or not at
    // all.
    let partial = path.with_extension(format!("{}.partial", std::process::id()));
    match std::fs::remove_file(&partial) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    writeln!(create_private(&partial)?, "{token}")?;
    std::fs::rename(&partial, path)
}

/// Removes the token of a server that ends.
pub fn withdraw(port: u16, token: &str) {
    let Some(path) = path(port) else { return };
    // Another server may have taken the port.
    if std::fs::read_to_string(&path).is_ok_and(|text| text.trim() == token) {
        let _ = std::fs::remove_file(path);
    }
}

/// Removes the token that a former server at a port left: the one of now has none.
pub fn withdraw_any(port: u16) {
    if let Some(path) = path(port) {
        let _ = std::fs::remove_file(path);
    }
}

/// The file for the server at a port: `$XDG_STATE_HOME/bendtwin/tokens/{port}`, or below
/// `~/.local/state`.
fn path(port: u16) -> Option<PathBuf> {
    Some(state()?.join("tokens").join(port.to_string()))
}

/// The folder of what this user's commands keep.
fn state() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).filter(|p| p.is_absolute());
    let home = || std::env::home_dir().map(|home| home.join(".local/state"));
    Some(state.or_else(home)?.join("bendtwin"))
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn a_file_that_others_can_read_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        writeln!(create_private(&path).unwrap(), "bt_1_2").unwrap();
        assert_eq!(read(&path).unwrap(), "bt_1_2");
        for mode in [0o644, 0o640, 0o604, 0o620] {
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
            let error = read(&path).unwrap_err();
            assert_eq!(error.reason(), "KEY_FILE_OPEN");
            assert!(error.message().contains("chmod 600"), "{error}");
            assert!(!error.message().contains("bt_1_2"), "{error}");
        }
        assert!(create_private(&path).is_err());
        std::fs::write(folder.path().join("empty"), "\n").unwrap();
        let empty = folder.path().join("empty");
        std::fs::set_permissions(&empty, std::fs::Permissions::from_mode(0o600)).unwrap();
        assert!(read(&empty).unwrap_err().message().contains("no token"));
        assert_eq!(read(&folder.path().join("none")).unwrap_err().reason(), "FILE_UNUSABLE");
    }
}

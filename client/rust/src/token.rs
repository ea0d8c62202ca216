//! The token of a server: in the environment, or, for servers of this user on this machine, in a
//! file that the server leaves by its port. Nobody has to know of it then.

use std::{
    io::{self, Write as _},
    net::IpAddr,
    path::PathBuf,
};

/// The environment variable with the token of a server.
pub const TOKEN_VARIABLE: &str = "BENDTWIN_TOKEN";

/// The token for a server: that of `BENDTWIN_TOKEN`; else, if the URL names this machine, the one
/// that a server of this user left for its port.
pub fn find(url: &str) -> Option<String> {
    let given = std::env::var(TOKEN_VARIABLE).ok().filter(|token| !token.is_empty());
    given.or_else(|| left(&reqwest::Url::parse(url).ok()?))
}

/// The token that a server on this machine left.
fn left(url: &reqwest::Url) -> Option<String> {
    let host = url.host_str()?;
    let address = host.trim_matches(['[', ']']).parse::<IpAddr>();
    if !host.eq_ignore_ascii_case("localhost") && !address.is_ok_and(|ip| ip.is_loopback()) {
        return None;
    }
    let text = std::fs::read_to_string(path(url.port_or_known_default()?)?).ok()?;
    Some(text.trim().to_owned()).filter(|token| !token.is_empty())
}

/// Leaves the token of a server for clients of this user. Only the user can read it.
///
/// # Errors
/// If there is no folder for it, or it cannot be written.
pub fn publish(port: u16, token: &str) -> io::Result<()> {
    let no_home = || io::Error::new(io::ErrorKind::NotFound, "neither HOME nor XDG_STATE_HOME");
    let path = path(port).ok_or_else(no_home)?;
    let folder = path.parent().ok_or_else(no_home)?;
    let (mut folders, mut options) = (std::fs::DirBuilder::new(), std::fs::OpenOptions::new());
    folders.recursive(true);
    options.write(true).create_new(true);
    #[cfg(unix)]
    {
        std::os::unix::fs::DirBuilderExt::mode(&mut folders, 0o700);
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    folders.create(folder)?;
    // Anew, so that the file has these permissions whatever was there, and whole or not at all.
    let partial = path.with_extension(format!("{}.partial", std::process::id()));
    match std::fs::remove_file(&partial) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    writeln!(options.open(&partial)?, "{token}")?;
    std::fs::rename(&partial, &path)
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
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).filter(|p| p.is_absolute());
    let home = || std::env::home_dir().map(|home| home.join(".local/state"));
    Some(state.or_else(home)?.join("bendtwin/tokens").join(port.to_string()))
}

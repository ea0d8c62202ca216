//! The keys with which this user has signed in: one file for each server, in
//! `$XDG_STATE_HOME/bendtwin/sign-ins/`, or below `~/.local/state`.

use std::{io, path::PathBuf};

use url::Url;

use super::{read, state, write};
use crate::{Error, client::complete};

/// The key with which this user signed in at a server, if they did.
///
/// # Errors
/// If its file cannot be used ([`read`]).
pub fn sign_in_of(url: &str) -> Result<Option<String>, Error> {
    match path(url).filter(|path| path.exists()) {
        Some(path) => read(&path).map(Some),
        None => Ok(None),
    }
}

/// Keeps the key of a sign-in, which only this user can read, in the place of an earlier one. Returns
/// the file.
///
/// # Errors
/// If there is no folder for it, or it cannot be written.
pub fn keep_sign_in(url: &str, key: &str) -> io::Result<PathBuf> {
    let no_place = || io::Error::new(io::ErrorKind::NotFound, "neither HOME nor XDG_STATE_HOME");
    let path = path(url).ok_or_else(no_place)?;
    write(&path, key)?;
    Ok(path)
}

/// Removes the key of a sign-in.
///
/// # Errors
/// If it is there and cannot be removed.
pub fn forget_sign_in(url: &str) -> io::Result<()> {
    let Some(path) = path(url) else { return Ok(()) };
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn path(url: &str) -> Option<PathBuf> {
    Some(state()?.join("sign-ins").join(name(url)?))
}

/// `{scheme}_{host}_{port}`: a key is not shown over another transport, or at another port.
fn name(url: &str) -> Option<String> {
    let url = Url::parse(&complete(url)).ok()?;
    let host = url.host_str()?.trim_matches(['[', ']']).to_ascii_lowercase();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || ".-".contains(letter);
    let host: String = host.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
    Some(format!("{}_{host}_{}", url.scheme(), url.port_or_known_default()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_server_has_one_file() {
        let name = |url| name(url).unwrap();
        assert_eq!(name("https://Twin.Example"), "https_twin.example_443");
        assert_eq!(name("https://twin.example:443/"), "https_twin.example_443");
        assert_eq!(name("twin.example:7070"), "http_twin.example_7070");
        assert_eq!(name("http://[::1]:7070"), "http___1_7070");
        assert!(super::name("https://a b").is_none());
    }
}

//! Names of certificates and hosts.

use super::Error;

/// Longest label of a host name, which a name here is as a whole.
const LONGEST: usize = 63;

/// Names of the authority's own files.
const TAKEN: [&str; 2] = ["ca", "crl"];

/// Checks a name, which becomes that of a file and a host.
pub(crate) fn check(name: &str) -> Result<(), Error> {
    let is_short = name.len() <= LONGEST && !TAKEN.contains(&name);
    if is_short && is_host(name) { Ok(()) } else { Err(Error::Name(name.to_owned())) }
}

/// Checks a host name, which may stand for all names of one domain: `*.example.org`.
pub(crate) fn check_host(host: &str) -> Result<(), Error> {
    let name = host.strip_prefix("*.").unwrap_or(host);
    if name.len() <= 253 && is_host(name) { Ok(()) } else { Err(Error::Host(host.to_owned())) }
}

fn is_host(name: &str) -> bool {
    name.split('.').all(|label| {
        let allowed = |b: u8| b.is_ascii_alphanumeric() || b == b'-' || b == b'_';
        let edge = |b: Option<&u8>| b.is_some_and(u8::is_ascii_alphanumeric);
        let bytes = label.as_bytes();
        bytes.len() <= LONGEST
            && edge(bytes.first())
            && edge(bytes.last())
            && bytes.iter().all(|b| allowed(*b))
    })
}

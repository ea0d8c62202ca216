//! The token that clients show. It keeps other users of the machine, and everyone else who reaches
//! the port, away from the API. It is a file in the data folder, and the same after a restart.

use std::{
    fs::{File, OpenOptions},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

use axum::http::{HeaderMap, HeaderValue, header};
use base64::{Engine as _, prelude::BASE64_STANDARD};
use bendtwin_core::{Category, Fault};
use bendtwin_store::CLIENT_TOKEN as FILE;
use blake3::Hash;

use crate::refusal::Refusal;

/// Fewest characters that count as a token.
const SHORTEST: usize = 32;
/// The protocol of a WebSocket that is followed by the token.
pub(crate) const TOKEN_PROTOCOL: &str = "bendtwin.token";
const BEARER: HeaderValue = HeaderValue::from_static("Bearer realm=\"BendTwin\"");
const BASIC: HeaderValue = HeaderValue::from_static("Basic realm=\"BendTwin\", charset=\"UTF-8\"");

/// Challenges of a refusal. That of `Basic` makes a browser ask for a password, which is the token;
/// a script that sent a token asks its user itself.
pub(crate) fn challenges(request: &HeaderMap) -> impl Iterator<Item = HeaderValue> {
    let shown = request.get(header::AUTHORIZATION).map(HeaderValue::as_bytes).unwrap_or_default();
    let is_bearer = shown.len() >= 6 && shown[..6].eq_ignore_ascii_case(b"bearer");
    [Some(BEARER), (!is_bearer).then_some(BASIC)].into_iter().flatten()
}

/// The file of the token.
pub(crate) fn path(data_dir: &Path) -> PathBuf {
    data_dir.join(FILE)
}

/// Reads the token of a file that others keep.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    match text.trim() {
        token if is_token(token) => Ok(token.to_owned()),
        _ => Err("its content is no token".to_owned()),
    }
}

/// Reads the token, or makes one.
pub(crate) fn load(data_dir: &Path) -> io::Result<String> {
    let path = path(data_dir);
    let is_missing = !path.try_exists()?;
    match std::fs::read_to_string(&path) {
        Ok(text) if is_token(text.trim()) => {
            restrict(&File::open(&path)?)?;
            return Ok(text.trim().to_owned());
        }
        Ok(_) => tracing::warn!(path = %path.display(), "no token in it: writing a new one"),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    // 244 random bits from the system.
    let token = format!("{}{}", uuid::Uuid::new_v4().simple(), uuid::Uuid::new_v4().simple());
    let partial = path.with_extension(uuid::Uuid::new_v4().simple().to_string());
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut file = options.open(&partial)?;
    restrict(&file)?;
    writeln!(file, "{token}")?;
    file.sync_all()?;
    // Of two servers that begin in one folder, the second takes the token of the first.
    if is_missing {
        let placed = std::fs::hard_link(&partial, &path);
        std::fs::remove_file(&partial)?;
        return match placed {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                Ok(std::fs::read_to_string(&path)?.trim().to_owned())
            }
            placed => placed.map(|()| token),
        };
    }
    std::fs::rename(&partial, &path)?;
    Ok(token)
}

fn is_token(text: &str) -> bool {
    text.len() >= SHORTEST && text.bytes().all(|b| b.is_ascii_graphic())
}

/// Leaves the file to its owner.
fn restrict(file: &File) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.set_permissions(std::fs::Permissions::from_mode(0o600))?;
    }
    let _ = file;
    Ok(())
}

/// The token that requests are compared with. Only hashes are compared: equality of [`Hash`]es
/// takes the same time wherever they differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClientToken(Hash);

impl ClientToken {
    pub(crate) fn new(token: &str) -> Self {
        Self(blake3::hash(token.as_bytes()))
    }

    pub(crate) fn matches(&self, shown: &str) -> bool {
        blake3::hash(shown.as_bytes()) == self.0
    }
}

/// The token or key that a request shows, as `Bearer`, as the password of `Basic` with any name, or,
/// as a page cannot set headers of a WebSocket, among its protocols.
pub(crate) fn shown(headers: &HeaderMap) -> Option<String> {
    let given = headers.get(header::AUTHORIZATION).and_then(|v| v.to_str().ok());
    let token = given.and_then(|v| v.split_once(' ')).and_then(|(scheme, value)| {
        match scheme.to_ascii_lowercase().as_str() {
            "bearer" => Some(value.trim().to_owned()),
            "basic" => password(value.trim()),
            _ => None,
        }
    });
    token.or_else(|| of_protocols(headers))
}

/// The token after [`TOKEN_PROTOCOL`] in the list of a WebSocket's protocols.
fn of_protocols(headers: &HeaderMap) -> Option<String> {
    let list = headers.get(header::SEC_WEBSOCKET_PROTOCOL)?.to_str().ok()?;
    let mut protocols = list.split(',').map(str::trim);
    protocols.find(|protocol| *protocol == TOKEN_PROTOCOL)?;
    protocols.next().map(str::to_owned)
}

fn password(credentials: &str) -> Option<String> {
    let text = String::from_utf8(BASE64_STANDARD.decode(credentials).ok()?).ok()?;
    text.split_once(':').map(|(_, password)| password.to_owned())
}

/// A refusal that says what is wrong with what a request shows.
pub(crate) fn refusal(fault: &str) -> Refusal {
    Refusal::new(Fault {
        category: Category::Unauthenticated,
        reason: "BAD_CLIENT_TOKEN".to_owned(),
        message: format!(
            "{fault}: send `Authorization: Bearer` with a key, or with the content of `{FILE}` in \
             the server's data folder; clients of BendTwin take either from BENDTWIN_TOKEN or \
             --token-file"
        ),
    })
}

#[cfg(test)]
mod tests;

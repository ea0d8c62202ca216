//! The metadata of an upload: comma-separated `key base64` pairs. The keys below have a meaning
//! here; the others are kept for the client.

use base64::{Engine as _, prelude::BASE64_STANDARD};

use bendtwin_proto::{
    json::{Fields as _, from_pairs},
    v1::CaptureMetadata,
};

use super::super::{Error, Result};

/// Longest metadata that is kept [bytes].
const MAX_LENGTH: usize = 4096;

/// The pairs with a meaning here; empty if not given.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Metadata {
    pub(super) request_id: String,
    /// The facts of the capture that the upload becomes. Without a display name it is called like
    /// the file, without its extension.
    pub(super) capture: CaptureMetadata,
}

impl Metadata {
    pub(super) fn parse(text: &str) -> Result<Self> {
        let invalid = |fault: &str| Error::invalid("upload-metadata", fault);
        if text.len() > MAX_LENGTH {
            return Err(invalid(&format!("is longer than {MAX_LENGTH} bytes")));
        }
        let (mut metadata, mut seen) = (Self::default(), Vec::new());
        let (mut filename, mut facts) = (String::new(), Vec::new());
        for pair in text.split(',').map(str::trim).filter(|_| !text.trim().is_empty()) {
            let (key, value) = pair.split_once(' ').unwrap_or((pair, ""));
            if key.is_empty() {
                return Err(invalid("has an empty key"));
            }
            if seen.contains(&key) {
                return Err(invalid(&format!("has the key `{key}` twice")));
            }
            seen.push(key);
            let value = BASE64_STANDARD
                .decode(value.trim())
                .map_err(|_| invalid(&format!("has a value of `{key}` that is not Base64")))?;
            let is_fact = CaptureMetadata::FIELDS.contains(&key);
            if !is_fact && !["filename", "request_id"].contains(&key) {
                continue;
            }
            let value = String::from_utf8(value)
                .map_err(|_| invalid(&format!("has a value of `{key}` that is not UTF-8")))?;
            match key {
                "filename" => filename = value,
                "request_id" => metadata.request_id = value,
                _ => facts.push((key.to_owned(), value)),
            }
        }
        metadata.capture = from_pairs(facts).map_err(|e| invalid(&e.to_string()))?;
        if metadata.capture.display_name.is_empty() {
            metadata.capture.display_name = stem(&filename).to_owned();
        }
        Ok(metadata)
    }

    /// The request id, given here or as a header; if both, the same.
    pub(super) fn one_request_id(&self, header: String) -> Result<String> {
        match (header.is_empty(), self.request_id.is_empty()) {
            (true, _) => Ok(self.request_id.clone()),
            (false, true) => Ok(header),
            (false, false) if header == self.request_id => Ok(header),
            _ => Err(Error::invalid("request_id", "differs from the idempotency key")),
        }
    }
}

/// The name of a file without folders and extension.
fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or_default();
    let endings = [".zip", ".tar.gz", ".tgz", ".tar", ".mcap"];
    endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_read_and_others_are_left_alone() {
        let text = "filename cm9wZS56aXA=,is_confidential,display_name w4Q=, other AAEC";
        assert_eq!(Metadata::parse(text).unwrap().capture.display_name, "Ä");
        assert_eq!(Metadata::parse("").unwrap(), Metadata::default());
        let named = Metadata::parse("filename Yy9yb3BlLnppcA==").unwrap();
        assert_eq!(named.capture.display_name, "rope");
        assert_eq!(stem("toy.v2.tar.gz"), "toy.v2");
    }

    #[test]
    fn what_the_protocol_forbids_is_refused() {
        for text in ["a YQ==,a YQ==", "a YQ==,", "a ?", "digest //79", " , ", &"x".repeat(5000)] {
            assert!(Metadata::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn there_is_one_request_id() {
        let metadata = Metadata { request_id: "a".into(), ..Metadata::default() };
        assert_eq!(metadata.one_request_id(String::new()).unwrap(), "a");
        assert_eq!(metadata.one_request_id("a".into()).unwrap(), "a");
        assert!(metadata.one_request_id("b".into()).is_err());
        assert_eq!(Metadata::default().one_request_id("b".into()).unwrap(), "b");
    }
}

//! The URL of the content's place: a bucket of S3, or a folder.

use std::{fmt, path::PathBuf};

use object_store::path::Path;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// URL of the place of content, `s3://bucket/prefix` or `file:///folder`. It has no secrets: those of
/// a bucket are in the environment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ObjectsUrl(String);

/// The place that a URL names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Location {
    Folder(PathBuf),
    /// Name of the bucket, and the path below which its objects are.
    Bucket(String, Path),
}

impl ObjectsUrl {
    /// Reads a URL.
    ///
    /// # Errors
    /// [`Error::InvalidObjectsUrl`], which does not repeat it: it may have what should not be in it.
    pub fn parse(url: &str) -> Result<Self> {
        let url = Self(url.trim_end_matches('/').to_owned());
        url.location().map(|_| url)
    }

    /// The place that it names.
    ///
    /// # Errors
    /// [`Error::InvalidObjectsUrl`]: it was not read by [`ObjectsUrl::parse`].
    pub(crate) fn location(&self) -> Result<Location> {
        if let Some(folder) = self.0.strip_prefix("file://") {
            let folder = PathBuf::from(folder);
            let whole = folder.is_absolute() && folder.parent().is_some();
            return whole.then_some(Location::Folder(folder)).ok_or(Error::InvalidObjectsUrl);
        }
        let rest = self.0.strip_prefix("s3://").ok_or(Error::InvalidObjectsUrl)?;
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        let plain = |text: &str, others: &str| {
            text.bytes().all(|b| b.is_ascii_alphanumeric() || others.as_bytes().contains(&b))
        };
        let named = (3..=63).contains(&bucket.len()) && plain(bucket, "-.");
        if !named || !plain(prefix, "-._/") {
            return Err(Error::InvalidObjectsUrl);
        }
        let prefix = Path::parse(prefix).map_err(|_| Error::InvalidObjectsUrl)?;
        Ok(Location::Bucket(bucket.to_owned(), prefix))
    }
}

impl fmt::Display for ObjectsUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_buckets_and_folders() {
        let location = |url: &str| ObjectsUrl::parse(url).unwrap().location().unwrap();
        let bucket = |name: &str, prefix: &str| Location::Bucket(name.to_owned(), prefix.into());
        assert_eq!(location("s3://twins"), bucket("twins", ""));
        assert_eq!(location("s3://my.twins/a/b-c/"), bucket("my.twins", "a/b-c"));
        assert_eq!(location("file:///srv/twins"), Location::Folder("/srv/twins".into()));
    }

    #[test]
    fn what_is_no_place_is_refused_without_repeating_it() {
        for wrong in [
            "",
            "twins",
            "s3://",
            "s3://a",
            "s3://key:secret@bucket",
            "s3://bucket/a?secret=1",
            "s3://bucket/a//b",
            "s3://bucket/../secret",
            "file://secret/a",
            "file:///",
            "gs://secret",
        ] {
            let refused = ObjectsUrl::parse(wrong).unwrap_err();
            assert!(matches!(refused, Error::InvalidObjectsUrl), "{wrong}");
            assert!(!format!("{refused} {refused:?}").contains("secret"));
        }
    }
}

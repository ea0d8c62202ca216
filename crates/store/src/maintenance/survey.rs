//! The content that rows refer to, compared with the existing files.

use std::{fs, io, path::Path};

use serde::Serialize;

use crate::blobs::{files, references::Reference};

/// Part of a reference to an upload that is whole and not yet a capture.
pub(super) const UPLOAD: &str = "upload";

/// Thoroughness of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Presence and sizes.
    Sizes,
    /// Digests, too: all content is read.
    Digests,
}

/// Content of a row that is missing or damaged.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Damage {
    /// Resource name.
    pub name: String,
    /// Part of the resource: archive, observation, playback, masks, report, report page, masks
    /// supplement, calibration supplement, checkpoint, twin or upload.
    pub part: String,
    /// BLAKE3 that the row has.
    pub digest: String,
    /// The fault.
    pub fault: String,
}

/// The fault of a row's content, if there is one.
pub(super) fn inspect(
    blobs: &Path,
    reference: &Reference,
    depth: Depth,
) -> io::Result<Option<Damage>> {
    let file = files::published(blobs, &reference.digest);
    let fault = match fs::metadata(&file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            if is_arriving(blobs, reference) {
                return Ok(None);
            }
            Some("missing".to_owned())
        }
        found => {
            let found = found?.len();
            match reference.size_bytes {
                Some(stored) if u64::try_from(stored) != Ok(found) => {
                    Some(format!("{found} bytes instead of {stored}"))
                }
                _ if depth == Depth::Sizes => None,
                _ => (!files::is_content(&file, &reference.digest)?)
                    .then(|| "other content".to_owned()),
            }
        }
    };
    let Reference { name, part, digest, .. } = reference.clone();
    Ok(fault.map(|fault| Damage { name, part, digest, fault }))
}

/// True if the content of an upload is still in the file in which it arrived.
fn is_arriving(blobs: &Path, reference: &Reference) -> bool {
    let id = reference.name.rsplit('/').next().unwrap_or_default();
    reference.part == UPLOAD && blobs.join("partial").join(id).exists()
}

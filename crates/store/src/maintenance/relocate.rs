//! The move of a store's content from its folder to a bucket, or to another folder. Rows stay where they
//! are.
//!
//! Every blob is compared with its digest and copied; copies of an earlier, interrupted run are
//! kept. Then a marker in the folder says where its content is, and the old folder is kept under
//! another name. Uploads under way are not moved: they begin again.

use std::{fs, path::Path};

use futures::future::try_join_all;
use serde::Serialize;

use crate::{
    Error, ObjectsUrl, Result,
    blobs::{Place, files, own},
    database, folder,
    store::meter::{Meter, Part},
};

/// Blobs moved concurrently.
const AT_ONCE: usize = 8;
/// Name of the old folder.
const KEPT: &str = "blobs.migrated";

/// Outcome of a move of content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Relocation {
    /// The new place.
    pub objects: String,
    /// Number of blobs there.
    pub blobs: usize,
    /// Sizes of the blobs together [bytes].
    pub blobs_bytes: u64,
    /// Digests of blobs that are damaged in the old folder: they are not in the new place.
    pub damaged: Vec<String>,
}

/// Moves the content of a store that no server has open.
///
/// # Errors
/// [`Error::DataDirInUse`]; [`Error::NotFound`] if there is no content with an identity;
/// [`Error::StoreMismatch`] if the place has the content of another store;
/// [`Error::ObjectsElsewhere`], [`Error::ObjectsUnavailable`], [`Error::ObjectsRefused`]; file errors.
pub async fn relocate(data_dir: &Path, to: &ObjectsUrl) -> Result<Relocation> {
    database::require_settled(data_dir)?;
    let from = own(data_dir);
    let identity = match from.is_dir() {
        true => files::identity(&from)?,
        false => None,
    };
    let identity = identity.ok_or_else(|| Error::NotFound { name: from.display().to_string() })?;
    let _lock = database::lock(data_dir)?;
    database::require_objects(data_dir, Some(to))?;
    let place = Place::open(Some(to), data_dir, false, Meter::idle(Part::Content))?;
    match place.identity().await? {
        Some(theirs) if theirs == identity => {}
        None if !place.any().await? => place.set_identity(&identity).await?,
        _ => {
            let database = data_dir.display().to_string();
            return Err(Error::StoreMismatch { database, blobs: place.name() });
        }
    }
    let mut done = Relocation { objects: to.to_string(), ..Relocation::default() };
    let there = place.sizes().await?;
    for some in files::all(&from)?.chunks(AT_ONCE) {
        let moved = some.iter().map(async |(digest, size_bytes)| {
            match there.get(digest) == Some(size_bytes) {
                true => Ok::<_, Error>(true),
                false => place.put(digest, files::published(&from, digest)).await,
            }
        });
        for (moved, (digest, size_bytes)) in try_join_all(moved).await?.into_iter().zip(some) {
            match moved {
                true => {
                    (done.blobs, done.blobs_bytes) =
                        (done.blobs + 1, done.blobs_bytes + size_bytes);
                }
                false => done.damaged.push(digest.clone()),
            }
        }
    }
    database::leave_objects(data_dir, to)?;
    fs::rename(&from, data_dir.join(KEPT))?;
    folder::sync(data_dir)?;
    Ok(done)
}

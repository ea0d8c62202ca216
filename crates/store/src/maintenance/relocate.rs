//! The move of a store's content from its folder to a bucket, or to another folder. Rows stay where they
//! are.
//!
//! Every blob is compared with its digest and copied; copies of an earlier, interrupted run are
//! kept. Then a marker in the folder says where its content is, and the old folder is kept under
//! another name. Uploads under way are not moved: they begin again.

use std::{collections::BTreeMap, fs, io, path::Path, sync::Arc};

use futures::{TryStreamExt as _, future::try_join_all};
use serde::Serialize;

use super::survey;
use crate::{
    Error, ObjectsUrl, Result,
    blobs::{Bucket, Place, files, own, published},
    database, folder,
    meter::{Meter, Part},
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
    let there = sizes(&place).await?;
    for some in files::all(&from)?.chunks(AT_ONCE) {
        let moved = some.iter().map(|(digest, size_bytes)| {
            let is_there = there.get(digest) == Some(size_bytes);
            bring(&from, &place, digest, *size_bytes, is_there)
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

/// Sizes of the blobs that are in a place [bytes].
async fn sizes(place: &Place) -> Result<BTreeMap<String, u64>> {
    match place {
        Place::Folder(folder) => Ok(files::all(folder.root())?.into_iter().collect()),
        Place::Bucket(bucket) => of_bucket(bucket).await,
    }
}

async fn of_bucket(bucket: &Arc<Bucket>) -> Result<BTreeMap<String, u64>> {
    let mut sizes = BTreeMap::new();
    let mut listed = bucket.published();
    while let Some(object) = listed.try_next().await? {
        let digest = object.location.filename().map(str::to_owned);
        sizes.extend(digest.map(|digest| (digest, object.size)));
    }
    Ok(sizes)
}

/// Copies a blob unless it exists. Returns false if it is damaged.
async fn bring(
    from: &Path,
    place: &Place,
    digest: &str,
    size_bytes: u64,
    is_there: bool,
) -> Result<bool> {
    if is_there {
        return Ok(true);
    }
    let file = files::published(from, digest);
    let (checked, wanted) = (file.clone(), digest.to_owned());
    let checking = tokio::task::spawn_blocking(move || survey::is_content(&checked, &wanted));
    if !checking.await.map_err(io::Error::other)?? {
        return Ok(false);
    }
    match place {
        Place::Bucket(bucket) => bucket.send(&file, &published(digest), size_bytes).await?,
        Place::Folder(folder) => {
            let to = folder.file(digest);
            let copying = tokio::task::spawn_blocking(move || copy(&file, &to));
            copying.await.map_err(io::Error::other)??;
        }
    }
    Ok(true)
}

/// Copies a file, atomically and durably.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    let parent = to.parent().unwrap_or(to);
    folder::make(parent)?;
    let partial = to.with_extension("partial");
    fs::copy(from, &partial)?;
    fs::File::open(&partial)?.sync_all()?;
    fs::rename(&partial, to)?;
    folder::sync(parent)
}

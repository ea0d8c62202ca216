//! Parts of the masks of one camera: folders with images of a thing each, files of labels for each
//! frame, or files with all frames.

use std::{collections::BTreeSet, sync::Arc};

use super::place::{Places, Rig};
use crate::{
    Error,
    files::{Files, at_most},
    limits::Budget,
    raw::{
        Camera,
        numbering::{Images, Numbering},
        stored::{Labelled, MAX_PARTS, MaskFiles, Place, Shown, mask_words, whole_masks},
    },
};

/// Extensions of masks of one frame, the preferred first. Of a tool that writes arrays and pictures
/// of them the arrays count.
const EXTENSIONS: &[&[&str]] = &[&["npy"], &["npz"], &["png"], &["json"], &["jpg", "jpeg"]];
/// Extensions of files with all frames.
const WHOLE: &[&str] = &["npz", "npy", "json"];
/// Folders that say nothing about what is in them.
const PLAIN: &[&str] =
    &["annotations", "mask_data", "mask", "masks", "label", "labels", "segmentation", "instance"];
/// Files that are read for the labels in them, evenly among all.
const LOOKED_AT: usize = 24;

/// What the masks of a camera show, by label.
pub(super) struct Part {
    /// The label as the files have it: the name of a folder, or a number.
    pub(super) label: String,
    /// The folder or file.
    pub(super) at: String,
    /// `true` if the files have several labels, or may have.
    pub(super) is_one_of: bool,
    pub(super) stored: Stored,
}

/// The files of a part.
pub(super) enum Stored {
    /// A file for each frame.
    Images(Images),
    /// A file for all frames.
    Whole(String),
}

/// What one camera has.
#[derive(Default)]
pub(super) struct CameraParts {
    pub(super) parts: Vec<Part>,
    pub(super) there: String,
    pub(super) left_out: Vec<(String, String)>,
}

pub(super) fn find(
    files: &mut Files<'_>,
    rig: &Rig,
    index: usize,
    camera: &Camera,
    frames: usize,
) -> Result<CameraParts, Error> {
    let Places { folders, files: whole } = rig.camera(index);
    let mut found = CameraParts::default();
    let mut places = folders.iter().map(|folder| files.describe(folder)).collect::<Vec<_>>();
    if places.is_empty() {
        places.push(files.describe(&format!("{}{index}", rig.folder())));
    }
    found.there = places.join("; ");
    for folder in folders {
        in_folder(files, &folder, camera, frames, &mut found)?;
    }
    if found.parts.is_empty() {
        // Each of them is decoded, and may turn out to be empty.
        at_most("masks of a camera", whole.len(), MAX_PARTS)?;
    }
    for file in whole {
        if found.parts.is_empty() {
            in_whole(files, &file, camera, frames, &mut found)?;
        } else {
            found.left_out.push((file, "masks lie in a folder beside it".to_owned()));
        }
    }
    at_most("masks of a camera", found.parts.len(), MAX_PARTS)?;
    Ok(found)
}

fn in_folder(
    files: &mut Files<'_>,
    folder: &str,
    camera: &Camera,
    frames: usize,
    found: &mut CameraParts,
) -> Result<(), Error> {
    let contents = files.list(folder);
    at_most("masks of a camera", contents.folders.len(), MAX_PARTS)?;
    let plain = contents.folders.iter().find(|name| {
        PLAIN.contains(&name.to_ascii_lowercase().as_str())
            && contents.folders.iter().all(|n| n == *name || n == super::documents::FOLDER)
    });
    if let Some(plain) = plain {
        return labelled(files, &format!("{folder}/{plain}"), camera, frames, found);
    }
    for name in contents.folders {
        let at = format!("{folder}/{name}");
        let images = images_in(files, &at)?;
        if images.is_empty() {
            found.left_out.push((at, "it has no masks with a number in their name".to_owned()));
            continue;
        }
        let stored = Stored::Images(images);
        found.parts.push(Part { label: name, at, is_one_of: false, stored });
    }
    if found.parts.is_empty() {
        return labelled(files, folder, camera, frames, found);
    }
    if !contents.files.iter().all(|name| name.ends_with(".json")) {
        let because = "the folders in it have masks".to_owned();
        found.left_out.push((format!("files in {folder}"), because));
    }
    Ok(())
}

/// Files of labels in a folder: one for each frame, or with all frames.
fn labelled(
    files: &mut Files<'_>,
    folder: &str,
    camera: &Camera,
    frames: usize,
    found: &mut CameraParts,
) -> Result<(), Error> {
    let images = images_in(files, folder)?;
    if !images.is_empty() {
        check_pixels(files, camera, images.in_order().len(), frames)?;
        let labels = in_images(files, &images, camera);
        for label in labels {
            let (at, stored) = (folder.to_owned(), Stored::Images(images.clone()));
            found.parts.push(Part { label, at, is_one_of: true, stored });
        }
        return Ok(());
    }
    let mut names = files.list(folder).files;
    names.retain(|name| is_whole(name));
    at_most("masks of a camera", names.len(), MAX_PARTS)?;
    for name in names {
        let stem = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem);
        let at = format!("{folder}/{name}");
        let before = found.parts.len();
        in_whole(files, &at, camera, frames, found)?;
        // A file of one thing is known by its name.
        if let [part] = &mut found.parts[before..]
            && part.label == "1"
            && !PLAIN.contains(&stem.to_ascii_lowercase().as_str())
        {
            stem.clone_into(&mut part.label);
            part.is_one_of = false;
        }
    }
    Ok(())
}

/// `true` if a file may have the masks of all frames, by its name.
fn is_whole(name: &str) -> bool {
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    let is_wanted = |ending: &str| WHOLE.iter().any(|e| ending.eq_ignore_ascii_case(e));
    ending.is_some_and(is_wanted) && !super::documents::is_one(name)
}

/// A file with the masks of all frames.
fn in_whole(
    files: &mut Files<'_>,
    at: &str,
    camera: &Camera,
    frames: usize,
    found: &mut CameraParts,
) -> Result<(), Error> {
    let size = [camera.width, camera.height];
    check_pixels(files, camera, frames, frames)?;
    let all = whole_masks(&mut files.fork(), at, size, frames)?;
    let mut labels = BTreeSet::new();
    for frame in &all {
        mask_words(frame, |label| note(&mut labels, label));
    }
    for label in labels {
        let stored = Stored::Whole(at.to_owned());
        found.parts.push(Part { label, at: at.to_owned(), is_one_of: true, stored });
    }
    Ok(())
}

/// Refuses more pixels than an archive of this size may hold, before any of them is decoded.
fn check_pixels(
    files: &Files<'_>,
    camera: &Camera,
    images: usize,
    frames: usize,
) -> Result<(), Error> {
    let pixels = (camera.width as u64).saturating_mul(camera.height as u64);
    let all = pixels.saturating_mul(images as u64);
    files.limits.check_pixels(all, frames, files.length())
}

/// The masks of a folder that have a number in their names.
fn images_in(files: &mut Files<'_>, folder: &str) -> Result<Images, Error> {
    let mut names = files.list(folder).files;
    names.retain(|name| !super::documents::is_one(name));
    for extensions in EXTENSIONS {
        let images = Images::among(files, folder, &names, extensions)?;
        if !images.is_empty() {
            return Ok(images);
        }
    }
    Ok(Images::default())
}

/// Labels in some of the images. One that is damaged is found when it is read.
fn in_images(files: &Files<'_>, images: &Images, camera: &Camera) -> BTreeSet<String> {
    let mut labels = BTreeSet::new();
    for labelled in sample(files, images, camera, LOOKED_AT) {
        labelled.words(|label| note(&mut labels, label));
    }
    if labels.is_empty() {
        // They are there, and black where they were looked at.
        labels.insert("1".to_owned());
    }
    labels
}

/// Some of the images, evenly among all; those that cannot be read are left out.
pub(super) fn sample(
    files: &Files<'_>,
    images: &Images,
    camera: &Camera,
    count: usize,
) -> impl Iterator<Item = Labelled> {
    let mut files = files.fork();
    let size = [camera.width, camera.height];
    let names: Vec<String> = {
        let all = images.in_order();
        let step = all.len().div_ceil(count).max(1);
        let last = all.len().saturating_sub(1);
        let chosen = all.enumerate().filter(|(i, _)| i % step == 0 || *i == last);
        chosen.map(|(_, name)| name.to_owned()).collect()
    };
    names.into_iter().filter_map(move |name| {
        files.budget = Budget::new(&files.limits);
        let limits = files.limits.clone();
        let bytes = files.find(&name).ok()??;
        Labelled::decode(&name, &bytes, size, &limits, &mut files.budget).ok()
    })
}

/// Keeps a label; noise may have thousands.
fn note(labels: &mut BTreeSet<String>, label: &str) {
    if labels.len() <= MAX_PARTS && !labels.contains(label) {
        labels.insert(label.to_owned());
    }
}

impl Part {
    /// The form of the files in words.
    pub(super) fn form(&self, name: &str) -> String {
        let kind = match &self.stored {
            Stored::Images(images) => images.in_order().next().unwrap_or_default(),
            Stored::Whole(name) => name,
        };
        let ending = kind.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
        let kind = match ending.as_str() {
            "json" => "run lengths of COCO".to_owned(),
            ending => format!(".{ending}"),
        };
        let label = match (self.is_one_of, self.label == name) {
            (_, true) => String::new(),
            (true, false) => format!(", label {} is `{name}`", self.label),
            (false, false) => format!(", `{name}`"),
        };
        let all = if matches!(self.stored, Stored::Whole(_)) { " of all frames" } else { "" };
        format!("{kind}{all}{label}")
    }

    pub(super) fn files(self, numbering: Numbering) -> MaskFiles {
        let place = match self.stored {
            Stored::Images(images) => Place::Each(images.names(numbering)),
            Stored::Whole(name) => Place::Whole(name),
        };
        let one = || Shown::Labels(Arc::new(BTreeSet::from([self.label])));
        MaskFiles { place, shown: if self.is_one_of { one() } else { Shown::Any } }
    }
}

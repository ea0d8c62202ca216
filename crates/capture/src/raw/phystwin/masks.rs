//! Masks of a PhysTwin case: a folder for each part, and a document that labels them. Folders that
//! are named by their label need none.

use std::collections::BTreeMap;

use bendtwin_core::Finding;

use super::{MARKER, labels::Labels, layout::Folders};
use crate::{
    Error,
    files::{Files, at_most, shortened},
    phystwin::json,
    raw::{
        Region,
        numbering::{Images, MASK, Numbering},
        stored::{MAX_PARTS, Names},
    },
};

/// Label of the only part where nothing labels it.
const ONLY: &str = "object";

/// Masks of one camera.
pub(super) struct Masks {
    /// Parts with a label and images.
    parts: Vec<(String, Images)>,
    /// Labelled parts without images.
    without_images: Vec<String>,
    /// Folders without a label.
    without_label: Vec<String>,
    /// Description of what lies there.
    there: String,
}

/// Finds the masks of all cameras.
pub(super) fn find(files: &mut Files<'static>, cameras: &[Folders]) -> Result<Vec<Masks>, Error> {
    cameras.iter().map(|folders| of_camera(files, folders.mask.clone())).collect()
}

fn of_camera(files: &mut Files<'static>, [folder, info]: [String; 2]) -> Result<Masks, Error> {
    let folders = files.list(&folder).folders;
    at_most("masks of a camera", folders.len(), MAX_PARTS)?;
    let labels: BTreeMap<String, String> = match files.find_document(&info)? {
        Some(bytes) => json(&bytes, &info)?,
        None => unlabelled(&folders, &info)?,
    };
    at_most("masks of a camera", labels.len(), MAX_PARTS)?;
    let mut masks = Masks {
        parts: Vec::new(),
        without_images: Vec::new(),
        without_label: folders.iter().filter(|name| !labels.contains_key(*name)).cloned().collect(),
        there: files.describe(&folder),
    };
    for (part, label) in labels {
        if part.is_empty() || part.contains(['/', '\\']) || part.starts_with('.') {
            let fault = format!("`{part}` is no name of a folder with masks");
            return Err(Error::Document { at: info, fault });
        }
        let images = Images::in_folder(files, &format!("{folder}/{part}"), MASK)?;
        if images.is_empty() {
            masks.without_images.push(format!("{part} ({label})"));
        } else {
            masks.parts.push((label, images));
        }
    }
    let none_fits = masks.parts.is_empty() && !masks.without_images.is_empty();
    if none_fits && !masks.without_label.is_empty() {
        return Err(Error::MaskLabels(format!(
            "`{info}` labels {}, but {}: give the folders of masks as its keys",
            shortened(&masks.without_images, masks.without_images.len()),
            masks.there
        )));
    }
    Ok(masks)
}

/// Labels of folders that no document labels: their names, or one where there is one.
fn unlabelled(folders: &[String], info: &str) -> Result<BTreeMap<String, String>, Error> {
    let is_number = |name: &String| name.bytes().all(|b| b.is_ascii_digit());
    if let [only] = folders
        && is_number(only)
    {
        return Ok([(only.clone(), ONLY.to_owned())].into());
    }
    if folders.iter().any(is_number) {
        return Err(Error::MaskLabels(format!(
            "there are masks {}, but no `{info}` says what they show: write it, as in {{\"0\": \"object\", \"1\": \"hand\"}}",
            shortened(folders, folders.len())
        )));
    }
    Ok(folders.iter().map(|name| (name.clone(), name.clone())).collect())
}

impl Masks {
    pub(super) fn labels(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().map(|(label, _)| label.as_str())
    }

    /// The finding that names labels without masks, and masks without a label.
    pub(super) fn note(&self, camera: usize) -> Option<Finding> {
        let part = |names: &[String], what: &str| {
            (!names.is_empty()).then(|| format!("{what} {}", shortened(names, names.len())))
        };
        let said = [
            part(&self.without_images, "has labels without masks:"),
            part(&self.without_label, "has masks without a label, which are passed over:"),
        ];
        let said: Vec<String> = said.into_iter().flatten().collect();
        if said.is_empty() {
            return None;
        }
        let message = format!("mask_info_{camera}.json {}; {}", said.join(" and "), self.there);
        let advice =
            format!("make the keys of mask/mask_info_{camera}.json the folders beside {MARKER}");
        Some(
            Finding { advice, ..Finding::warning("MASK_INFO_MISMATCH", message) }.cameras([camera]),
        )
    }

    /// Names of the masks of object and manipulator.
    pub(super) fn names(
        self,
        labels: &Labels,
        numbering: Numbering,
        color: &Images,
    ) -> Result<[Vec<Names>; 2], Error> {
        let [mut object, mut manipulator] = [Vec::new(), Vec::new()];
        for (label, images) in self.parts {
            images.expect_within(numbering, color)?;
            let region = match labels.region(&label) {
                Region::Object => &mut object,
                Region::Manipulator => &mut manipulator,
            };
            region.push(images.names(numbering));
        }
        Ok([object, manipulator])
    }
}

//! Masks of a PhysTwin case, and those that are added to a recording later: found among the files as
//! tools write them. Each camera has folders of images for single things, or files of labels, and
//! documents may say what labels show.

mod added;
mod documents;
mod parts;
mod place;
mod sizes;

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use bendtwin_core::Finding;

use self::{documents::Names, parts::Part, place::Rig};
use super::labels::Labels;
use crate::{
    Error, Sources,
    files::{Files, shortened},
    raw::{
        Camera, Region,
        numbering::{Images, Numbering},
        stored::{MaskFiles, Place, Shown},
    },
};

/// Label of the only part where nothing labels it.
const ONLY: &str = "object";

/// Section of the guide about masks.
const GUIDE: &str = "docs/use/cameras.md#masks";

/// Masks of all cameras, found and labelled.
pub(super) struct Found {
    cameras: Vec<CameraMasks>,
    /// A folder of masks that are of no camera, and what lies there.
    strange: Option<(String, String)>,
}

/// Masks of one camera.
struct CameraMasks {
    /// Parts with their label.
    parts: Vec<(String, Part)>,
    /// Labelled parts that are not there.
    absent: Vec<String>,
    /// Parts that the document does not label.
    without_label: Vec<String>,
    /// The document with labels, if there is one.
    document: Option<String>,
    /// Description of what lies there.
    there: String,
    /// Files and folders that were passed over, with the reason.
    left_out: Vec<(String, String)>,
}

/// Masks of a camera by region, ready to be read.
pub(super) type Regions = [Vec<MaskFiles>; 2];

/// Finds the masks of all cameras of a recording with `frames` frames.
///
/// # Errors
/// If nothing says what several labels show, or a document is damaged.
pub(super) fn find(
    files: &mut Files<'_>,
    cameras: &[Camera],
    frames: usize,
) -> Result<Found, Error> {
    let rig = Rig::find(files, cameras);
    let mut found = Vec::with_capacity(cameras.len());
    let mut names = Vec::with_capacity(cameras.len());
    for (index, camera) in cameras.iter().enumerate() {
        let of_camera = parts::find(files, &rig, index, camera, frames)?;
        names.push(documents::find(files, &rig, index, camera, &of_camera)?);
        found.push(of_camera);
    }
    let nameless = |parts: &[Part], names: &Names| -> Vec<String> {
        let unknown = parts.iter().filter(|part| names.of(&part.label).is_none());
        unknown.map(|part| part.label.clone()).collect()
    };
    let all: BTreeSet<String> = found
        .iter()
        .zip(&names)
        .filter(|(_, names)| names.document.is_none())
        .flat_map(|(found, names)| nameless(&found.parts, names))
        .collect();
    let is_only = all.len() == 1
        && names.iter().all(|names| names.document.is_none())
        && found.iter().all(|found| found.parts.iter().all(|part| all.contains(&part.label)));
    if !all.is_empty() && !is_only {
        let unclear = found.iter().zip(&names).position(|(found, names)| {
            names.document.is_none() && !nameless(&found.parts, names).is_empty()
        });
        let index = unclear.unwrap_or_default();
        return Err(unnamed(files, &rig, cameras, index, &found[index].parts, &all));
    }
    let only = is_only.then_some(ONLY);
    let labelled = found.into_iter().zip(names).map(|(found, names)| found.labelled(names, only));
    let cameras: Vec<CameraMasks> = labelled.collect::<Result<_, _>>()?;
    let has_none = cameras.iter().all(|masks| masks.parts.is_empty() && masks.left_out.is_empty());
    let strange = rig.strange.filter(|_| has_none).map(|folder| {
        let because = format!(
            "no name in it is the number or the name of a camera: {}",
            files.describe(&folder)
        );
        (folder, because)
    });
    Ok(Found { cameras, strange })
}

/// The error for labels that nothing names, with the document to write.
fn unnamed(
    files: &Files<'_>,
    rig: &Rig,
    cameras: &[Camera],
    index: usize,
    parts: &[Part],
    all: &BTreeSet<String>,
) -> Error {
    let shown: Vec<String> = parts.iter().map(|part| part.label.clone()).collect();
    let words = sizes::in_words(files, &cameras[index], parts);
    let words = if words.is_empty() { shown.clone() } else { words };
    let labels = if shown.len() > 1 { shown } else { all.iter().cloned().collect() };
    let example = |(place, label): (usize, &String)| {
        format!("\"{label}\": \"{}\"", if place == 0 { "object" } else { "hand" })
    };
    let example: Vec<String> = labels.iter().take(4).enumerate().map(example).collect();
    let at = parts.first().map_or("mask", |part| match part.at.rsplit_once('/') {
        Some((above, _)) if !part.is_one_of => above,
        _ => part.at.as_str(),
    });
    let folder = rig.folder();
    Error::MaskLabels(format!(
        "the masks in `{at}` have the labels {}, and nothing says what they show: write `{folder}labels.json`, as in \
         {{{}}} with what each of them really is, or `{folder}mask_info_{index}.json` if labels mean something else in \
         each camera ({GUIDE})",
        shortened(&words, words.len()),
        example.join(", "),
    ))
}

impl parts::CameraParts {
    fn labelled(self, names: Names, only: Option<&str>) -> Result<CameraMasks, Error> {
        let own: Vec<String> = self.parts.iter().map(|part| part.label.clone()).collect();
        let absent = names.absent(&own);
        let mut masks = CameraMasks {
            parts: Vec::new(),
            absent,
            without_label: Vec::new(),
            document: names.document.clone(),
            there: self.there,
            left_out: self.left_out,
        };
        for part in self.parts {
            match names.of(&part.label).or(only) {
                Some(name) => masks.parts.push((name.to_owned(), part)),
                None => masks.without_label.push(part.label),
            }
        }
        if let Some(document) = &masks.document
            && masks.parts.is_empty()
            && !masks.absent.is_empty()
            && !masks.without_label.is_empty()
        {
            return Err(Error::MaskLabels(format!(
                "`{document}` labels {}, but {}: give the labels of the masks as its keys, {} ({GUIDE})",
                shortened(&masks.absent, masks.absent.len()),
                masks.there,
                shortened(&masks.without_label, masks.without_label.len()),
            )));
        }
        Ok(masks)
    }
}

impl Found {
    /// `true` if no camera has masks.
    fn is_empty(&self) -> bool {
        self.cameras.iter().all(|masks| masks.parts.is_empty())
    }

    /// Sorts the masks into regions and adds what was understood of them. `chosen` are the labels
    /// that are declared to be the object, `numbering` is that of the cameras' images `colors`.
    ///
    /// # Errors
    /// If labels are unclear, or numbers are not those of the images.
    pub(super) fn sort(
        self,
        chosen: &[String],
        cameras: &[Camera],
        numbering: Numbering,
        colors: &[&Images],
        notes: &mut Vec<Finding>,
        sources: &mut Sources,
    ) -> Result<Vec<Regions>, Error> {
        let all = self.cameras.iter().flat_map(|masks| &masks.parts);
        let all: BTreeSet<String> = all.map(|(label, _)| label.clone()).collect();
        let labels = Labels::sort(&all, chosen)?;
        if let Some((from, because)) = self.strange {
            sources.leave_out(from, because);
        }
        notes.extend(labels.note());
        let mut regions = Vec::with_capacity(cameras.len());
        for (index, (masks, camera)) in self.cameras.into_iter().zip(cameras).enumerate() {
            notes.extend(masks.note(index));
            for (from, because) in &masks.left_out {
                sources.leave_out(from, because);
            }
            let mut of_camera = Regions::default();
            for (label, part) in masks.parts {
                let (place, what) = match labels.region(&label) {
                    Region::Object => (0, "object masks"),
                    Region::Manipulator => (1, "hand masks"),
                };
                sources.take(what, Some(&camera.name), &part.at, part.form(&label));
                if let (parts::Stored::Images(images), Some(color)) =
                    (&part.stored, colors.get(index))
                {
                    images.expect_within(numbering, color)?;
                }
                of_camera[place].push(part.files(numbering));
            }
            regions.push(of_camera.map(joined));
        }
        Ok(regions)
    }
}

/// Labels of the same files are read together.
fn joined(all: Vec<MaskFiles>) -> Vec<MaskFiles> {
    let mut joined: Vec<MaskFiles> = Vec::with_capacity(all.len());
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    for files in all {
        let key = match &files.place {
            Place::Whole(name) => Some(name.clone()),
            Place::Each(names) => names.at(0).map(|name| name.into_owned()),
        };
        let before =
            key.as_ref().and_then(|key| places.get(key)).and_then(|at| joined.get_mut(*at));
        match (before, &files.shown) {
            (Some(MaskFiles { shown: Shown::Labels(labels), .. }), Shown::Labels(more)) => {
                Arc::make_mut(labels).extend(more.iter().cloned());
            }
            _ => {
                if let Some(key) = key {
                    places.insert(key, joined.len());
                }
                joined.push(files);
            }
        }
    }
    joined
}

impl CameraMasks {
    /// The finding that names labels without masks, and masks without a label.
    fn note(&self, camera: usize) -> Option<Finding> {
        let document = self.document.as_ref()?;
        let part = |names: &[String], what: &str| {
            (!names.is_empty()).then(|| format!("{what} {}", shortened(names, names.len())))
        };
        let said = [
            part(&self.absent, "has labels without masks:"),
            part(&self.without_label, "has masks without a label, which are passed over:"),
        ];
        let said: Vec<String> = said.into_iter().flatten().collect();
        if said.is_empty() {
            return None;
        }
        let message = format!("{document} {}; {}", said.join(" and "), self.there);
        let advice = format!("make the keys of {document} the labels of the masks");
        Some(
            Finding { advice, ..Finding::warning("MASK_INFO_MISMATCH", message) }.cameras([camera]),
        )
    }
}

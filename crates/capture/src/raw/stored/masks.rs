//! Masks in files: an image for each frame, or one file for all frames; each with one label, or with
//! several, of which some belong to a region.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use super::{Names, OVERHEAD, Reader};
use crate::{
    Error, Limits,
    files::Files,
    limits::Budget,
    raw::{
        Image, Mask,
        decode::{
            self, Size,
            masks::{Expected, Layer, Layers, read},
        },
    },
};

/// Bytes that an array has for each pixel of an image, at most.
const MOST_BYTES: u64 = 16;

/// Masks of one region, or a part of it.
#[derive(Clone, Debug)]
pub(in crate::raw) struct MaskFiles {
    pub(in crate::raw) place: Place,
    pub(in crate::raw) shown: Shown,
}

/// Place of masks.
#[derive(Clone, Debug)]
pub(in crate::raw) enum Place {
    /// A file for each frame.
    Each(Names),
    /// A file for all frames.
    Whole(String),
}

/// Labels in files of masks that belong to a region.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::raw) enum Shown {
    /// All of them: every pixel that is not 0.
    Any,
    /// Those with these words.
    Labels(Arc<BTreeSet<String>>),
}

/// Labels of the pixels of a file for one frame.
#[derive(Debug)]
pub(in crate::raw) enum Labelled {
    Image(Image<u32>),
    Layers(Layers),
}

/// Masks that were read already.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// Masks of all frames by their files.
    whole: BTreeMap<String, Vec<Layers>>,
    /// What these may still take, all together; none before the first.
    budget: Option<Budget>,
    /// Those of the last frame, which the regions share, with their file.
    last: Option<(String, Labelled)>,
}

impl MaskFiles {
    /// Images that show nothing else.
    pub(in crate::raw) fn of(names: Names) -> Self {
        Self { place: Place::Each(names), shown: Shown::Any }
    }
}

impl Shown {
    fn has(&self, label: &str) -> bool {
        match self {
            Self::Any => true,
            Self::Labels(labels) => labels.contains(label),
        }
    }

    /// Tells of numbers whether it has them; each is looked up once.
    fn numbers(&self) -> impl FnMut(u32) -> bool {
        let mut known = BTreeMap::from([(0, false)]);
        let mut last = (0, false);
        move |label| {
            if last.0 != label {
                let has = || self.has(&decode::label_word(label));
                last = (label, *known.entry(label).or_insert_with(has));
            }
            last.1
        }
    }
}

impl Labelled {
    /// Decodes a file for one frame.
    pub(in crate::raw) fn decode(
        at: &str,
        bytes: &[u8],
        size: Size,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<Self, Error> {
        let ending = at.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
        if !["npy", "npz", "json"].contains(&ending.as_str()) {
            return decode::labels(at, bytes, size).map(Self::Image);
        }
        let expected = Expected { size, frames: 1, whole: false };
        let frames = read(at, bytes, expected, limits, budget)?;
        Ok(Self::Layers(frames.into_iter().next().unwrap_or_default()))
    }

    /// Pixels with these labels.
    fn mask(&self, shown: &Shown, size: Size) -> Mask {
        match self {
            Self::Image(image) => {
                let mut has = shown.numbers();
                let pixels = image.pixels.iter().map(|label| has(*label)).collect();
                Image { width: size[0], height: size[1], pixels }
            }
            Self::Layers(layers) => mask(layers, shown, size),
        }
    }

    /// Calls `note` with the word of every label that shows something, with repetitions.
    pub(in crate::raw) fn words(&self, mut note: impl FnMut(&str)) {
        match self {
            Self::Image(image) => {
                let mut word = Word::default();
                image.pixels.iter().filter(|l| **l != 0).for_each(|label| note(word.of(*label)));
            }
            Self::Layers(layers) => words(layers, note),
        }
    }

    /// Calls `pixel` with the word of the label of every pixel that shows something, and its index.
    pub(in crate::raw) fn each(&self, size: Size, mut pixel: impl FnMut(&str, usize)) {
        match self {
            Self::Image(image) => {
                let mut word = Word::default();
                let shown = image.pixels.iter().enumerate().filter(|(_, label)| **label != 0);
                shown.for_each(|(index, label)| pixel(word.of(*label), index));
            }
            Self::Layers(layers) => {
                let mut word = Word::default();
                for layer in layers {
                    layer.runs.each(size, |index, label| match &layer.label {
                        Some(name) => pixel(name, index),
                        None => pixel(word.of(label), index),
                    });
                }
            }
        }
    }
}

/// The word of the last label.
#[derive(Default)]
struct Word(u32, String);

impl Word {
    fn of(&mut self, label: u32) -> &str {
        if self.0 != label || self.1.is_empty() {
            *self = Self(label, decode::label_word(label));
        }
        &self.1
    }
}

/// Calls `note` with the word of every label of layers that shows something, with repetitions.
pub(in crate::raw) fn words(layers: &Layers, mut note: impl FnMut(&str)) {
    let mut word = Word::default();
    for layer in layers {
        for label in layer.runs.labels() {
            match &layer.label {
                Some(name) => {
                    note(name);
                    break;
                }
                None => note(word.of(label)),
            }
        }
    }
}

fn mask(layers: &Layers, shown: &Shown, size: Size) -> Mask {
    let mut whole = Mask::filled(size[0], size[1], false);
    for layer in layers {
        let named = layer.label.as_ref().map(|label| shown.has(label));
        if named == Some(false) {
            continue;
        }
        let mut has = shown.numbers();
        layer.runs.each(size, |index, label| {
            if named.is_some() || has(label) {
                whole.pixels[index] = true;
            }
        });
    }
    whole
}

impl Reader<'_> {
    /// The mask of a part in a frame.
    pub(super) fn part(&mut self, part: &MaskFiles, frame: usize) -> Result<Option<Mask>, Error> {
        let size = self.camera.size;
        match &part.place {
            Place::Each(names) => {
                if let (Some((at, labelled)), Some(name)) = (&self.kept.last, names.at(frame))
                    && *at == name
                {
                    return Ok(Some(labelled.mask(&part.shown, size)));
                }
                let Some((at, bytes)) = self.file(names, frame)? else { return Ok(None) };
                let limits = self.files.limits.clone();
                let labelled =
                    Labelled::decode(&at, &bytes, size, &limits, &mut self.files.budget)?;
                let mask = labelled.mask(&part.shown, size);
                if part.shown != Shown::Any {
                    self.kept.last = Some((at.into_owned(), labelled));
                }
                Ok(Some(mask))
            }
            Place::Whole(name) => {
                if !self.kept.whole.contains_key(name) {
                    let frames = whole(&mut self.files, name, size, self.frame_count)?;
                    let bytes = frames.iter().flatten().map(Layer::bytes);
                    let bytes = bytes.fold(0, u64::saturating_add);
                    let limits = &self.files.limits;
                    let budget = self.kept.budget.get_or_insert_with(|| Budget::new(limits));
                    budget.take(bytes, &format!("`{name}`"))?;
                    self.kept.whole.insert(name.clone(), frames);
                }
                let frames = self.kept.whole.get(name).map_or(&[][..], Vec::as_slice);
                // A frame beyond the recording's has none.
                let layers = frames.get(frame).filter(|layers| !layers.is_empty());
                Ok(layers.map(|layers| mask(layers, &part.shown, size)))
            }
        }
    }
}

/// Masks of all frames in a file, which may take the whole memory.
pub(in crate::raw) fn whole(
    files: &mut Files<'_>,
    name: &str,
    size: Size,
    frames: usize,
) -> Result<Vec<Layers>, Error> {
    files.budget = Budget::new(&files.limits);
    let pixels = (size[0] as u64).saturating_mul(size[1] as u64);
    let each = pixels.saturating_mul(MOST_BYTES).saturating_add(OVERHEAD);
    let cap = each.saturating_mul(frames as u64);
    let Some(bytes) = files.find_within(name, cap)? else { return Ok(Vec::new()) };
    let expected = Expected { size, frames, whole: true };
    let limits = files.limits.clone();
    read(name, &bytes, expected, &limits, &mut files.budget)
}

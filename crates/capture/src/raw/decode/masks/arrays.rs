//! Masks in arrays of numpy: labels, truth values, probabilities or logits of pixels, with any
//! dimensions for frames and labels before those of the image.

use super::{Expected, Layer, Layers, Runs};
use crate::{
    Error, Limits,
    array::Array,
    files::{Files, at_most},
    limits::Budget,
    npy,
    raw::{decode::same_size, stored::MAX_PARTS},
};

/// Arrays of an archive that name the masks of another one.
const IDS: &[&str] = &["ids", "obj_ids", "object_ids", "instance_ids", "labels", "track_ids"];

pub(super) fn of_npy(
    at: &str,
    bytes: &[u8],
    expected: Expected,
    budget: &mut Budget,
) -> Result<Vec<Layers>, Error> {
    split(&npy::read(at, bytes)?, expected, None, None, budget)
}

pub(super) fn of_npz(
    at: &str,
    bytes: &[u8],
    expected: Expected,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<Vec<Layers>, Error> {
    let mut files = Files::from_bytes(at, bytes, limits)?;
    std::mem::swap(&mut files.budget, budget);
    let read = of_files(at, &mut files, expected);
    std::mem::swap(&mut files.budget, budget);
    read
}

fn of_files(at: &str, files: &mut Files<'_>, expected: Expected) -> Result<Vec<Layers>, Error> {
    let names: Vec<String> = files.list("").files;
    let stem = |name: &str| name.strip_suffix(".npy").map(str::to_owned);
    let stems: Vec<String> = names.iter().filter_map(|name| stem(name)).collect();
    let most = MAX_PARTS.max(expected.frames) + IDS.len();
    at_most("arrays of an archive of masks", stems.len(), most)?;
    let is_ids = |stem: &String| IDS.contains(&stem.to_ascii_lowercase().as_str());
    let (mut ids, mut masks): (Vec<String>, Vec<String>) = stems.into_iter().partition(is_ids);
    if masks.is_empty() {
        std::mem::swap(&mut ids, &mut masks);
    }
    let ids = match ids.first().filter(|_| masks.len() == 1) {
        Some(stem) => {
            let bytes = files.read(&format!("{stem}.npy"))?;
            let array = npy::read(&format!("{at}: {stem}"), &bytes)?;
            array.integers(&mut files.budget).ok()
        }
        None => None,
    };
    let mut frames: Vec<Layers> = Vec::new();
    for (index, stem) in masks.iter().enumerate() {
        let bytes = files.read(&format!("{stem}.npy"))?;
        let array = npy::read(&format!("{at}: {stem}"), &bytes)?;
        let flat = array.shape.len() == 2;
        if masks.len() > 1 && flat && expected.whole {
            // Several images in one file are its frames, by their numbers.
            let digits = stem.rsplit(|c: char| !c.is_ascii_digit()).next();
            let frame = digits.and_then(|d| d.parse().ok()).unwrap_or(index);
            if frame >= expected.frames {
                let needed = format!("images of the frames 0 to {}", expected.frames - 1);
                return Err(array.wrong_shape(&needed));
            }
            let of_one = Expected { frames: 1, whole: false, ..expected };
            let layers = split(&array, of_one, None, None, &mut files.budget)?;
            frames.resize(frames.len().max(frame + 1), Vec::new());
            frames[frame].extend(layers.into_iter().flatten());
            continue;
        }
        let name = (masks.len() > 1).then_some(stem.as_str());
        let layers = split(&array, expected, name, ids.as_deref(), &mut files.budget)?;
        frames.resize(frames.len().max(layers.len()), Vec::new());
        frames.iter_mut().zip(layers).for_each(|(all, more)| all.extend(more));
    }
    if masks.is_empty() {
        let array = "one for each label, or one of labels".to_owned();
        return Err(Error::MissingArray { at: at.to_owned(), array });
    }
    Ok(frames)
}

/// The frames of an array, each with one layer for every image that it has. `name` is the label of
/// an array for one label, `ids` are those of the images of a frame.
fn split(
    array: &Array<'_>,
    expected: Expected,
    name: Option<&str>,
    ids: Option<&[i64]>,
    budget: &mut Budget,
) -> Result<Vec<Layers>, Error> {
    let Expected { size, frames, whole } = expected;
    let needed = || {
        let frames = if whole { format!("[{frames}, height, width]") } else { String::new() };
        let or = if whole { " or [frames, labels, height, width]" } else { "[height, width]" };
        array.wrong_shape(&format!("{frames}{or}"))
    };
    let mut shape = array.shape.as_slice();
    // Some keep a channel of one value.
    if let [.., height, width, 1] = *shape
        && [width, height] == size
    {
        shape = &shape[..shape.len() - 1];
    }
    let &[ref outer @ .., height, width] = shape else { return Err(needed()) };
    same_size(&array.at, [width, height], size)?;
    let (frame_count, layer_count, frame_first) = match (outer, whole) {
        ([], _) | ([1], false) => (1, 1, true),
        ([layers] | [layers, 1] | [1, layers], false) => (1, *layers, true),
        ([count] | [count, 1], true) if *count == frames => (frames, 1, true),
        ([count, layers], true) if *count == frames => (frames, *layers, true),
        ([layers, count], true) if *count == frames => (frames, *layers, false),
        _ => return Err(needed()),
    };
    at_most("masks of a camera", layer_count, MAX_PARTS)?;
    let pixels = width * height;
    let labels = array.labels();
    let mut found = Vec::with_capacity(frame_count);
    for frame in 0..frame_count {
        let mut layers = Vec::with_capacity(layer_count);
        for layer in 0..layer_count {
            let image =
                if frame_first { frame * layer_count + layer } else { layer * frame_count + frame };
            let own = (layer_count > 1 || ids.is_some_and(|ids| ids.len() == 1))
                .then(|| ids.and_then(|ids| ids.get(layer)).map_or(layer as i64, |id| *id));
            let label = match (name, own) {
                (Some(name), None) => Some(name.to_owned()),
                (Some(name), Some(own)) => Some(format!("{name}/{own}")),
                (None, own) => own.map(|own| own.to_string()),
            };
            let pixels = labels.range(image * pixels..(image + 1) * pixels);
            let runs = Runs::of(pixels, &array.at, budget)?;
            layers.push(Layer { label, runs });
        }
        found.push(layers);
    }
    Ok(found)
}

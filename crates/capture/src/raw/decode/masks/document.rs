//! Masks in JSON: run lengths of COCO, `{"size": [rows, columns], "counts": ...}`, wherever a tool
//! puts them. What stands above a mask says whose it is and of which frame: `segmentations` of
//! YouTube-VIS and SAM 3, `masklet` of SA-V, `annotations` of COCO and Grounded SAM 2, or keys that are
//! numbers.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::{
    Expected, Layer, Layers,
    runs::{self, Runs},
};
use crate::{
    Error,
    files::at_most,
    limits::Budget,
    phystwin::json,
    raw::{decode::same_size, numbering::number, stored::MAX_PARTS},
};

/// Bytes of memory for each byte of a document, at most: of numbers with one digit.
const PARSED: u64 = 24;

/// Keys of what a thing is called, the first counts.
const NAMES: &[&str] =
    &["class_name", "category_name", "label", "name", "category", "phrase", "prompt", "text"];
/// Keys of the number of a thing.
const IDS: &[&str] = &["obj_id", "object_id", "instance_id", "track_id", "masklet_id"];
/// Keys of the number of a frame.
const FRAMES: &[&str] = &["frame_index", "frame_idx", "frame_id", "frame", "image_id"];
/// Keys of the name of a frame's image.
const FILES: &[&str] = &["file_name", "image_path", "image", "filename", "frame_name"];
/// Keys that say nothing about what is below them.
const PLAIN: &[&str] = &[
    "annotations",
    "frames",
    "labels",
    "mask",
    "masklet",
    "masks",
    "objects",
    "results",
    "rle",
    "segmentation",
    "segmentations",
    "segments",
];

/// What is known of a mask from what stands above it.
#[derive(Clone, Copy, Default)]
struct Above<'v> {
    frame: Option<u64>,
    label: Option<Label<'v>>,
}

/// Whose mask it is.
#[derive(Clone, Copy)]
enum Label<'v> {
    Name(&'v str),
    Key(&'v str),
    Id(u64),
    /// Place in a list.
    Place(usize),
}

impl Label<'_> {
    /// The surer of two; of two alike the one nearer to the mask.
    fn surer(above: Option<Self>, nearer: Option<Self>) -> Option<Self> {
        let rank = |label: &Self| match label {
            Self::Name(_) => 0,
            Self::Key(_) => 1,
            Self::Id(_) => 2,
            Self::Place(_) => 3,
        };
        // The first of equals is taken.
        nearer.into_iter().chain(above).min_by_key(rank)
    }
}

struct Search<'v, 'e> {
    at: &'e str,
    expected: Expected,
    /// Names of categories by their numbers.
    categories: BTreeMap<u64, &'v str>,
    /// Frames of images by their numbers.
    images: BTreeMap<u64, u64>,
    frames: Vec<Layers>,
    /// Masks without a frame in a document for all frames.
    lost: bool,
}

pub(super) fn read(
    at: &str,
    bytes: &[u8],
    expected: Expected,
    budget: &mut Budget,
) -> Result<Vec<Layers>, Error> {
    budget.take(PARSED * bytes.len() as u64, at)?;
    let document: Value = json(bytes, at)?;
    let mut search = Search {
        at,
        expected,
        categories: BTreeMap::new(),
        images: BTreeMap::new(),
        frames: Vec::new(),
        lost: false,
    };
    search.tables(&document);
    match &document {
        // What a document says of itself is no name of its masks.
        Value::Object(map) if !map.contains_key("counts") => {
            search.entries(map, Above::default())?;
        }
        document => search.walk(document, Above::default())?,
    }
    if search.frames.is_empty() {
        let fault = if search.lost {
            "its masks do not say of which frame they are: number them with `frame_index`, or give a list of as many \
             as there are frames"
        } else {
            "it has no masks as run lengths of COCO, {\"size\": [rows, columns], \"counts\": ...}"
        };
        return Err(Error::Document { at: at.to_owned(), fault: fault.to_owned() });
    }
    Ok(search.frames)
}

impl<'v> Search<'v, '_> {
    /// Reads the tables of COCO that masks refer to.
    fn tables(&mut self, document: &'v Value) {
        let entries = |key: &str| document.get(key).and_then(Value::as_array).into_iter().flatten();
        for entry in entries("categories") {
            let (id, name) = (entry.get("id"), entry.get("name"));
            if let (Some(id), Some(name)) =
                (id.and_then(Value::as_u64), name.and_then(Value::as_str))
            {
                self.categories.insert(id, name);
            }
        }
        for entry in entries("images") {
            let Some(id) = entry.get("id").and_then(Value::as_u64) else { continue };
            let frame = entry.as_object().and_then(frame_of);
            if let Some(frame) = frame {
                self.images.insert(id, frame);
            }
        }
    }

    fn walk(&mut self, value: &'v Value, above: Above<'v>) -> Result<(), Error> {
        match value {
            Value::Object(map) => match (map.get("size"), map.get("counts")) {
                (Some(size), Some(counts)) => self.add(size, counts, above),
                _ => self.object(map, above),
            },
            Value::Array(list) => self.list(list, above, false),
            _ => Ok(()),
        }
    }

    fn object(&mut self, map: &'v Map<String, Value>, above: Above<'v>) -> Result<(), Error> {
        let mut own = above;
        let text = |key: &&str| map.get(*key).and_then(Value::as_str).filter(|t| !t.is_empty());
        let number = |key: &&str| map.get(*key).and_then(Value::as_u64);
        let category = number(&"category_id");
        let called = category.and_then(|id| self.categories.get(&id).copied());
        // In COCO's lists of images `id` is a number of the mask, and not of what it shows.
        let own_id = if map.contains_key("image_id") { category } else { number(&"id") };
        let label = NAMES.iter().find_map(text).or(called).map(Label::Name);
        let label = label
            .or_else(|| IDS.iter().find_map(text).map(Label::Key))
            .or_else(|| IDS.iter().find_map(number).or(own_id).map(Label::Id));
        own.label = Label::surer(above.label, label);
        if self.expected.whole && own.frame.is_none() {
            let image = number(&"image_id").and_then(|id| self.images.get(&id).copied());
            own.frame = image.or_else(|| frame_of(map));
        }
        self.entries(map, own)
    }

    /// Walks the values of an object, whose keys may be numbers of frames or of things.
    fn entries(&mut self, map: &'v Map<String, Value>, above: Above<'v>) -> Result<(), Error> {
        let frames = self.expected.frames;
        for (key, value) in map {
            let key = key.as_str();
            let whole = self.expected.whole && above.frame.is_none();
            // One thing in all frames, and not one frame with as many things as there are frames.
            let is_thing = value.as_array().is_some_and(|list| frames > 1 && list.len() == frames);
            let frame = key.parse().ok().or_else(|| of_image(key));
            match (frame, value) {
                (_, value) if !(value.is_object() || value.is_array()) => {}
                (Some(frame), _) if whole && !is_thing => {
                    self.walk(value, Above { frame: Some(frame), ..above })?;
                }
                (Some(number), _) => {
                    let label = Label::surer(above.label, Some(Label::Id(number)));
                    self.walk(value, Above { label, ..above })?;
                }
                (None, Value::Array(list)) => {
                    let of_frames = ["segmentations", "frames", "masklet"].contains(&key);
                    self.list(list, named(above, key, value), of_frames)?;
                }
                (None, _) => self.walk(value, named(above, key, value))?,
            }
        }
        Ok(())
    }

    fn list(&mut self, list: &'v [Value], above: Above<'v>, of_frames: bool) -> Result<(), Error> {
        let is_timed = |value: &Value| {
            let map = value.as_object();
            map.is_some_and(|m| frame_of(m).is_some() || m.contains_key("segmentations"))
        };
        let of_frames = self.expected.whole
            && above.frame.is_none()
            && (of_frames || list.len() == self.expected.frames)
            && !list.iter().any(is_timed);
        for (index, value) in list.iter().enumerate() {
            let below = if of_frames {
                Above { frame: Some(index as u64), ..above }
            } else {
                Above { label: above.label.or(Some(Label::Place(index))), ..above }
            };
            self.walk(value, below)?;
        }
        Ok(())
    }

    fn add(&mut self, size: &Value, counts: &Value, above: Above<'v>) -> Result<(), Error> {
        let damaged =
            |fault: &str| Error::Damaged { at: self.at.to_owned(), fault: fault.to_owned() };
        let side = |index: usize| size.get(index).and_then(Value::as_u64);
        let (Some(height), Some(width)) = (side(0), side(1)) else {
            return Err(damaged("the size of a mask in it is not [rows, columns]"));
        };
        let [width, height] = [width, height].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        same_size(self.at, [width, height], self.expected.size)?;
        let lengths = match counts {
            Value::String(text) => runs::of_text(text),
            Value::Array(list) => {
                let number = |n: &Value| n.as_u64().and_then(|n| u32::try_from(n).ok());
                list.iter().map(number).collect()
            }
            _ => None,
        };
        let total = |lengths: &[u32]| lengths.iter().map(|n| u64::from(*n)).sum::<u64>();
        let lengths = lengths.filter(|n| total(n) <= (width * height) as u64);
        let Some(lengths) = lengths else {
            return Err(damaged("the run lengths of a mask in it are not those of its size"));
        };
        let frame = if self.expected.whole { above.frame } else { Some(0) };
        let Some(frame) = frame else {
            self.lost = true;
            return Ok(());
        };
        let frame = usize::try_from(frame).unwrap_or(usize::MAX);
        if frame >= self.expected.frames {
            let fault = format!(
                "it has a mask of frame {frame}, but there are {} frames, from 0 on",
                self.expected.frames
            );
            return Err(Error::Document { at: self.at.to_owned(), fault });
        }
        self.frames.resize(self.frames.len().max(frame + 1), Layers::new());
        let layers = &mut self.frames[frame];
        at_most("masks of a camera", layers.len() + 1, MAX_PARTS)?;
        let label = match above.label {
            Some(Label::Name(text) | Label::Key(text)) => text.to_owned(),
            Some(Label::Id(id)) => id.to_string(),
            Some(Label::Place(place)) => place.to_string(),
            None => "1".to_owned(),
        };
        layers.push(Layer { label: Some(label), runs: Runs::Columns(lengths) });
        Ok(())
    }
}

/// What is above a value under a key, which names a mask or the masks of all frames right below it.
fn named<'v>(above: Above<'v>, key: &'v str, value: &Value) -> Above<'v> {
    let is_mask = |value: &Value| value.get("counts").is_some();
    let has_masks = is_mask(value) || value.as_array().is_some_and(|list| list.iter().any(is_mask));
    let own = (has_masks && !PLAIN.contains(&key)).then_some(Label::Key(key));
    Above { label: Label::surer(above.label, own), ..above }
}

/// Frame of an entry that says of which it is.
fn frame_of(map: &Map<String, Value>) -> Option<u64> {
    let image = || FILES.iter().find_map(|key| map.get(*key).and_then(Value::as_str));
    let number = FRAMES.iter().find_map(|key| map.get(*key).and_then(Value::as_u64));
    number.or_else(|| of_image(image()?))
}

/// Frame of an image by its name.
fn of_image(name: &str) -> Option<u64> {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let (stem, ending) = file.rsplit_once('.')?;
    let is_image = ["png", "jpg", "jpeg"].iter().any(|e| ending.eq_ignore_ascii_case(e));
    is_image.then(|| number(stem)).flatten()
}

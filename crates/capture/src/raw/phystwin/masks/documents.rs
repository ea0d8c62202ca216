//! Documents that say what labels of masks show: a label's name, by itself or in an entry of Grounded
//! SAM 2, or the labels of a name.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::{parts::CameraParts, place::Rig};
use crate::{
    Error,
    files::{Files, at_most},
    phystwin::json,
    raw::{Camera, stored::MAX_PARTS},
};

/// Folder in which Grounded SAM 2 names the labels of each frame.
pub(super) const FOLDER: &str = "json_data";
/// Names of documents beside masks, without their extension.
const NAMES: &[&str] = &["labels", "mask_info", "label_map", "classes"];
/// Keys of the name of a label, the first counts.
const TEXTS: &[&str] = &["class_name", "name", "label", "category", "class"];
/// Keys of the table in a document that has more.
const TABLES: &[&str] = &["labels", "classes", "objects"];

/// Names of labels.
#[derive(Default)]
pub(super) struct Names {
    /// The document; `None` if labels that are words are their own names.
    pub(super) document: Option<String>,
    by_label: BTreeMap<String, String>,
    /// Labels as the document has them.
    written: Vec<String>,
}

/// `true` if a file is a document and no mask, by its name.
pub(super) fn is_one(file: &str) -> bool {
    let Some((stem, ending)) = file.rsplit_once('.') else { return false };
    let stem = stem.to_ascii_lowercase();
    let is_named = NAMES.contains(&stem.as_str()) || stem.starts_with("mask_info");
    is_named && ending.eq_ignore_ascii_case("json")
}

/// Finds what names the labels of a camera.
pub(super) fn find(
    files: &mut Files<'_>,
    rig: &Rig,
    index: usize,
    camera: &Camera,
    parts: &CameraParts,
) -> Result<Names, Error> {
    let root = rig.folder();
    let places = rig.camera(index);
    let mut candidates = vec![
        format!("{root}mask_info_{index}.json"),
        format!("{root}mask_info_{}.json", camera.name),
    ];
    for folder in places.folders.iter().map(|folder| format!("{folder}/")) {
        candidates.push(format!("{folder}mask_info_{index}.json"));
        candidates.extend(NAMES.iter().map(|name| format!("{folder}{name}.json")));
        // Beside the masks in the folder of a camera.
        if let Some((own, _)) = folder.trim_end_matches('/').rsplit_once('/') {
            candidates.push(format!("{own}/mask_info.json"));
        }
    }
    candidates.extend(NAMES.iter().map(|name| format!("{root}{name}.json")));
    for at in candidates {
        // Names of cameras come from strangers.
        if !crate::files::is_plain(&at) {
            continue;
        }
        if let Some(bytes) = files.find_document(&at)? {
            let mut names = Names { document: Some(at.clone()), ..Names::default() };
            names.read(&at, &json(&bytes, &at)?)?;
            return Ok(names);
        }
    }
    let mut names = Names::default();
    if parts.parts.is_empty() {
        return Ok(names);
    }
    // Beside the masks, or beside their folder.
    for folder in &places.folders {
        let at = format!("{folder}/{FOLDER}");
        for file in files.list(&at).files {
            let at = format!("{at}/{file}");
            let document = match file.ends_with(".json") {
                true => files.find_document(&at)?,
                false => None,
            };
            if let Some(bytes) = document {
                names.read(&at, &json(&bytes, &at)?)?;
                names.document = Some(format!("{folder}/{FOLDER}"));
            }
        }
    }
    Ok(names)
}

impl Names {
    /// The name of a label. A word is its own name, unless there is a document without it.
    pub(super) fn of<'n>(&'n self, label: &'n str) -> Option<&'n str> {
        let known = self.by_label.get(&key(label)).map(String::as_str);
        let is_word = !label.starts_with('#') && !label.bytes().all(|b| b.is_ascii_digit());
        let is_name = || self.by_label.values().any(|name| name == label);
        known.or_else(|| (is_word && (self.document.is_none() || is_name())).then_some(label))
    }

    /// Labels with their names that are not among these.
    pub(super) fn absent(&self, labels: &[String]) -> Vec<String> {
        let there: Vec<String> = labels.iter().map(|label| key(label)).collect();
        let is_there = |label: &str| {
            let label = key(label);
            let name = self.by_label.get(&label).map(|name| key(name));
            there.contains(&label) || name.is_some_and(|name| there.contains(&name))
        };
        let absent = self.written.iter().filter(|label| !is_there(label));
        absent.map(|label| format!("{label} ({})", self.by_label[&key(label)])).collect()
    }

    fn read(&mut self, at: &str, document: &Value) -> Result<(), Error> {
        let fault = |fault: String| Error::Document { at: at.to_owned(), fault };
        let table = TABLES.iter().find_map(|key| document.get(key)).filter(|t| !t.is_string());
        match table.unwrap_or(document) {
            Value::Object(map) => {
                for (label, value) in map {
                    self.entry(label, value).map_err(fault)?;
                }
            }
            Value::Array(list) => {
                for value in list {
                    let entry = value.as_object().and_then(numbered);
                    let (label, name) = entry.ok_or_else(|| {
                        fault("an entry of it is not {\"id\": 1, \"name\": \"object\"}".to_owned())
                    })?;
                    self.add(&label, name);
                }
            }
            _ => return Err(fault("it is not {\"1\": \"object\", \"2\": \"hand\"}".to_owned())),
        }
        at_most("masks of a camera", self.by_label.len(), MAX_PARTS)
    }

    /// `"1": "object"`, `"1": {"class_name": "object"}`, `"object": 1` or `"object": [1, 3]`.
    fn entry(&mut self, label: &str, value: &Value) -> Result<(), String> {
        let numbers = |list: &[Value]| list.iter().map(Value::as_u64).collect::<Option<Vec<_>>>();
        match value {
            Value::String(name) => self.add(label, name),
            Value::Number(number) if number.is_u64() => self.add(&number.to_string(), label),
            Value::Array(list) if numbers(list).is_some() => {
                for number in numbers(list).unwrap_or_default() {
                    self.add(&number.to_string(), label);
                }
            }
            Value::Object(map) => match text(map) {
                Some(name) => self.add(label, name),
                None => return Err(format!("`{label}` has no `class_name` or `name`")),
            },
            _ => return Err(format!("`{label}` is no name of what a label shows")),
        }
        if label.is_empty() || label.contains(['/', '\\']) || label.starts_with('.') {
            return Err(format!("`{label}` is no label of masks"));
        }
        Ok(())
    }

    fn add(&mut self, label: &str, name: &str) {
        if self.by_label.insert(key(label), name.to_owned()).is_none() {
            self.written.push(label.to_owned());
        }
    }
}

fn text(map: &Map<String, Value>) -> Option<&str> {
    TEXTS.iter().find_map(|key| map.get(*key).and_then(Value::as_str))
}

fn numbered(map: &Map<String, Value>) -> Option<(String, &str)> {
    let id = ["id", "instance_id", "obj_id"].iter().find_map(|key| map.get(*key)?.as_u64())?;
    Some((id.to_string(), text(map)?))
}

/// A label without zeros before its number.
fn key(label: &str) -> String {
    let is_number = !label.is_empty() && label.bytes().all(|b| b.is_ascii_digit());
    match label.trim_start_matches('0') {
        _ if !is_number => label.to_ascii_lowercase(),
        "" => "0".to_owned(),
        number => number.to_owned(),
    }
}

//! Labels of masks: which of them is the object, and which is what moves it. Segmenters are asked in
//! words, and the words come along.

use std::collections::BTreeSet;

use bendtwin_core::Finding;

use super::MARKER;
use crate::{Error, raw::Region};

/// Words for what moves an object.
const MANIPULATORS: &[&str] = &[
    "arm",
    "arms",
    "allegro",
    "controller",
    "controllers",
    "effector",
    "emika",
    "finger",
    "fingers",
    "fingertip",
    "fingertips",
    "forearm",
    "franka",
    "glove",
    "gloves",
    "gripper",
    "grippers",
    "hand",
    "hands",
    "human",
    "humans",
    "kinova",
    "kuka",
    "man",
    "manipulator",
    "manipulators",
    "palm",
    "panda",
    "people",
    "person",
    "persons",
    "pliers",
    "robot",
    "robots",
    "robotiq",
    "sawyer",
    "thumb",
    "tongs",
    "tweezers",
    "ur",
    "woman",
    "wrist",
    "xarm",
    "yumi",
];

/// Words for soft objects: beside one of the above they leave open what a label names.
const OBJECTS: &[&str] = &[
    "animal", "bag", "ball", "bear", "belt", "blanket", "cable", "cloth", "cotton", "cushion",
    "doll", "dough", "fabric", "foam", "jacket", "object", "package", "paper", "pillow", "plush",
    "plushie", "puppet", "rope", "scarf", "shirt", "shoe", "sock", "sponge", "string", "stuffed",
    "teddy", "towel", "toy", "wire",
];

/// Words after which a label may end without changing what it names.
const QUALIFIERS: &[&str] = &[
    "a", "b", "base", "e", "end", "gen", "l", "left", "link", "lower", "mask", "one", "r", "right",
    "tip", "tips", "two", "upper",
];

/// Key of the description that says which labels are the object.
pub(super) const KEY: &str = "object_labels";

/// Kind of thing that a label names by its words alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// Any unknown word: the object that a twin is wanted of.
    Object,
    Manipulator,
    Unclear,
}

/// Labels of a recording, sorted into regions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Labels {
    object: BTreeSet<String>,
    manipulator: BTreeSet<String>,
}

impl Labels {
    /// Sorts the labels of all cameras; `chosen` are those that the description declares to be the
    /// object.
    pub(super) fn sort(all: &BTreeSet<String>, chosen: &[String]) -> Result<Self, Error> {
        if !chosen.is_empty() {
            return Self::sort_by(all, chosen);
        }
        let mut labels = Self::default();
        let mut unclear = Vec::new();
        for label in all {
            match meaning(label) {
                Meaning::Object => labels.object.insert(label.clone()),
                Meaning::Manipulator => labels.manipulator.insert(label.clone()),
                Meaning::Unclear => {
                    unclear.push(label);
                    false
                }
            };
        }
        if let Some(label) = unclear.first() {
            let fault = format!("`{label}` may be the object or what moves it");
            return Err(refused(all, &fault));
        }
        if labels.object.is_empty() && !all.is_empty() {
            return Err(refused(
                all,
                "all of them name a hand, a person or a robot, and none the object",
            ));
        }
        if labels.manipulator.is_empty() && all.len() > 1 {
            return Err(refused(all, "none of them is known as a hand, a person or a robot"));
        }
        Ok(labels)
    }

    fn sort_by(all: &BTreeSet<String>, chosen: &[String]) -> Result<Self, Error> {
        let chosen: BTreeSet<String> = chosen.iter().map(|label| folded(label)).collect();
        let known: BTreeSet<String> = all.iter().map(|label| folded(label)).collect();
        if let Some(label) = chosen.difference(&known).next().filter(|_| !all.is_empty()) {
            let fault = format!("`{KEY}` names `{label}`, which is not one of them");
            return Err(refused(all, &fault));
        }
        let (object, manipulator) =
            all.iter().cloned().partition(|label| chosen.contains(&folded(label)));
        Ok(Self { object, manipulator })
    }

    /// Region of a label.
    pub(super) fn region(&self, label: &str) -> Region {
        if self.object.contains(label) { Region::Object } else { Region::Manipulator }
    }

    /// The finding that lists how labels were understood.
    pub(super) fn note(&self) -> Option<Finding> {
        if self.object.is_empty() {
            return None;
        }
        let manipulator = match quoted(&self.manipulator).as_str() {
            "" => "no mask shows what moves it".to_owned(),
            names => format!("what moves it is {names}"),
        };
        let message = format!(
            "by the labels of the masks the object is {}, and {manipulator}",
            quoted(&self.object)
        );
        let advice = format!("if it is otherwise, name the object's labels in `{KEY}` of {MARKER}");
        Some(Finding { advice, ..Finding::info("MASK_LABELS", message) })
    }
}

/// The error that names all labels and the setting that decides.
fn refused(all: &BTreeSet<String>, fault: &str) -> Error {
    Error::MaskLabels(format!(
        "the masks are labelled {}; {fault}: label them `object` and `hand`, or add the object's labels to {MARKER}, as \
         in \"{KEY}\": [\"{}\"]; all others are then what moves it (docs/use/cameras.md#masks)",
        quoted(all),
        all.first().map_or("", String::as_str),
    ))
}

fn quoted(labels: &BTreeSet<String>) -> String {
    let most = labels.iter().take(8).map(|label| format!("`{label}`")).collect::<Vec<_>>();
    most.join(", ")
}

fn folded(label: &str) -> String {
    label.trim().to_lowercase()
}

/// True if a label names a hand, a person or a robot, and nothing else.
pub(crate) fn names_manipulator(label: &str) -> bool {
    meaning(label) == Meaning::Manipulator
}

/// Kind of thing that a label names, by whole words: that of `left_hand`, `gripper 2` or `UR5` is clear, that of
/// `hand towel` or `toy robot` is not.
fn meaning(label: &str) -> Meaning {
    let lower = folded(label);
    let words: Vec<&str> =
        lower.split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty()).collect();
    let is_manipulator = |word: &&str| MANIPULATORS.contains(word);
    if !words.iter().any(is_manipulator) {
        return Meaning::Object;
    }
    let last = words.iter().rev().find(|word| !QUALIFIERS.contains(*word));
    let names_object = words.iter().any(|word| OBJECTS.contains(word));
    if last.is_some_and(is_manipulator) && !names_object {
        Meaning::Manipulator
    } else {
        Meaning::Unclear
    }
}

#[cfg(test)]
mod tests;

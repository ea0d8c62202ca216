//! Names of markers: which are the object's, and which those of what moves it.

use std::collections::{BTreeMap, BTreeSet};

use bendtwin_core::Finding;

use super::{Description, Mark};
use crate::{Error, raw::names_manipulator};

/// Words for things of the room, whose markers move nothing.
const ROOM: &[&str] =
    &["board", "camera", "cameras", "floor", "ground", "origin", "table", "tripod", "wand", "wall"];

/// Part that a marker has in a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A point of the object.
    Object,
    /// A point of the object that a control point holds.
    Held,
    /// A control point.
    Hand,
    /// No part, for a reason.
    None(&'static str),
}

/// Marks by every name that a description may give them: in full, without the body's name, or the
/// body's name, which means all of them.
#[derive(Debug)]
pub(super) struct Index(BTreeMap<String, Vec<usize>>);

impl Index {
    pub(super) fn of(marks: &[Mark]) -> Self {
        let mut index: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (number, mark) in marks.iter().enumerate() {
            let names = BTreeSet::from([mark.full(), mark.label.clone(), mark.set.clone()]);
            for name in names.into_iter().filter(|name| !name.is_empty()) {
                index.entry(name).or_default().push(number);
            }
        }
        Self(index)
    }

    /// The marks of a name.
    pub(super) fn find(&self, name: &str) -> &[usize] {
        self.0.get(name).map_or(&[], Vec::as_slice)
    }
}

/// The roles of marks, shape of `marks`: as declared, else by their names.
pub(super) fn roles(marks: &[Mark], description: &Description) -> Result<Vec<Role>, Error> {
    let index = Index::of(marks);
    let declared = |labels: &[String]| -> Result<BTreeSet<usize>, Error> {
        let labels: BTreeSet<&String> = labels.iter().collect();
        let mut found = BTreeSet::new();
        for label in labels {
            let own = index.find(label);
            if own.is_empty() {
                let fault = format!("it names the marker `{label}`, which the file does not have");
                let at = "the description of the markers".to_owned();
                return Err(Error::Document { at, fault });
            }
            found.extend(own);
        }
        Ok(found)
    };
    let held = declared(&description.held)?;
    let hand = declared(&description.hand)?;
    declared(&description.edges.concat())?;
    let role = |(number, mark): (usize, &Mark)| {
        if held.contains(&number) {
            Role::Held
        } else if hand.contains(&number) {
            Role::Hand
        } else if is_unlabelled(mark) {
            Role::None("it has no label: label markers in the program that recorded them")
        } else if words(&mark.set).any(|word| ROOM.contains(&word.as_str())) {
            Role::None("it belongs to the room by its name")
        } else if hand.is_empty() && moves_it(mark) {
            Role::Hand
        } else if mark.is_rigid {
            Role::None("it belongs to a rigid body that is not declared as `hand`")
        } else {
            Role::Object
        }
    };
    Ok(marks.iter().enumerate().map(role).collect())
}

/// A soft object is no rigid body, so that a rigid body moves it. Other markers do if their set, or without
/// one they themselves, are called after a hand, a gripper or a robot.
fn moves_it(mark: &Mark) -> bool {
    let name = if mark.set.is_empty() { &mark.label } else { &mark.set };
    mark.is_rigid || names_manipulator(&spaced(name))
}

/// Names that programs give to markers that nobody labelled.
fn is_unlabelled(mark: &Mark) -> bool {
    let label = mark.full().to_lowercase();
    label.starts_with("unlabeled")
        || label.starts_with("unlabelled")
        || label.starts_with('*')
        || label.starts_with("uname")
}

fn words(name: &str) -> impl Iterator<Item = String> {
    let spaced = spaced(name).to_lowercase();
    spaced.split(|c: char| !c.is_alphabetic()).map(str::to_owned).collect::<Vec<_>>().into_iter()
}

/// A name whose words are apart and end without a number or a single letter: `LeftHand_M3` is
/// `Left Hand`.
fn spaced(name: &str) -> String {
    let mut spaced = String::new();
    let mut before = ' ';
    let mut rest = name.chars().peekable();
    while let Some(c) = rest.next() {
        if !c.is_alphabetic() {
            spaced.push(' ');
        } else {
            // `LeftHand`, and `LHand`.
            let begins =
                before.is_lowercase() || rest.peek().is_some_and(|next| next.is_lowercase());
            if c.is_uppercase() && begins {
                spaced.push(' ');
            }
            spaced.push(c);
        }
        before = c;
    }
    let is_number_of = |word: &&str| {
        word.chars().count() > 1
            && !["marker", "markers", "mkr", "point"].contains(&word.to_lowercase().as_str())
    };
    spaced.split_whitespace().filter(is_number_of).collect::<Vec<_>>().join(" ")
}

/// The finding about a capture in which nothing moves the object.
pub(super) fn nothing_moves_it(document: &str) -> Finding {
    let message = "no marker is named after a hand, a gripper or a robot, and none belongs to a rigid body: nothing but \
                   gravity would move the twin";
    let advice = format!(
        "name in {document}, beside the file, the markers that a hand holds, as in {{\"held\": [\"M00\", \"M12\"]}}, or those \
         on the hand itself under \"hand\" (docs/use/cameras.md#grippers)"
    );
    let finding = Finding { advice, ..Finding::warning("HELD_MARKERS_UNKNOWN", message) };
    finding.explains("NO_CONTROLS")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn role(label: &str) -> Role {
        roles(&[Mark::labelled(label)], &Description::default()).unwrap()[0]
    }

    #[test]
    fn names_tell_hands_from_objects() {
        for label in
            ["hand:M1", "LeftHand:2", "gripper_3", "Franka Hand:Marker 4", "RFinger1", "robot:a"]
        {
            assert_eq!(role(label), Role::Hand, "{label}");
        }
        for label in ["rope:M00", "cloth_12", "hand towel:M1", "M1", "handle:3", "toy robot:2"] {
            assert_eq!(role(label), Role::Object, "{label}");
        }
        for label in ["Unlabeled 1234", "*17", "table:M2", "Calibration Wand:1"] {
            assert!(matches!(role(label), Role::None(_)), "{label}");
        }
    }

    #[test]
    fn a_description_decides() {
        let marks = ["rope:M0", "rope:M1", "tool:M0"].map(Mark::labelled);
        let described = Description {
            held: vec!["rope:M0".to_owned()],
            hand: vec!["tool".to_owned()],
            ..Description::default()
        };
        let found = roles(&marks, &described).unwrap();
        assert_eq!(found, [Role::Held, Role::Object, Role::Hand]);
        let wrong = Description { held: vec!["M9".to_owned()], ..Description::default() };
        assert!(roles(&marks, &wrong).unwrap_err().to_string().contains("M9"));
    }
}

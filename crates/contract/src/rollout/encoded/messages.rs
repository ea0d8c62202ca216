//! The messages that have tensors in them, by the descriptors that are compiled in: fields of others
//! take about as much memory decoded as encoded.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::LazyLock,
};

use bendtwin_proto::DESCRIPTORS;
use prost::Message as _;
use prost_types::{DescriptorProto, FileDescriptorSet};

/// Fields that are counted, and tensors whose first number of a shape is that of instances.
const COUNTED: [(&str, &str, Counted); 8] = [
    ("RollOutRequest", "costs", Counted::Costs),
    ("RollOutRequest", "grasps", Counted::Grasps),
    ("OpenSessionRequest", "grasps", Counted::Grasps),
    ("World", "colliders", Counted::Colliders),
    ("ControlTrajectories", "positions", Counted::Instances),
    ("GripperPoses", "poses", Counted::Instances),
    ("RenderSessionRequest", "cameras", Counted::Cameras),
    ("RenderSessionRequest", "props", Counted::Props),
];
/// The package of the messages.
const PACKAGE: &str = ".bendtwin.v1.";
const TENSOR: &str = "Tensor";
const SHAPE: &str = "shape";

/// Quantity that a field counts toward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counted {
    /// Costs, one by one.
    Costs,
    /// Grasps, one by one.
    Grasps,
    /// Colliders, one by one.
    Colliders,
    /// Cameras of pictures, one by one.
    Cameras,
    /// Props of pictures, one by one.
    Props,
    /// Instances, which the tensor has as rows.
    Instances,
}

/// A field of a message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) counted: Option<Counted>,
    /// Number of the message that it is, if that has tensors in it or is one.
    pub(super) below: Option<usize>,
}

/// A message with tensors in it, or a tensor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Message {
    /// Fields by number; those without tensors and counts are left out.
    pub(super) fields: BTreeMap<u32, Field>,
    /// Number of the field with the shape, of a tensor.
    pub(super) shape: Option<u32>,
}

/// All messages with tensors in them.
pub(super) struct Messages {
    all: Vec<Message>,
    numbers: BTreeMap<String, usize>,
    other: Message,
}

/// The messages of this build.
pub(super) static MESSAGES: LazyLock<Messages> = LazyLock::new(|| {
    let files = FileDescriptorSet::decode(DESCRIPTORS).expect("descriptors are compiled in");
    let mut found = BTreeMap::new();
    for file in &files.file {
        file.message_type
            .iter()
            .for_each(|m| collect(&format!(".{}", file.package()), m, &mut found));
    }
    Messages::new(&found)
});

/// Adds a message and those that are declared inside it.
fn collect<'d>(
    outer: &str,
    message: &'d DescriptorProto,
    found: &mut BTreeMap<String, &'d DescriptorProto>,
) {
    let name = format!("{outer}.{}", message.name());
    message.nested_type.iter().for_each(|inner| collect(&name, inner, found));
    found.insert(name, message);
}

impl Messages {
    fn new(found: &BTreeMap<String, &DescriptorProto>) -> Self {
        let mut with_tensors = BTreeSet::from([format!("{PACKAGE}{TENSOR}")]);
        // As often as messages are inside one another, until nothing is added.
        loop {
            let more = found.iter().filter(|(name, message)| {
                let has = message.field.iter().any(|f| with_tensors.contains(f.type_name()));
                has && !with_tensors.contains(*name)
            });
            let more: Vec<String> = more.map(|(name, _)| name.clone()).collect();
            if more.is_empty() {
                break;
            }
            with_tensors.extend(more);
        }
        let numbers: BTreeMap<String, usize> = with_tensors.into_iter().zip(0..).collect();
        let all = numbers.keys().map(|name| {
            let own = name.strip_prefix(PACKAGE).unwrap_or_default();
            let fields =
                found.get(name).map(|message| message.field.as_slice()).unwrap_or_default();
            let number = |f: &prost_types::FieldDescriptorProto| u32::try_from(f.number()).ok();
            let shape = fields.iter().find(|f| own == TENSOR && f.name() == SHAPE);
            let fields = fields.iter().filter_map(|field| {
                let of = |(message, name, _): &&(&str, &str, Counted)| {
                    *message == own && *name == field.name()
                };
                let counted = COUNTED.iter().find(of).map(|(_, _, counted)| *counted);
                let below = numbers.get(field.type_name()).copied();
                let kept = counted.is_some() || below.is_some();
                kept.then(|| Some((number(field)?, Field { counted, below }))).flatten()
            });
            Message { fields: fields.collect(), shape: shape.and_then(number) }
        });
        Self { all: all.collect(), other: Message::default(), numbers }
    }

    /// A message of this name; one without tensors in it has no fields.
    pub(super) fn named(&self, name: &str) -> &Message {
        let number = self.numbers.get(&format!("{PACKAGE}{name}"));
        number.map_or(&self.other, |number| self.numbered(*number))
    }

    /// A message that a field is.
    pub(super) fn numbered(&self, number: usize) -> &Message {
        self.all.get(number).unwrap_or(&self.other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names that are counted are those of the contract, and nothing is inside itself.
    #[test]
    fn counted_fields_are_there_and_messages_end() {
        for (message, field, counted) in COUNTED {
            let found = MESSAGES.named(message).fields.values().any(|f| f.counted == Some(counted));
            assert!(found, "{message}.{field}");
        }
        assert_eq!(MESSAGES.named(TENSOR).shape, Some(2));
        fn depth(of: &Message, above: usize) -> usize {
            assert!(
                above < 20,
                "a message that is inside itself is not looked at before it is decoded"
            );
            let below = of.fields.values().filter_map(|f| f.below);
            below.map(|n| depth(MESSAGES.numbered(n), above + 1)).max().unwrap_or(above)
        }
        assert!(depth(MESSAGES.named("StepSessionRequest"), 0) > 4);
    }
}

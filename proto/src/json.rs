//! Requests and replies as JSON, with the fields of the messages, by their names in the .proto files. The
//! fields of a message are generated from its descriptor and from the options of `options.proto`; by
//! hand are tensors, times, nested documents and the words of enums. An unknown field is refused, a
//! field that is null or left out has its default.

mod document;
mod fields;
mod pairs;
mod tensor;
mod time;

use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{MapAccess, Visitor},
    ser::SerializeMap,
};

use self::{
    document::{document, write_document},
    fields::{
        Words, filled, message, messages, only_one, word, write_message, write_messages, write_word,
    },
    tensor::{tensor, write_tensor},
    time::{Time, time},
};
use crate::v1::tensor::Dtype;

pub use self::{
    fields::Fields,
    pairs::{from_pairs, from_query},
    tensor::TensorFormat,
    time::timestamp,
};

/// A message read from JSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Read<T>(pub T);

/// A message to be written as JSON.
#[derive(Clone, Copy, Debug)]
pub struct Write<'m, T> {
    /// The message.
    pub message: &'m T,
    /// Form of its tensors.
    pub tensors: TensorFormat,
}

impl<'de, T: Fields> Deserialize<'de> for Read<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MessageVisitor(std::marker::PhantomData)).map(Self)
    }
}

impl<T: Fields> Serialize for Write<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        self.message.write(self.tensors, &mut map)?;
        map.end()
    }
}

struct MessageVisitor<T>(std::marker::PhantomData<T>);

impl<'de, T: Fields> Visitor<'de> for MessageVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "an object with fields of {}", T::NAME)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        fields::read(map)
    }
}

/// Lets values that contain a message be written, with tensors as lists.
macro_rules! written {
    ($message:ty) => {
        impl Serialize for $message {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Write { message: self, tensors: TensorFormat::Lists }.serialize(serializer)
            }
        }
    };
}

/// Lets values that contain an enum be written.
macro_rules! word_written {
    ($words:ty) => {
        impl Serialize for $words {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.as_str_name())
            }
        }
    };
}

#[allow(clippy::all)]
mod generated {
    use super::*;

    include!("generated/json.rs");
}

#[cfg(test)]
mod tests;

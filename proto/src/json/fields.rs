//! Fields of messages: by name, each at most once, with the path of a fault.

use std::marker::PhantomData;

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeSeed, Error, MapAccess, SeqAccess, Visitor},
    ser::SerializeMap,
};

use super::{Read, TensorFormat, Write};

/// Longest list of messages. Three bytes of text become a message of two hundred bytes, so the
/// length of the text is no bound of their memory.
pub(super) const MOST_MESSAGES: usize = 65_536;

/// A message whose fields are known. Implementations are generated.
pub trait Fields: Default {
    /// Name of the message.
    const NAME: &'static str;
    /// Names of its fields.
    const FIELDS: &'static [&'static str];
    /// Names of those that must be given.
    const REQUIRED: &'static [&'static str];

    /// Reads the value of a field, by its place in [`Fields::FIELDS`].
    ///
    /// # Errors
    /// If the value is none of the field's.
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error>;

    /// Writes all fields but messages and tensors that are not there.
    ///
    /// # Errors
    /// If the writer fails, or a tensor's shape and bytes disagree.
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error>;
}

/// An enum whose values are words. Implementations are generated.
pub(super) trait Words {
    /// Words that may be given.
    const KNOWN: &'static [&'static str];

    /// Number of a word.
    fn number(word: &str) -> Option<i32>;

    /// Word of a number.
    fn word(number: i32) -> Option<&'static str>;
}

/// Reads a message.
pub(super) fn read<'de, T: Fields, A: MapAccess<'de>>(mut map: A) -> Result<T, A::Error> {
    let mut message = T::default();
    let mut seen = vec![false; T::FIELDS.len()];
    while let Some(field) = map.next_key_seed(Name::<T>(PhantomData))? {
        let name = T::FIELDS[field];
        if std::mem::replace(&mut seen[field], true) {
            return Err(at(name, A::Error::custom("is given twice")));
        }
        message.read(field, &mut map).map_err(|error| at(name, error))?;
    }
    let mut absent = T::FIELDS.iter().zip(seen).filter(|(_, seen)| !seen).map(|(name, _)| name);
    match absent.find(|name| T::REQUIRED.contains(name)) {
        Some(name) => Err(at(name, A::Error::custom("is missing"))),
        None => Ok(message),
    }
}

/// A fault with the path of the field where it is. The innermost path comes first, in backquotes.
pub(super) fn at<E: Error>(step: &str, error: E) -> E {
    let text = error.to_string();
    E::custom(match text.strip_prefix('`') {
        Some(rest) if rest.starts_with('[') => format!("`{step}{rest}"),
        Some(rest) => format!("`{step}.{rest}"),
        None => format!("`{step}` {text}"),
    })
}

/// The place of a field's name.
struct Name<T>(PhantomData<T>);

impl<'de, T: Fields> DeserializeSeed<'de> for Name<T> {
    type Value = usize;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<T: Fields> Visitor<'_> for Name<T> {
    type Value = usize;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the name of a field of {}", T::NAME)
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<usize, E> {
        T::FIELDS.iter().position(|field| *field == name).ok_or_else(|| {
            let known = T::FIELDS.join(", ");
            E::custom(format!("has the unknown field {name:?}: {} has {known}", T::NAME))
        })
    }
}

/// A message, if one is given.
pub(super) fn message<'de, T: Fields, A: MapAccess<'de>>(
    map: &mut A,
) -> Result<Option<T>, A::Error> {
    Ok(map.next_value::<Option<Read<T>>>()?.map(|Read(message)| message))
}

/// A list of messages.
pub(super) fn messages<'de, T: Fields, A: MapAccess<'de>>(map: &mut A) -> Result<Vec<T>, A::Error> {
    Ok(map.next_value::<Option<List<T>>>()?.map(|List(messages)| messages).unwrap_or_default())
}

/// Sets the one member of a group of which no second may be given.
pub(super) fn only_one<T, E: Error>(group: &mut Option<T>, member: Option<T>) -> Result<(), E> {
    if group.is_some() && member.is_some() {
        return Err(E::custom("is given beside a field that excludes it: give one of the two"));
    }
    if member.is_some() {
        *group = member;
    }
    Ok(())
}

/// The number of a word; 0 if none is given.
pub(super) fn word<'de, W: Words, A: MapAccess<'de>>(map: &mut A) -> Result<i32, A::Error> {
    let Some(word) = map.next_value::<Option<String>>()? else { return Ok(0) };
    W::number(&word).ok_or_else(|| {
        A::Error::custom(format!("has the unknown value {word:?}: use {}", W::KNOWN.join(" or ")))
    })
}

/// A value, unless it is that of a field that was left out.
pub(super) fn filled<T: Default + PartialEq>(value: &T) -> Option<&T> {
    (*value != T::default()).then_some(value)
}

pub(super) fn write_message<M: SerializeMap, T: Fields>(
    map: &mut M,
    name: &'static str,
    message: Option<&T>,
    tensors: TensorFormat,
) -> Result<(), M::Error> {
    match message {
        Some(message) => map.serialize_entry(name, &Write { message, tensors }),
        None => Ok(()),
    }
}

pub(super) fn write_messages<M: SerializeMap, T: Fields>(
    map: &mut M,
    name: &'static str,
    messages: &[T],
    tensors: TensorFormat,
) -> Result<(), M::Error> {
    let list: Vec<_> = messages.iter().map(|message| Write { message, tensors }).collect();
    map.serialize_entry(name, &list)
}

/// Writes a word, or the number of one that this build does not know.
pub(super) fn write_word<W: Words, M: SerializeMap>(
    map: &mut M,
    name: &'static str,
    number: i32,
) -> Result<(), M::Error> {
    match W::word(number) {
        Some(word) => map.serialize_entry(name, word),
        None => map.serialize_entry(name, &number),
    }
}

/// A list of messages, whose faults name the place in it.
struct List<T>(Vec<T>);

impl<'de, T: Fields> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(ListVisitor(PhantomData)).map(Self)
    }
}

struct ListVisitor<T>(PhantomData<T>);

impl<'de, T: Fields> Visitor<'de> for ListVisitor<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a list of {}", T::NAME)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<T>, A::Error> {
        let mut messages = Vec::new();
        loop {
            let place = format!("[{}]", messages.len());
            match seq.next_element::<Read<T>>().map_err(|error| at(&place, error))? {
                Some(_) if messages.len() == MOST_MESSAGES => {
                    let fault = format!("has more than {MOST_MESSAGES} entries");
                    return Err(A::Error::custom(fault));
                }
                Some(Read(message)) => messages.push(message),
                None => return Ok(messages),
            }
        }
    }
}

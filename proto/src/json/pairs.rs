//! Messages from pairs of names and texts: queries, and the metadata of uploads. The text of a document
//! or of a message within is JSON.

use serde::{
    Deserialize, Deserializer,
    de::{Error as _, IntoDeserializer, Visitor, value::MapDeserializer},
};
use serde_json::Error;

use super::{Read, document, fields::Fields};

/// Reads a message from pairs. A field with an empty text counts as absent.
///
/// # Errors
/// If a name is unknown or given twice, or a text is no value of its field.
pub fn from_pairs<M: Fields>(
    pairs: impl IntoIterator<Item = (String, String)>,
) -> Result<M, Error> {
    let texts = pairs.into_iter().map(|(name, text)| (name, Text(text)));
    let map = MapDeserializer::new(texts);
    Read::deserialize(map).map(|Read(message)| message)
}

/// Reads a message from the query of a request.
///
/// # Errors
/// As [`from_pairs`].
pub fn from_query<M: Fields>(query: &str) -> Result<M, Error> {
    from_pairs(form_urlencoded::parse(query.as_bytes()).into_owned())
}

/// A value as text.
struct Text(String);

impl<'de> IntoDeserializer<'de, Error> for Text {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

/// Numbers and truth values from their text.
macro_rules! parsed {
    ($($method:ident $visit:ident $kind:ty,)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.$visit(self.0.parse::<$kind>().map_err(Error::custom)?)
        }
    )*};
}

impl<'de> Deserializer<'de> for Text {
    type Error = Error;

    parsed! {
        deserialize_bool visit_bool bool,
        deserialize_i32 visit_i32 i32,
        deserialize_i64 visit_i64 i64,
        deserialize_u32 visit_u32 u32,
        deserialize_u64 visit_u64 u64,
        deserialize_f32 visit_f32 f32,
        deserialize_f64 visit_f64 f64,
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_string(self.0)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        if self.0.is_empty() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let mut json = serde_json::Deserializer::from_reader(self.0.as_bytes());
        let value = json.deserialize_map(visitor)?;
        json.end()?;
        Ok(value)
    }

    /// Documents stay text: the use case validates them.
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        match name {
            document::NAME => visitor.visit_str(&self.0),
            _ => visitor.visit_newtype_struct(self),
        }
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i128 u8 u16 u128 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct struct enum identifier ignored_any
    }
}

//! Strings of a message that are JSON documents, such as settings: nested documents in JSON.

use std::fmt;

use serde::{
    Deserialize, Deserializer,
    de::{Error, MapAccess, Visitor},
    ser::SerializeMap,
};
use serde_json::value::RawValue;

/// Name by which a format that has documents as texts knows one.
pub(super) const NAME: &str = "Document";

/// A document as text.
struct Document(String);

impl<'de> Deserialize<'de> for Document {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_newtype_struct(NAME, DocumentVisitor)
    }
}

struct DocumentVisitor;

impl<'de> Visitor<'de> for DocumentVisitor {
    type Value = Document;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a document")
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, json: D) -> Result<Document, D::Error> {
        Box::<RawValue>::deserialize(json).map(|json| Document(json.get().to_owned()))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Document, E> {
        Ok(Document(text.to_owned()))
    }
}

/// A document as text; empty if none is given.
pub(super) fn document<'de, A: MapAccess<'de>>(map: &mut A) -> Result<String, A::Error> {
    let document = map.next_value::<Option<Document>>()?;
    Ok(document.map(|Document(text)| text).unwrap_or_default())
}

/// Writes a document that is given as text; null if the text is no JSON.
pub(super) fn write_document<M: SerializeMap>(
    map: &mut M,
    name: &'static str,
    text: &str,
) -> Result<(), M::Error> {
    let document = RawValue::from_string(text.to_owned()).ok();
    map.serialize_entry(name, &document)
}

//! Strings of a message that are JSON documents, such as settings: nested documents in JSON.

use serde::{de::MapAccess, ser::SerializeMap};
use serde_json::value::RawValue;

/// A document as text; empty if none is given.
pub(super) fn document<'de, A: MapAccess<'de>>(map: &mut A) -> Result<String, A::Error> {
    let document = map.next_value::<Option<Box<RawValue>>>()?;
    Ok(document.map(|document| document.get().to_owned()).unwrap_or_default())
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

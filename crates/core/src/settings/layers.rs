//! Settings in layers: documents that change only what they name, one over another.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::FitSettings;

/// Fields that are one value although they look like objects: one of several variants.
const VARIANTS: [&str; 2] = ["substeps", "refine.window"];

/// Merges a document's fields into settings; other fields keep their values.
pub fn merge(into: &mut Value, from: Value) {
    match (into, from) {
        // An enum with one variant as its only key ({"fixed": 100}) is replaced, not mixed.
        (Value::Object(into), Value::Object(from))
            if from.keys().all(|k| into.contains_key(k)) || into.len() != 1 =>
        {
            for (key, value) in from {
                merge(into.entry(key).or_insert(Value::Null), value);
            }
        }
        (into, from) => *into = from,
    }
}

/// Most faults reported for a document.
const MOST_FAULTS: usize = 20;

/// Settings of a document.
///
/// # Errors
/// Every field that is unknown or has a value of another type, each with its dotted path.
pub fn read<T: DeserializeOwned>(document: Value) -> Result<T, Vec<String>> {
    // Serde takes a list for a struct, field by field.
    if !document.is_object() {
        return Err(vec!["they are not a JSON object".to_owned()]);
    }
    serde_json::from_value(document.clone()).map_err(|whole| {
        // Serde stops at the first fault: fields are read one by one to find the others.
        let mut faults = Vec::new();
        alone(&mut Vec::new(), &document, &mut |path, field| {
            if faults.len() < MOST_FAULTS
                && let Err(error) = serde_json::from_value::<T>(field)
            {
                faults.push(format!("{path}: {}", plain(&error.to_string())));
            }
        });
        if faults.is_empty() {
            faults.push(plain(&whole.to_string()));
        }
        faults
    })
}

/// Calls `read` with every leaf of a document and its dotted path, in a document that has nothing
/// else.
fn alone<'a>(keys: &mut Vec<&'a str>, value: &'a Value, read: &mut dyn FnMut(&str, Value)) {
    let path = keys.join(".");
    match value {
        Value::Object(fields) if !fields.is_empty() && !VARIANTS.contains(&path.as_str()) => {
            for (key, value) in fields {
                keys.push(key);
                alone(keys, value, read);
                keys.pop();
            }
        }
        leaf => {
            let nest = |inner, key: &&str| Value::Object(Map::from_iter([((*key).into(), inner)]));
            read(&path, keys.iter().rev().fold(leaf.clone(), nest));
        }
    }
}

/// Serde's message without the names of Rust's types.
fn plain(message: &str) -> String {
    let Some((found, expected)) = message.rsplit_once("expected ") else {
        return message.to_owned();
    };
    let expected = match expected {
        "usize" | "u8" | "u16" | "u32" | "u64" => "a whole number, 0 or more",
        "isize" | "i8" | "i16" | "i32" | "i64" => "a whole number",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        other if other.starts_with("struct ") => "an object",
        other => other,
    };
    format!("{found}expected {expected}")
}

/// All fields that a document names and settings do not have, as dotted paths.
pub fn unknown_fields(document: &Value) -> Vec<String> {
    let mut found = Vec::new();
    compare(&mut String::new(), document, &defaults(), &mut |path, known, _| {
        if !known {
            found.push(path.to_owned());
        }
    });
    found
}

/// The differences of settings from the defaults, as dotted paths with their values: applied to the
/// defaults, they give the same settings again.
pub fn changes(settings: &FitSettings) -> Vec<(String, Value)> {
    let document = serde_json::to_value(settings).unwrap_or_default();
    let mut found = Vec::new();
    compare(&mut String::new(), &document, &defaults(), &mut |path, _, value| {
        found.push((path.to_owned(), value.clone()));
    });
    found
}

fn defaults() -> Value {
    serde_json::to_value(FitSettings::default()).unwrap_or_default()
}

/// Reports every leaf that is other than the default, and whether its field is known.
fn compare(
    path: &mut String,
    value: &Value,
    default: &Value,
    report: &mut dyn FnMut(&str, bool, &Value),
) {
    match (value, default) {
        (Value::Object(fields), Value::Object(known)) if !VARIANTS.contains(&path.as_str()) => {
            for (key, value) in fields {
                let length = path.len();
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(key);
                match known.get(key) {
                    Some(default) => compare(path, value, default, report),
                    None => report(path, false, value),
                }
                path.truncate(length);
            }
        }
        _ if value != default => report(path, true, value),
        _ => {}
    }
}

#[cfg(test)]
mod tests;

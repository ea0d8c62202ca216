//! Settings in layers: documents that change only what they name, one over another.

use serde_json::Value;

use super::FitSettings;

/// Fields that are one value although they look like objects: one of several variants.
const VARIANTS: [&str; 2] = ["substeps", "refine.window"];

/// Takes over the fields of a document; other fields stay as they are.
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

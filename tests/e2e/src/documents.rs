//! Documents that describe the code say what the code says.

use std::collections::BTreeMap;

use bendtwin_core::FitSettings;
use serde_json::Value;

use crate::workspace;

/// Rows of docs/settings.md whose field has no default.
const ALTERNATIVES: [&str; 1] = ["substeps.fixed"];

fn document(name: &str) -> String {
    std::fs::read_to_string(workspace::root().join("docs").join(name)).unwrap()
}

#[test]
fn every_setting_is_documented_with_its_default() {
    let mut in_code = BTreeMap::new();
    flatten("", &serde_json::to_value(FitSettings::default()).unwrap(), &mut in_code);
    let mut documented = BTreeMap::new();
    for line in document("settings.md").lines() {
        let cells: Vec<_> = line.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        if let ["", field, default, ..] = cells[..]
            && line.starts_with("| `")
            && !ALTERNATIVES.contains(&field)
        {
            let value = serde_json::from_str::<Value>(default);
            documented.insert(field.to_owned(), value.unwrap_or_else(|e| panic!("{field}: {e}")));
        }
    }
    assert_eq!(documented, in_code);
}

#[test]
fn the_example_settings_are_valid() {
    let text = document("settings.md");
    let example = text.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let settings: FitSettings = serde_json::from_str(example).unwrap();
    assert_eq!(settings.validate(), Ok(()));
    let published = FitSettings::phystwin();
    assert_eq!((settings.bending, settings.substeps), (published.bending, published.substeps));
    assert_eq!(settings.refine, published.refine);
}

/// JSON as dotted paths.
fn flatten(path: &str, value: &Value, found: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(&format!("{path}{dot}{name}"), value, found);
            }
        }
        _ => {
            found.insert(path.to_owned(), value.clone());
        }
    }
}

//! Settings of fits as lines: which were given, and which differ.

use bendtwin_core::FitSettings;
use serde_json::Value;

use crate::table::Table;

/// Settings by their dotted names, in their order.
pub(super) fn flat(settings: &Value) -> Vec<(String, Value)> {
    let mut all = Vec::new();
    collect("", settings, &mut all);
    all
}

fn collect(path: &str, value: &Value, all: &mut Vec<(String, Value)>) {
    match value {
        Value::Object(fields) if !fields.is_empty() => {
            for (name, value) in fields {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                collect(&path, value, all);
            }
        }
        value => all.push((path.to_owned(), value.clone())),
    }
}

/// A value for people; one that is left open follows the effort and the capture.
pub(super) fn word(value: Option<&Value>) -> String {
    match value {
        None => String::new(),
        Some(Value::Null) => "open".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(value) => value.to_string(),
    }
}

/// The value of a setting among others.
pub(super) fn value<'s>(settings: &'s [(String, Value)], name: &str) -> Option<&'s Value> {
    settings.iter().find(|(other, _)| other == name).map(|(_, value)| value)
}

/// All settings of a fit, with the changed ones marked; for settings left open the chosen value, if
/// there is a twin that records it.
pub(super) fn table(settings: &Value, in_force: Option<&Value>) -> String {
    let in_force = in_force.map(flat).unwrap_or_default();
    let defaults = serde_json::to_value(FitSettings::default()).map(|v| flat(&v));
    let defaults = defaults.unwrap_or_default();
    let mut table = Table::new(["", "SETTING", "VALUE"]);
    for (name, own) in flat(settings) {
        let given = value(&defaults, &name) != Some(&own);
        let mark = if given { "*" } else { "" };
        let chosen = value(&in_force, &name).filter(|v| own.is_null() && !v.is_null());
        let shown = match chosen {
            Some(_) => format!("{} (chosen)", word(chosen)),
            None => word(Some(&own)),
        };
        table.row([mark.to_owned(), name, shown]);
    }
    table.text()
}

#[cfg(test)]
mod tests {
    use bendtwin_core::{
        capture::Subject,
        settings::{Conditions, DeviceKind},
    };

    use super::*;

    #[test]
    fn settings_that_were_given_are_marked() {
        let mut settings = FitSettings { seed: 7, ..FitSettings::default() };
        settings.graph.max_nodes = Some(40);
        let text = table(&serde_json::to_value(&settings).unwrap(), None);
        let marked: Vec<_> = text.lines().filter(|line| line.starts_with('*')).collect();
        assert_eq!(marked.len(), 2, "{text}");
        assert!(marked[0].contains("graph.max_nodes") && marked[0].ends_with("40"), "{text}");
        assert!(marked[1].contains("seed") && marked[1].ends_with('7'), "{text}");
        let plain = table(&serde_json::to_value(FitSettings::default()).unwrap(), None);
        assert!(!plain.contains('*') && plain.contains("open"), "{plain}");
    }

    #[test]
    fn what_was_left_open_shows_what_was_chosen() {
        let conditions = Conditions {
            subject: Subject::Body,
            device: DeviceKind::Cpu,
            sequences: 1,
            is_weighed: false,
        };
        let given = FitSettings::default();
        let [given, chosen] =
            [given.clone(), given.filled(conditions)].map(|s| serde_json::to_value(s).unwrap());
        let text = table(&given, Some(&chosen));
        let line = text.lines().find(|line| line.contains("graph.max_nodes")).unwrap();
        assert!(line.ends_with("200 (chosen)") && !text.contains('*'), "{text}");
        let line = text.lines().find(|line| line.contains("graph.control_neighbours")).unwrap();
        assert!(!line.contains("chosen"), "{line}");
    }
}

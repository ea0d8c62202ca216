//! The evidence of lifting: its counts, as tables. Every field present is shown; nothing is
//! required.

use serde_json::{Map, Value};

use super::markup::escape;

/// Most entries of a table, and depth of names within names.
const MAX_ROWS: usize = 60;
const MAX_DEPTH: usize = 3;

pub(super) fn section(evidence: Option<&Value>) -> String {
    let Some(Value::Object(evidence)) = evidence else { return String::new() };
    let parts: String = evidence
        .iter()
        .filter(|(name, _)| *name != "findings")
        .map(|(name, value)| format!("<h3>{}</h3>\n{}", escape(&words(name)), table(value)))
        .collect();
    if parts.is_empty() {
        return String::new();
    }
    format!("<section>\n<h2>How points were lifted</h2>\n{parts}</section>\n")
}

/// `off_mask` as people write it.
fn words(name: &str) -> String {
    super::capitalised(&name.replace('_', " "))
}

fn table(value: &Value) -> String {
    let rows: Vec<&Map<String, Value>> = match value {
        Value::Object(one) => vec![one],
        Value::Array(many) => many.iter().take(MAX_ROWS).filter_map(Value::as_object).collect(),
        _ => Vec::new(),
    };
    if rows.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<(String, String)>> =
        rows.into_iter().map(|row| flat(row, MAX_DEPTH)).collect();
    // Figures run down and the described things across, which stays narrow.
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in rows.iter().flatten() {
        if !names.contains(&name.as_str()) && names.len() < MAX_ROWS {
            names.push(name);
        }
    }
    let lines: String = names
        .iter()
        .map(|name| {
            let cells: String = rows
                .iter()
                .map(|row| {
                    let value = row.iter().find(|(n, _)| n == name).map_or("", |(_, v)| v);
                    format!("<td>{}</td>", escape(value))
                })
                .collect();
            format!("<tr><th scope=\"row\">{}</th>{cells}</tr>\n", escape(name))
        })
        .collect();
    format!(
        "<div class=\"wide\"><table class=\"evidence\"><tbody>\n{lines}</tbody></table></div>\n"
    )
}

fn flat(row: &Map<String, Value>, depth: usize) -> Vec<(String, String)> {
    let mut cells = Vec::new();
    for (name, value) in row {
        match value {
            Value::Object(inner) if depth > 0 => {
                let inner = flat(inner, depth - 1).into_iter();
                cells.extend(
                    inner.map(|(n, v)| (format!("{}: {}", words(name), n.to_lowercase()), v)),
                );
            }
            Value::Array(list) => {
                // Of lists over frames, the ends are shown.
                let ends = [list.first(), list.last()].map(|v| v.map(shown).unwrap_or_default());
                if !list.is_empty() && !list.iter().any(Value::is_object) {
                    cells.push((words(name), format!("{} ... {}", ends[0], ends[1])));
                }
            }
            Value::Number(n) if name.ends_with("_m") => {
                // Lengths are read in millimetres, and their name says so.
                let mm = n.as_f64().map(|m| format!("{:.2} mm", 1e3 * m));
                cells.push((words(name.trim_end_matches("_m")), mm.unwrap_or_default()));
            }
            other => cells.push((words(name), shown(other))),
        }
    }
    cells
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(n) => match n.as_f64() {
            Some(x) if x.fract() != 0.0 => format!("{x:.3}"),
            _ => n.to_string(),
        },
        other => other.to_string(),
    }
}

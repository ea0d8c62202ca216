//! YAML through the events of `saphyr-parser`. Aliases are refused: a few lines of them unfold to
//! gigabytes.

use saphyr_parser::{Event, Parser};

use super::value::{MAX_DEPTH, MAX_VALUES, Value};

enum Open {
    List(Vec<Value>),
    Map(Vec<(String, Value)>, Option<String>),
}

pub(super) fn parse(text: &str) -> Result<Value, String> {
    // OpenCV's first line, `%YAML:1.0`, is no YAML.
    let body: String = text
        .trim_start_matches('\u{feff}')
        .lines()
        .map(|line| if line.starts_with("%YAML:") { "" } else { line })
        .flat_map(|line| [line, "\n"])
        .collect();
    let mut open: Vec<Open> = Vec::new();
    let mut root = None;
    let mut count = 0;
    for event in Parser::new_from_str(&body) {
        let (event, span) = event.map_err(|error| format!("it is no YAML: {error}"))?;
        count += 1;
        if count > MAX_VALUES {
            return Err(format!("it has more than {MAX_VALUES} values"));
        }
        let done = match event {
            Event::Alias(_) => {
                return Err(format!("line {} has an alias, which is not read", span.start.line()));
            }
            Event::Scalar(text, ..) => Some(Value::Text(text.into_owned())),
            Event::SequenceStart(..) => {
                open.push(Open::List(Vec::new()));
                None
            }
            Event::MappingStart(..) => {
                open.push(Open::Map(Vec::new(), None));
                None
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(Open::List(list)) => Some(Value::List(list)),
                Some(Open::Map(entries, _)) => Some(Value::Map(entries)),
                None => None,
            },
            Event::DocumentEnd => break,
            _ => None,
        };
        if open.len() > MAX_DEPTH {
            return Err(format!("it is nested deeper than {MAX_DEPTH}"));
        }
        let Some(value) = done else { continue };
        match open.last_mut() {
            Some(Open::List(list)) => list.push(value),
            Some(Open::Map(entries, key)) => match key.take() {
                Some(name) => entries.push((name, value)),
                None => {
                    let Value::Text(name) = value else {
                        return Err(format!(
                            "line {} has a key that is no text",
                            span.start.line()
                        ));
                    };
                    *key = Some(name);
                }
            },
            None => root = Some(value),
        }
    }
    root.ok_or_else(|| "it is empty".to_owned())
}

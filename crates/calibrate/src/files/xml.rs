//! OpenCV's file storage as XML: elements are keys, elements called `_` the items of a list.

use quick_xml::{Reader, events::Event};

use super::value::{MAX_DEPTH, MAX_VALUES, Value};

#[derive(Default)]
struct Element {
    name: String,
    text: String,
    children: Vec<(String, Value)>,
}

pub(super) fn parse(text: &str) -> Result<Value, String> {
    let mut reader = Reader::from_str(text);
    let mut open = vec![Element::default()];
    let mut count = 0;
    loop {
        let event = reader.read_event().map_err(|error| format!("it is no XML: {error}"))?;
        count += 1;
        if count > MAX_VALUES {
            return Err(format!("it has more than {MAX_VALUES} elements"));
        }
        if open.len() > MAX_DEPTH {
            return Err(format!("it is nested deeper than {MAX_DEPTH}"));
        }
        match event {
            Event::Start(start) => {
                let name = String::from_utf8_lossy(start.name().as_ref()).into_owned();
                open.push(Element { name, ..Element::default() });
            }
            Event::Empty(start) => {
                let name = String::from_utf8_lossy(start.name().as_ref()).into_owned();
                if let Some(parent) = open.last_mut() {
                    parent.children.push((name, Value::Text(String::new())));
                }
            }
            Event::Text(part) => {
                let part = part.decode().map_err(|error| format!("it is no XML: {error}"))?;
                if let Some(element) = open.last_mut() {
                    element.text.push_str(&part);
                }
            }
            Event::End(_) => {
                let Some(element) = open.pop() else { break };
                let name = element.name.clone();
                match open.last_mut() {
                    Some(parent) => parent.children.push((name, element.value())),
                    None => {
                        return Err("it is no XML: an element ends that did not begin".to_owned());
                    }
                }
            }
            Event::Eof => break,
            Event::DocType(_) => return Err("it has a document type, which is not read".to_owned()),
            _ => {}
        }
    }
    // The root is an element without a name around `opencv_storage`.
    let root = open.into_iter().next().unwrap_or_default();
    match root.children.into_iter().next() {
        Some((_, value)) => Ok(value),
        None => Err("it is empty".to_owned()),
    }
}

impl Element {
    fn value(self) -> Value {
        if self.children.is_empty() {
            return Value::Text(self.text.trim().trim_matches('"').to_owned());
        }
        if self.children.iter().all(|(name, _)| name == "_") {
            return Value::List(self.children.into_iter().map(|(_, value)| value).collect());
        }
        Value::Map(self.children)
    }
}

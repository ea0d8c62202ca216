//! Numbers and names as attributes of XML.

use std::fmt::{Display, Write as _};

/// Numbers with spaces between them.
pub(super) fn numbers<T: Display>(values: &[T]) -> String {
    let mut text = String::new();
    for (i, value) in values.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}{value}", if i > 0 { " " } else { "" });
    }
    text
}

/// A name; what XML would read as its own is left out.
pub(super) fn escaped(name: &str) -> String {
    name.chars().filter(|c| !c.is_control() && !matches!(c, '"' | '<' | '>' | '&')).collect()
}

//! Text that is safe in a page. Names come from files, so everything is escaped.

/// A text as content or as the value of a quoted attribute.
pub(super) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // Control characters are not allowed in a page.
            c if c.is_control() && !c.is_whitespace() => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// Millimetres, or a dash.
pub(super) fn mm(value: Option<f64>) -> String {
    value.map_or("&ndash;".to_owned(), |v| format!("{v:.1} mm"))
}

/// Milliseconds, or a dash.
pub(super) fn ms(value: Option<f64>) -> String {
    value.map_or("&ndash;".to_owned(), |v| {
        if v.abs() < 0.5 { "0 ms".to_owned() } else { format!("{v:+.0} ms") }
    })
}

/// A share in percent, or a dash.
pub(super) fn percent(value: Option<f64>) -> String {
    value.map_or("&ndash;".to_owned(), |v| format!("{:.0} %", 100.0 * v))
}

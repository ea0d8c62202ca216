//! What was taken as what, as a list that can be opened.

use super::markup::escape;
use crate::Inspection;

pub(super) fn section(seen: &Inspection) -> String {
    if seen.sources.is_empty() {
        return String::new();
    }
    let lines = seen.sources.lines().map(|line| format!("<li>{}</li>\n", escape(&line)));
    format!(
        "<section>\n<h2>What was read</h2>\n<ul class=\"sources\">\n{}</ul>\n</section>\n",
        lines.collect::<String>()
    )
}

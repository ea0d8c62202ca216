//! The pictures, each as a data URI.

use base64::{Engine as _, engine::general_purpose::STANDARD};

use super::markup::escape;
use crate::{
    Inspection,
    draw::{self, Figure},
};

pub(super) fn section(seen: &Inspection) -> String {
    let inputs = &seen.picture_inputs;
    let mut parts = String::new();
    let mut add = |title: &str, class: &str, figures: Vec<Figure>| {
        if !figures.is_empty() {
            let figures: String = figures.iter().map(|p| figure(title, p)).collect();
            parts.push_str(&format!(
                "<h3>{title}</h3>\n<div class=\"plates {class}\">\n{figures}</div>\n"
            ));
        }
    };
    // A picture that cannot be drawn is no reason to have no report.
    add(
        "Observed points over time",
        "one",
        draw::seen(inputs).ok().flatten().into_iter().collect(),
    );
    add(
        "Lifted points over time",
        "one",
        draw::lifted(inputs).ok().flatten().into_iter().collect(),
    );
    add("The graph over the first image", "few", draw::graph(inputs).unwrap_or_default());
    add("Agreement between cameras", "few", draw::agreement(inputs).unwrap_or_default());
    add("Depth over the object", "few", draw::coverage(inputs).unwrap_or_default());
    if parts.is_empty() {
        return String::new();
    }
    format!("<section>\n<h2>Pictures</h2>\n{parts}</section>\n")
}

fn figure(title: &str, figure: &Figure) -> String {
    format!(
        "<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
        escape(title),
        STANDARD.encode(&figure.png),
        escape(&figure.caption)
    )
}

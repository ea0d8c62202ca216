//! The findings, a card each.

use bendtwin_core::Severity;

use super::{capitalised, markup::escape};
use crate::Inspection;

pub(super) fn section(seen: &Inspection) -> String {
    if seen.findings.is_empty() {
        return String::new();
    }
    let cards: String = seen.findings.iter().map(|f| {
        let class = match f.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        };
        let frames = match f.frames.as_slice() {
            [] => String::new(),
            frames => {
                let list: Vec<String> = frames.iter().map(usize::to_string).collect();
                let more = if frames.len() == 20 { ", ..." } else { "" };
                let s = if frames.len() == 1 { "" } else { "s" };
                format!("<p class=\"frames\">Frame{s} {}{more}</p>", list.join(", "))
            }
        };
        let follows = match f.consequences.as_slice() {
            [] => String::new(),
            codes => {
                let list: Vec<String> =
                    codes.iter().map(|c| format!("<code>{}</code>", escape(c))).collect();
                format!("<p class=\"frames\">It also explains {}.</p>", list.join(", "))
            }
        };
        let advice = match f.advice.as_str() {
            "" => String::new(),
            advice => format!("<p class=\"advice\">{}.</p>", escape(&capitalised(advice))),
        };
        format!(
            "<li class=\"{class}\"><p class=\"message\">{}.</p>{advice}{frames}{follows}<p class=\"code\">{class} <code>{}</code></p></li>\n",
            escape(&capitalised(&f.message)),
            escape(&f.code)
        )
    }).collect();
    format!(
        "<section>\n<h2>What was found</h2>\n<ul class=\"findings\">\n{cards}</ul>\n</section>\n"
    )
}

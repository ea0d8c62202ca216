//! The report of a capture: a document for programs and a page for people.

use std::io;

use bendtwin_capture::{Finding, Severity};
use bendtwin_core::Fault;
use bendtwin_ingest::Evidence;
use serde::{Deserialize, Serialize};

/// What to make of a capture, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing holds a fit back.
    Good,
    /// It can be fitted; warnings say what holds it back.
    Usable,
    /// It cannot be fitted as it is.
    Unusable,
}

impl Verdict {
    /// The word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Usable => "usable",
            Self::Unusable => "unusable",
        }
    }

    fn sentence(self) -> &'static str {
        match self {
            Self::Good => "This capture is fit for fitting.",
            Self::Usable => "This capture can be fitted; the warnings say what holds it back.",
            Self::Unusable => "This capture cannot be fitted as it is.",
        }
    }
}

/// What is to be said of a capture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// What people call the capture.
    pub name: String,
    /// What to make of it.
    pub verdict: Verdict,
    /// What was found, the worst first.
    pub findings: Vec<Finding>,
    /// How its points came about, if it was recorded raw.
    pub evidence: Option<Evidence>,
}

impl Report {
    /// Of a capture of which nothing else is known.
    pub fn of_fault(name: &str, fault: &Fault) -> Self {
        let finding = Finding {
            severity: Severity::Error,
            code: fault.reason.clone(),
            message: fault.message.clone(),
        };
        let verdict = Verdict::Unusable;
        Self { name: name.to_owned(), verdict, findings: vec![finding], evidence: None }
    }

    /// As a document.
    ///
    /// # Errors
    /// If a number cannot be written.
    pub fn json(&self) -> io::Result<Vec<u8>> {
        Ok(serde_json::to_vec_pretty(self)?)
    }

    /// As a page: one file, no scripts, nothing from elsewhere.
    pub fn html(&self) -> String {
        let rows = self.findings.iter().map(|finding| {
            let severity = match finding.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Info => "info",
            };
            let (code, message) = (escaped(&finding.code), escaped(&finding.message));
            format!("<tr class=\"{severity}\"><td>{severity}<td>{message}<td><code>{code}</code>\n")
        });
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{name}</title>\n\
             <style>{STYLE}</style>\n<h1>{name}</h1>\n<p class=\"{word}\">{sentence}</p>\n\
             <table>\n{rows}</table>\n</html>\n",
            name = escaped(&self.name),
            word = self.verdict.as_str(),
            sentence = self.verdict.sentence(),
            rows = rows.collect::<String>(),
        )
    }
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}\
                     table{border-collapse:collapse}td{padding:.3rem .8rem;border-top:1px solid #ccc;vertical-align:top}\
                     p{font-size:1.2rem}.unusable,.error td:first-child{color:#a00}\
                     .usable,.warning td:first-child{color:#850}.good{color:#070}";

/// Text that a page shows as it is.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '&' => safe.push_str("&amp;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use bendtwin_core::Category;

    use super::*;

    #[test]
    fn a_page_shows_what_a_file_says_and_does_nothing_of_it() {
        let fault = Fault {
            category: Category::InvalidArgument,
            reason: "X".to_owned(),
            message: "`<script>alert(1)</script>` & \"so\" on".to_owned(),
        };
        let report = Report::of_fault("<b>rope</b>", &fault);
        let page = report.html();
        assert!(!page.contains("<script") && !page.contains("<b>"), "{page}");
        assert!(page.contains("&lt;script&gt;alert(1)") && page.contains("&amp; &quot;so&quot;"));
        let read: Report = serde_json::from_slice(&report.json().unwrap()).unwrap();
        assert_eq!(read, report);
    }
}

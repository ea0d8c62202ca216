//! The capture report: a document for programs and a page for people.

use bendtwin_capture::check;
use bendtwin_core::{Capture, Severity};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{Error, Finding, Inspection, observed, page};

/// Name of the format.
pub const FORMAT: &str = bendtwin_core::capture_files::REPORT_FORMAT;
/// Version of the report's format.
pub const VERSION: u32 = 1;

/// The result of lifting a recording.
#[derive(Clone, Debug)]
pub struct Lifted {
    /// The points.
    pub capture: Capture,
    /// The evidence of lifting: any JSON; `findings`, `tracks` and `cameras` of it are
    /// shown on the page.
    pub evidence: Option<Value>,
}

/// The report of one capture.
#[derive(Clone, Debug)]
pub struct Report {
    inspection: Inspection,
    evidence: Option<Value>,
}

/// Document to be written.
#[derive(Serialize)]
struct WrittenDocument<'a> {
    format: &'static str,
    version: u32,
    first_step: Option<String>,
    #[serde(flatten)]
    inspection: &'a Inspection,
    evidence: &'a Option<Value>,
}

/// Document that was read.
#[derive(Deserialize)]
struct ReadDocument {
    format: String,
    version: u32,
    #[serde(flatten)]
    inspection: Inspection,
    evidence: Option<Value>,
}

impl Report {
    /// A report of an inspection, and of what was lifted from the recording if it was: its points
    /// are checked too, and the page shows them and the graph that they give.
    pub fn new(mut inspection: Inspection, lifted: Option<Lifted>) -> Self {
        let mut evidence = None;
        if let Some(lifted) = lifted {
            let checked = check(&lifted.capture).findings;
            let found = lifted.evidence.as_ref().and_then(|e| e.get("findings"));
            let found = found.and_then(|f| Vec::<Finding>::deserialize(f).ok());
            let found = found.unwrap_or_default();
            inspection.add(checked.into_iter().chain(found));
            inspection.observed = observed::observed(&lifted.capture);
            if observed::is_whole(&lifted.capture) {
                inspection.picture_inputs.capture = Some(lifted.capture);
            }
            evidence = lifted.evidence;
        }
        Self { inspection, evidence }
    }

    /// Adds the findings about another recording of the same object, under its name.
    pub fn add_recording(&mut self, name: &str, other: &Self) {
        let named = |f: &Finding| Finding {
            message: format!("recording `{name}`: {}", f.message),
            cameras: Vec::new(),
            frames: Vec::new(),
            ..f.clone()
        };
        self.inspection.sources.extend(other.inspection.sources.clone());
        self.inspection.add_unrelated(other.inspection.findings.iter().map(named));
    }

    /// The measurements and findings.
    pub fn inspection(&self) -> &Inspection {
        &self.inspection
    }

    /// The evidence of lifting, if points were lifted.
    pub fn evidence(&self) -> Option<&Value> {
        self.evidence.as_ref()
    }

    /// The first thing to do, in one sentence, if anything has to be done.
    pub fn first_step(&self) -> Option<String> {
        self.inspection.first_step().map(Finding::sentence)
    }

    /// The document; `docs/use/captures.md` specifies it.
    pub fn to_json(&self) -> String {
        let written = WrittenDocument {
            format: FORMAT,
            version: VERSION,
            first_step: self.first_step(),
            inspection: &self.inspection,
            evidence: &self.evidence,
        };
        // Strings, numbers and lists can always be written; numbers that are not finite become
        // null.
        serde_json::to_string_pretty(&written).unwrap_or_else(|_| "{}".to_owned())
    }

    /// Reads a document. Pictures are not part of it.
    ///
    /// # Errors
    /// If it is not a report, or one of a newer version.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let read: ReadDocument =
            serde_json::from_str(text).map_err(|e| Error::Document(e.to_string()))?;
        if read.format != FORMAT || read.version != VERSION {
            return Err(Error::Document(format!(
                "it is `{}` version {}, this build reads `{FORMAT}` version {VERSION}",
                read.format, read.version
            )));
        }
        Ok(Self { inspection: read.inspection, evidence: read.evidence })
    }

    /// The page: one file, without scripts, that needs nothing else. A picture that cannot be drawn
    /// is left out.
    pub fn to_html(&self) -> String {
        page::page(self)
    }

    /// Number of findings of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.inspection.findings.iter().filter(|f| f.severity == severity).count()
    }
}

#[cfg(test)]
mod tests;

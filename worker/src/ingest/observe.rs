//! What an ingest does with a capture of any kind: read it, lift it if it is raw, check it.

use std::path::Path;

use bendtwin_capture::{self as capture, CheckReport, Finding, Limits, Opened, Severity};
use bendtwin_core::{Capture, Fault, Problem, settings::ingest::IngestSettings};
use bendtwin_ingest::{CancelToken, Error, Evidence, Observer};

use super::report::{Report, Verdict};

/// A capture as it is fitted, and what is to be said of it.
#[derive(Clone, Debug)]
pub struct Observed {
    /// What is fitted, or why nothing can be.
    pub capture: Result<Capture, Fault>,
    /// What is to be said of it in either case.
    pub report: Report,
}

/// Reads the capture at a path, from a checkpoint of the same ingest if there is one.
///
/// # Errors
/// What says nothing about the capture: that the observer or `cancel` asked to stop.
pub fn observe(
    path: &Path,
    name: &str,
    settings: &IngestSettings,
    limits: &Limits,
    checkpoint: Option<&[u8]>,
    observer: &mut dyn Observer,
    cancel: &CancelToken,
) -> Result<Observed, Fault> {
    let opened = match capture::open(path, limits) {
        Ok(opened) => opened,
        Err(error) => return Ok(refused(name, &called(error, name))),
    };
    match opened {
        Opened::Observed(capture, notes) => Ok(checked(name, capture, notes, None)),
        Opened::Raw(recording) => {
            let mut lifted =
                bendtwin_ingest::ingest(&recording, settings, checkpoint, observer, cancel);
            if let Err(error @ (Error::Checkpoint(_) | Error::OtherCheckpoint)) = &lifted {
                // From a build before an update, say: the work is lost, the job is not.
                tracing::warn!("starting the ingest anew: {error}");
                lifted = bendtwin_ingest::ingest(&recording, settings, None, observer, cancel);
            }
            match lifted {
                Ok(observation) => {
                    let evidence = observation.evidence;
                    let findings = evidence.findings.clone();
                    Ok(checked(name, observation.capture, findings, Some(evidence)))
                }
                Err(error @ (Error::Observer(_) | Error::Cancelled)) => Err(error.fault()),
                Err(error) => Ok(refused(name, &error)),
            }
        }
    }
}

/// A capture whose numbers are judged.
fn checked(
    name: &str,
    capture: Capture,
    noticed: Vec<Finding>,
    evidence: Option<Evidence>,
) -> Observed {
    let mut check = capture::check(&capture);
    check.findings.extend(noticed);
    check.findings.sort_by_key(|f| f.severity);
    let usable = check.require();
    Observed {
        report: Report {
            name: name.to_owned(),
            verdict: verdict(&check),
            findings: check.findings,
            evidence,
        },
        capture: usable.map(|()| capture).map_err(|e| e.fault()),
    }
}

/// A capture that cannot be read.
fn refused(name: &str, error: &impl Problem) -> Observed {
    let fault = error.fault();
    Observed { report: Report::of_fault(name, &fault), capture: Err(fault) }
}

fn verdict(check: &CheckReport) -> Verdict {
    if !check.is_usable() {
        Verdict::Unusable
    } else if check.of(Severity::Warning).next().is_some() {
        Verdict::Usable
    } else {
        Verdict::Good
    }
}

/// Errors call the capture by its name: its path here is a temporary file's, which tells nobody anything.
fn called(error: capture::Error, name: &str) -> capture::Error {
    use capture::Error::{RawOnly, UnknownKind};
    match error {
        UnknownKind(_) => UnknownKind(name.to_owned()),
        RawOnly(_) => RawOnly(name.to_owned()),
        other => other,
    }
}

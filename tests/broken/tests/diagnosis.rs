//! Every broken recording gets its diagnosis, a healthy one gets none, and none costs more than 1
//! GB.

use bendtwin_broken::{Expected, Sample, all, archives, files, footage};
use bendtwin_capture::{Limits, raw};
use bendtwin_core::{CancelToken, Fault, Problem, Severity};
use bendtwin_inspect::{Inspection, Verdict, inspect};

const MAX_BYTES: u64 = 1_000_000_000;

/// The report, or the reason for which there is none.
fn diagnose(sample: &Sample) -> Result<Inspection, Fault> {
    let recording = match sample {
        Sample::Opened(recording) => recording.as_ref().clone(),
        Sample::Stored(_, path) => raw::open(path, &Limits::default()).map_err(|e| e.fault())?,
    };
    inspect(&recording, &CancelToken::default(), &mut |_| {}).map_err(|e| e.fault())
}

/// Differences from the expected diagnosis.
fn complaint(expected: Expected, found: Result<Inspection, Fault>) -> Option<String> {
    let codes = |report: &Inspection| -> Vec<String> {
        let sentence = |f: &bendtwin_core::Finding| format!("{} ({})", f.code, f.sentence());
        report.findings.iter().map(sentence).collect()
    };
    let is_right = match (&expected, &found) {
        (Expected::Refused(reason), Err(found)) => found.reason == *reason,
        (Expected::Damaged(reason), Ok(report)) => {
            let first = report.findings.first();
            first.is_some_and(|f| f.code == "FRAMES_DAMAGED" && f.message.contains(reason))
        }
        (Expected::Found(code), Ok(report)) => {
            report.findings.first().is_some_and(|f| f.code == *code && f.severity != Severity::Info)
        }
        (Expected::Sound(code), Ok(report)) => report.verdict == Verdict::Good && report.has(code),
        (Expected::Noticed(code), Ok(report)) => report.has(code),
        _ => false,
    };
    (!is_right).then(|| match found {
        Err(fault) => format!("expected {expected:?}, refused: {} ({fault})", fault.reason),
        Ok(report) => format!("expected {expected:?}, found {:#?}", codes(&report)),
    })
}

#[test]
fn each_gets_its_diagnosis_and_none_costs_a_gigabyte() {
    let broken = all();
    assert!(broken.len() >= 60, "{}", broken.len());
    let mut names: Vec<&str> = broken.iter().map(|b| b.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), broken.len(), "names repeat");
    let mut wrong = Vec::new();
    for broken in &broken {
        if let Some(complaint) = complaint(broken.expected, diagnose(&broken.make())) {
            wrong.push(format!("{}: {complaint}", broken.name));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), broken.len(), wrong.join("\n"));
    if let Some(peak) = peak_bytes() {
        assert!(peak < MAX_BYTES, "{peak} bytes at the peak");
    }
}

#[test]
fn the_healthy_recording_is_healthy_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, files: &files::FileMap| {
        let path = folder.path().join(name);
        std::fs::write(&path, archives::pack(files)).unwrap();
        raw::open(&path, &Limits::default()).unwrap()
    };
    for recording in [
        footage::healthy().recording(),
        put("case.zip", files::case()),
        put("bundle.zip", files::bundle()),
    ] {
        let report = inspect(&recording, &CancelToken::default(), &mut |_| {}).unwrap();
        assert_eq!(report.verdict, Verdict::Good, "{:#?}", report.findings);
    }
}

/// Peak of this process's memory, where the system reports it.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_ascii_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

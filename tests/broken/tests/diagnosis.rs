//! Every broken recording gets its diagnosis, a healthy one gets none, and none costs more than 1
//! GB. Inspection, lifting and the whole ingest say the same of each.

use bendtwin_broken::{Broken, Expected, Sample, all, archives, files, footage};
use bendtwin_capture::{Limits, raw, raw::Recording};
use bendtwin_core::{
    CancelToken, Fault, Finding, Problem, Severity, settings::ingest::IngestSettings,
};
use bendtwin_inspect::{Inspection, Lifted, Report, Verdict, inspect};
use bendtwin_lift::lift;

const MAX_BYTES: u64 = 1_000_000_000;

/// The recording, or the reason why it cannot be opened.
fn opened(sample: &Sample) -> Result<Recording, Fault> {
    match sample {
        Sample::Opened(recording) => Ok(recording.as_ref().clone()),
        Sample::Stored(_, path) => raw::open(path, &Limits::default()).map_err(|e| e.fault()),
    }
}

fn inspected(recording: &Recording) -> Inspection {
    let settings = IngestSettings::default();
    inspect(recording, &settings, &CancelToken::default(), &mut |_| {}).unwrap()
}

/// Differences from the expected diagnosis.
fn complaint(expected: Expected, found: &Result<Inspection, Fault>) -> Option<String> {
    let codes = |report: &Inspection| -> Vec<String> {
        let sentence = |f: &Finding| format!("{} ({})", f.code, f.sentence());
        report.findings.iter().map(sentence).collect()
    };
    let is_right = match (&expected, found) {
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
        Ok(report) => format!("expected {expected:?}, found {:#?}", codes(report)),
    })
}

/// Contradictions between inspection and lifting. The ingest refuses what inspection finds unusable
/// and lifts the rest; then what is lifted must be usable, and lifting refuses nothing but what
/// inspection refuses, for the reason that is its first finding or follows from it.
fn contradiction(recording: &Recording, seen: &Inspection) -> Option<String> {
    let settings = IngestSettings::default();
    let first = seen.findings.first();
    if (seen.verdict == Verdict::Unusable) != first.is_some_and(|f| f.severity == Severity::Error) {
        return Some(format!("it is {:?}, and first {first:?}", seen.verdict));
    }
    let lifted = lift(recording, &settings, None, &mut (), &CancelToken::default());
    match (lifted, first) {
        (Err(error), Some(first)) if seen.verdict == Verdict::Unusable => {
            let reason = error.reason();
            let known = first.code == reason
                || first.consequences.iter().any(|code| code == reason)
                || UPSTREAM.contains(&first.code.as_str());
            (!known).then(|| format!("lifting refuses with {reason}, inspection with {first:?}"))
        }
        (Err(error), _) => Some(format!("it is {:?}, but lifting refuses: {error}", seen.verdict)),
        (Ok(_), _) if seen.verdict == Verdict::Unusable => None,
        (Ok(observation), _) => {
            let capture = observation.capture;
            let report = Report::new(seen.clone(), Some(Lifted { capture, evidence: None }));
            let verdict = report.inspection().verdict;
            (verdict == Verdict::Unusable).then(|| {
                let first = report.inspection().findings.first();
                format!("it is {:?}, but once lifted {verdict:?}: {first:?}", seen.verdict)
            })
        }
    }
}

/// Faults with which nothing can be lifted, which lifting sees by their effect: numbers that are no
/// camera's, units with which all depth is out of range, masks of nothing, tracks of another place.
const UPSTREAM: [&str; 15] = [
    "CAMERA_EMPTY",
    "CAMERA_RATE_UNCLEAR",
    "DEPTH_EMPTY",
    "DEPTH_UNITS",
    "FPS_INVALID",
    "INTRINSICS_IMPLAUSIBLE",
    "INTRINSICS_INVALID",
    "EXTRINSICS_INVALID",
    "MASKS_MISALIGNED",
    "MASKS_MISSING",
    "MASK_COVERS_IMAGE",
    "MASKS_OVERLAP",
    "SCALE_TOO_LARGE",
    "SCALE_TOO_SMALL",
    "TRACKS_TRANSPOSED",
];

#[test]
fn each_gets_its_diagnosis_which_nothing_contradicts_and_none_costs_a_gigabyte() {
    let broken = all();
    assert!(broken.len() >= 200, "{}", broken.len());
    let mut names: Vec<&str> = broken.iter().map(|b| b.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), broken.len(), "names repeat");
    let wrong: Vec<String> = broken.iter().flat_map(faults).collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), broken.len(), wrong.join("\n"));
    if let Some(peak) = peak_bytes() {
        assert!(peak < MAX_BYTES, "{peak} bytes at the peak");
    }
}

/// All faults in the judgement of a recording.
fn faults(broken: &Broken) -> Vec<String> {
    let sample = broken.make();
    let (found, contradiction) = match opened(&sample) {
        Err(fault) => (Err(fault), None),
        Ok(recording) => {
            let seen = inspected(&recording);
            let contradiction = contradiction(&recording, &seen);
            (Ok(seen), contradiction)
        }
    };
    let complaint = complaint(broken.expected, &found);
    complaint.into_iter().chain(contradiction).map(|c| format!("{}: {c}", broken.name)).collect()
}

#[test]
fn the_ingest_says_what_inspection_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.zip");
    let mut case = files::case().clone();
    std::fs::write(&path, archives::pack(&case)).unwrap();
    let settings = IngestSettings::default();
    let ingest = || {
        let (limits, cancel) = (Limits::default(), CancelToken::default());
        let input = bendtwin_ingest::Input::new(&path, "case");
        bendtwin_ingest::ingest(input, &settings, &limits, &mut (), &cancel).unwrap()
    };
    let good = ingest();
    assert!(good.capture.is_ok());
    assert_ne!(good.report.inspection().verdict, Verdict::Unusable);
    // Black masks of the hand from the middle on.
    let black: Vec<(String, Vec<u8>)> = {
        let masks = case.iter().filter(|(name, _)| name.starts_with("mask/"));
        let of = |name: &str| name.rsplit('/').next()?.strip_suffix(".png")?.parse::<usize>().ok();
        let blank = raw::Mask::filled(160, 120, false).encode().unwrap();
        masks
            .filter(|(name, _)| of(name).is_some_and(|frame| frame >= 18))
            .map(|(name, _)| (name.clone(), blank.clone()))
            .collect()
    };
    case.extend(black);
    std::fs::write(&path, archives::pack(&case)).unwrap();
    let bad = ingest();
    let seen = inspected(&raw::open(&path, &Limits::default()).unwrap());
    assert_eq!(seen.verdict, Verdict::Unusable);
    let first = &seen.findings[0];
    assert_eq!(Some(first), bad.report.inspection().findings.first());
    assert!(bad.capture.unwrap_err().message.contains(&first.code));
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
        let report = inspected(&recording);
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

//! Hostile captures, twins and trainings through the code that reads strangers' files, in this process: no
//! panic, bounded time, bounded memory.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    time::{Duration, Instant},
};

use bendtwin_capture::{Limits, phystwin::results::TrainResult};
use bendtwin_core::{CancelToken, Twin, settings::ingest::IngestSettings};
use bendtwin_hostile::{Hostile, captures, trainings, twins};
use bendtwin_ingest::{Input, ingest};

const SEED: u64 = 20_260;
const CAPTURES: usize = 200;
const TWINS: usize = 200;
const TRAININGS: usize = 400;
/// Far more than any of them takes, because a busy machine is no fault of a reader.
const LONGEST: Duration = Duration::from_secs(30);
/// Memory that a reader may charge to its limits.
const LIMIT_BYTES: u64 = 256 << 20;
/// Peak of this process: what is charged, what is not, and the libraries.
const MOST_BYTES: u64 = 768 << 20;

/// Reads a file; the fault that it meets, if it does.
fn fault(file: &Hostile, read: impl FnOnce()) -> Option<String> {
    let start = Instant::now();
    let panicked = catch_unwind(AssertUnwindSafe(read)).is_err();
    let took = start.elapsed();
    (panicked || took > LONGEST).then(|| format!("{}: panicked: {panicked}, {took:?}", file.name))
}

#[test]
fn nothing_hostile_panics_or_takes_long_or_takes_much() {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits { total_bytes: LIMIT_BYTES, file_bytes: LIMIT_BYTES, ..Limits::default() };
    let settings = IngestSettings::default();
    let mut faults = Vec::new();
    let mut refused = 0;
    for file in captures(SEED).take(CAPTURES) {
        let path = folder.path().join(&file.name);
        std::fs::write(&path, &file.bytes).unwrap();
        faults.extend(fault(&file, || {
            let cancel = CancelToken::default();
            let input = Input::new(&path, "hostile");
            let observed = ingest(input, &settings, &limits, &mut (), &cancel);
            // A file is refused with a report: an error would be one of the reader.
            let observed = observed.unwrap();
            refused += usize::from(observed.capture.is_err());
            assert!(!observed.report.to_html().is_empty());
        }));
        std::fs::remove_file(&path).unwrap();
    }
    let mut unread = 0;
    for file in twins(SEED).take(TWINS) {
        faults.extend(fault(&file, || unread += usize::from(Twin::decode(&file.bytes).is_err())));
    }
    let mut untrained = 0;
    for file in trainings(SEED).take(TRAININGS) {
        let read = || TrainResult::decode(&file.name, &file.bytes, &limits);
        faults.extend(fault(&file, || untrained += usize::from(read().is_err())));
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    // Damage may hit what nobody reads; most of it does not.
    assert!(refused > CAPTURES / 2, "{refused} of {CAPTURES} captures refused");
    assert!(unread > TWINS / 2, "{unread} of {TWINS} twins refused");
    assert!(untrained > TRAININGS / 2, "{untrained} of {TRAININGS} trainings refused");
    if let Some(peak) = peak_bytes() {
        assert!(peak < MOST_BYTES, "{peak} bytes at the peak");
    }
}

/// Peak of this process's memory, where the system reports it.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_ascii_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

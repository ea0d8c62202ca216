//! Crowds through the code that reads strangers' captures, up to the limits. `examples/crowds.rs` prints the times.

use std::time::{Duration, Instant};

use bendtwin_capture::Limits;
use bendtwin_core::{CancelToken, Category, settings::ingest::IngestSettings};
use bendtwin_hostile::crowds::{CROWDS, Crowd};
use bendtwin_ingest::{Input, ingest};

/// Far more than any of them takes on a busy machine. Where points in one place are compared with each other, a
/// million of them take minutes to hours.
const LONGEST: Duration = Duration::from_secs(40);

#[test]
fn crowds_are_read_in_bounded_time() {
    let folder = tempfile::tempdir().unwrap();
    let (settings, limits) = (IngestSettings::default(), Limits::default());
    for Crowd { what, most, make } in CROWDS {
        let path = folder.path().join("crowd.zip");
        std::fs::write(&path, make(*most)).unwrap();
        let start = Instant::now();
        let cancel = CancelToken::default();
        let read = ingest(Input::new(&path, what), &settings, &limits, &mut (), &cancel).unwrap();
        // What is beyond a limit would be no crowd.
        let fault =
            read.capture.as_ref().err().filter(|f| f.category == Category::ResourceExhausted);
        assert_eq!(fault, None, "{what}");
        assert!(!read.report.to_html().is_empty());
        let took = start.elapsed();
        assert!(took < LONGEST, "{what}: {took:?}");
    }
}

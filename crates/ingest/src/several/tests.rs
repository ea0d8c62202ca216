use std::path::Path;

use bendtwin_capture::{Limits, raw, write_bundle_file};
use bendtwin_core::Capture;
use bendtwin_synth::{FilmOptions, MakeOptions, Scene, film, make};

use crate::{Input, Observed, Progress, ingest};

/// Progress that was reported.
#[derive(Default)]
struct Shares(Vec<f64>);

impl bendtwin_core::Observer<Progress> for Shares {
    fn progress(&mut self, progress: Progress) {
        self.0.push(progress.fraction);
    }

    fn checkpoint(&mut self, _: Vec<u8>) -> Result<(), bendtwin_core::ObserverError> {
        Ok(())
    }
}

fn ingested(path: &Path) -> (Observed, Vec<f64>) {
    let mut seen = Shares::default();
    let (settings, limits) = (Default::default(), Limits::default());
    let observed =
        ingest(Input::new(path, "the toy"), &settings, &limits, &mut seen, &Default::default())
            .unwrap();
    (observed, seen.0)
}

fn document(root: &Path) {
    let text = r#"{"format": "bendtwin-recordings", "version": 1}"#;
    std::fs::write(root.join("recordings.json"), text).unwrap();
}

#[test]
fn points_and_images_are_recordings_side_by_side() {
    let root = tempfile::tempdir().unwrap();
    document(root.path());
    let made = make(Scene::Rope, &MakeOptions::tiny(1)).unwrap();
    for (folder, train) in [("a", 20), ("c", 0)] {
        let mut capture = made.clone();
        capture.sequences[0].train_frame_count = train;
        let bundle = root.path().join(format!("{folder}.zip"));
        write_bundle_file(&capture, &bundle).unwrap();
        let mut archive = zip::ZipArchive::new(std::fs::File::open(&bundle).unwrap()).unwrap();
        archive.extract(root.path().join(folder)).unwrap();
    }
    let recording = film(Scene::Rope, &FilmOptions::tiny(2)).unwrap();
    raw::write_case(&recording, &root.path().join("b")).unwrap();

    let (observed, progress) = ingested(root.path());
    let capture = observed.points().unwrap();
    let names: Vec<&str> = capture.recordings().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["the toy", "b", "c"]);
    assert!(capture.recordings().all(|r| r.object.point_count > 0));
    let train = |r: &Capture| r.sequences[0].train_frame_count;
    assert_eq!((train(&capture), train(&capture.others[1])), (20, 0));
    assert!(progress.is_sorted() && progress.iter().all(|f| (0.0..=1.0).contains(f)));
    // An observation is read back unchanged.
    let stored = root.path().join("observation.zip");
    write_bundle_file(&capture, &stored).unwrap();
    let read = bendtwin_capture::read(&stored, &Limits::default()).unwrap();
    assert_eq!(bendtwin_capture::digest(&read), bendtwin_capture::digest(&capture));
    assert!(ingested(&stored).0.capture.is_ok());
}

#[test]
fn a_recording_that_cannot_be_fitted_is_named() {
    let root = tempfile::tempdir().unwrap();
    let mut capture = make(Scene::Rope, &MakeOptions::tiny(1)).unwrap();
    let mut still = Capture { name: "nothing moves".into(), ..capture.clone() };
    let s = &mut still.sequences[0];
    s.visible.fill(false);
    capture.others.push(still);
    let path = root.path().join("both.zip");
    write_bundle_file(&capture, &path).unwrap();
    let (observed, _) = ingested(&path);
    let fault = observed.capture.unwrap_err();
    assert!(fault.message.starts_with("recording `nothing moves`: "), "{}", fault.message);
    let findings = &observed.report.inspection().findings;
    assert!(findings.iter().any(|f| f.message.contains("`nothing moves`")), "{findings:?}");
}

use bendtwin_capture::{Limits, raw};
use bendtwin_core::settings::ingest::{IngestSettings, Stage};
use bendtwin_synth::{FilmOptions, Scene, film};

use crate::{Input, Observed, ingest};

fn ingested(recording: &raw::Recording, settings: &IngestSettings) -> Observed {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case");
    raw::write_case(recording, &path).unwrap();
    let limits = Limits::default();
    ingest(Input::new(&path, "the toy"), settings, &limits, &mut (), &Default::default()).unwrap()
}

#[test]
fn an_ingest_may_end_with_masks() {
    let recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    let settings = IngestSettings { until: Stage::Masks, ..IngestSettings::default() };
    let made = ingested(&recording, &settings);
    assert!(matches!(made.capture, Ok(None)));
    assert!(made.recorded.iter().flatten().next().is_some());
    assert_eq!(made.points().unwrap_err().reason, "CAPTURE_NOT_LIFTED");
}

#[test]
fn a_refused_recording_can_be_shown() {
    let mut recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    // All cameras in one place.
    let pose = recording.cameras[0].poses.clone();
    recording.cameras.iter_mut().for_each(|camera| camera.poses.clone_from(&pose));
    let made = ingested(&recording, &IngestSettings::default());
    assert_eq!(made.recorded.iter().flatten().count(), 1);
    made.points().unwrap_err();
}

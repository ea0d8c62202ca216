use bendtwin_capture::{Limits, raw};
use bendtwin_core::settings::ingest::{GroundSource, IngestSettings, Stage};
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

#[test]
fn a_ground_elsewhere_is_offered_and_taken_if_asked_for() {
    let options = FilmOptions { frames: 4, cameras: 3, ..FilmOptions::tiny(5) };
    let mut recording = film(Scene::Toy, &options).unwrap();
    for pose in recording.cameras.iter_mut().flat_map(|camera| &mut camera.poses) {
        pose.translation[2] += 0.05;
    }
    let mut settings = IngestSettings { until: Stage::Masks, ..IngestSettings::default() };
    let offered = ingested(&recording, &settings);
    assert!(offered.report.inspection().has("GROUND_OFFERED"));
    settings.calibration.ground = GroundSource::Detected;
    let taken = ingested(&recording, &settings);
    assert!(taken.report.inspection().has("GROUND_DETECTED"));
    let height =
        |made: &Observed| made.recorded[0].as_ref().unwrap().cameras[0].poses[0].translation[2];
    assert!((height(&offered) - height(&taken) - 0.05).abs() < 0.005);
}

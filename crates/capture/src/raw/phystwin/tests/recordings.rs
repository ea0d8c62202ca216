//! Cases before PhysTwin's alignment.

use serde_json::json;

use super::*;
use crate::check::testing::FileMap;

/// The tiny case as it is recorded: the second camera numbers its images from 70 on, and its clock
/// is half a millisecond behind.
fn unaligned() -> FileMap {
    let moved = |name: &str| -> Option<String> {
        let (folder, file) = name.rsplit_once('/')?;
        let (number, ending) = file.split_once('.')?;
        let number: usize = number.parse().ok().filter(|_| !name.starts_with("cotracker"))?;
        let camera: usize = folder.split('/').nth(1)?.parse().ok()?;
        Some(format!("{folder}/{}.{ending}", number + [30, 70][camera]))
    };
    let mut files: FileMap =
        case().into_iter().map(|(name, bytes)| (moved(&name).unwrap_or(name), bytes)).collect();
    let times = |first: usize, late: f64| -> serde_json::Map<_, _> {
        let time = |f: usize| 1.7e9 + f as f64 / 30.0 + late;
        (0..FRAMES).map(|f| ((first + f).to_string(), json!(time(f)))).collect()
    };
    let mut metadata: serde_json::Value = serde_json::from_slice(&files["metadata.json"]).unwrap();
    metadata["recording"] = json!({"0": times(30, 0.0), "1": times(70, 0.0005)});
    metadata.as_object_mut().unwrap().remove("frame_num");
    files.insert("metadata.json".into(), metadata.to_string().into_bytes());
    files
}

#[test]
fn images_are_brought_together_by_their_times() {
    let folder = folder(&unaligned());
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    expect_whole(&recording);
    assert_eq!(recording.cameras[0].times_s[0], 0.0);
    assert!((recording.cameras[1].times_s[1] - 1.0 / 30.0 - 0.0005).abs() < 1e-6);
    let note = recording.notes.iter().find(|note| note.code == "FRAMES_NUMBERED").unwrap();
    assert!(note.message.contains("4 common frames"), "{}", note.message);
}

#[test]
fn an_image_that_was_not_taken_is_a_gap() {
    let mut files = unaligned();
    files.remove("color/1/72.png");
    files.remove("depth/1/72.npy");
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    let mut frames = recording.source.frames(1).unwrap();
    assert!(frames.color(2).unwrap().is_none());
    assert_eq!(frames.color(3).unwrap().unwrap().get(0, 0), Some(color_at(1, 3, 0, 0)));
    assert!(recording.cameras[1].times_s[2].is_nan());
}

#[test]
fn times_that_cannot_be_are_refused() {
    for change in [json!({"0": {"30": 1.0}}), json!({"0": {"30": 2.0, "31": 1.0}, "1": {}})] {
        let mut files = unaligned();
        let mut metadata: serde_json::Value =
            serde_json::from_slice(&files["metadata.json"]).unwrap();
        metadata["recording"] = change;
        files.insert("metadata.json".into(), metadata.to_string().into_bytes());
        assert_eq!(reason(describe(&files)), "INVALID_DOCUMENT");
    }
}

use std::io::Cursor;

use serde_json::{Value, json};

use super::*;
use crate::{
    Limits, Opened,
    check::testing::{FileMap, pack, unpack},
    open,
    raw::{
        self, Alignment, Distortion, Pose, Recording, Region,
        testing::{FRAMES, archive, case, color_at, describe, folder, pixels, reason},
    },
};

/// A recording in which no field has its default.
fn rich() -> (tempfile::TempDir, Recording) {
    let mut files = case();
    files.remove("color/0/2.png");
    files.remove("depth/1/1.npy");
    let folder = folder(&files);
    let mut recording = raw::open(folder.path(), &Limits::default()).unwrap();
    recording.environment.gravity = [0.0, -1.0, -9.7];
    recording.truth_tracks = (0..FRAMES * 3).map(|i| [i as f32, 0.5, -1.0]).collect();
    let camera = &mut recording.cameras[1];
    camera.distortion = Distortion::KannalaBrandt([0.1, 0.2, 0.3, 0.4]);
    camera.times_s = vec![0.0, f64::NAN, 0.066, 0.1];
    let pose = camera.poses[0];
    camera.poses =
        (0..FRAMES).map(|i| Pose { translation: [0.1 * i as f64, 0.0, 1.0], ..pose }).collect();
    recording.cameras[0].distortion =
        Distortion::BrownConrady([0.1, 0.2, 0.01, 0.02, 0.3, 0.4, 0.5, 0.6]);
    (folder, recording)
}

fn written(recording: &Recording) -> Vec<u8> {
    let writer = Cursor::new(Vec::new());
    write_bundle_to(recording, writer, &BundleOptions::default()).unwrap().into_inner()
}

fn expect_same(a: &Recording, b: &Recording) {
    assert_eq!((&a.name, a.fps, a.frame_count), (&b.name, b.fps, b.frame_count));
    assert_eq!(a.train_frame_count, b.train_frame_count);
    assert_eq!(a.environment, b.environment);
    assert_eq!(a.source_to_world, b.source_to_world);
    assert_eq!(a.truth_tracks, b.truth_tracks);
    let (mesh, other) = (a.mesh.as_ref().unwrap(), b.mesh.as_ref().unwrap());
    assert_eq!((&mesh.bytes, mesh.to_world), (&other.bytes, other.to_world));
    assert_eq!(a.cameras.len(), b.cameras.len());
    for (index, (camera, other)) in a.cameras.iter().zip(&b.cameras).enumerate() {
        // Times that are missing are not equal to themselves.
        assert_eq!(format!("{camera:?}"), format!("{other:?}"));
        let mut frames = a.source.frames(index).unwrap();
        let mut others = b.source.frames(index).unwrap();
        for frame in 0..a.frame_count {
            assert_eq!(frames.color(frame).unwrap(), others.color(frame).unwrap());
            assert_eq!(frames.depth(frame).unwrap(), others.depth(frame).unwrap());
            for region in [Region::Object, Region::Manipulator] {
                assert_eq!(
                    frames.mask(frame, region).unwrap(),
                    others.mask(frame, region).unwrap()
                );
            }
        }
        let (tracks, others) = (frames.tracks().unwrap(), others.tracks().unwrap());
        assert_eq!(format!("{tracks:?}"), format!("{others:?}"));
    }
}

#[test]
fn recordings_survive_the_bundle_unchanged() {
    let (_guard, recording) = rich();
    let bytes = written(&recording);
    assert_eq!(bytes, written(&recording));
    let (_zip, path) = archive(&unpack(&bytes));
    expect_same(&recording, &raw::open(&path, &Limits::default()).unwrap());
    let folder = folder(&unpack(&bytes));
    let Opened::Raw(back) = open(&folder.path().join("capture.json"), &Limits::default()).unwrap()
    else {
        panic!("it is raw");
    };
    expect_same(&recording, &back);
    assert_eq!(reason(crate::read_bytes("b", &bytes, &Limits::default())), "RAW_CAPTURE");
}

/// The bundle with its document changed.
fn with(change: impl FnOnce(&mut Value)) -> FileMap {
    let (_guard, recording) = rich();
    let mut files = unpack(&written(&recording));
    let mut document: Value = serde_json::from_slice(&files["capture.json"]).unwrap();
    change(&mut document);
    files.insert("capture.json".into(), serde_json::to_vec(&document).unwrap());
    files
}

#[test]
fn the_documented_example_is_read() {
    let text = include_str!("../../../../../docs/formats/capture.md");
    let mut examples = text.split("```json").skip(1).filter_map(|rest| rest.split("```").next());
    let example = examples.find(|example| example.contains("\"raw\"")).unwrap();
    let mut files = FileMap::from([("capture.json".to_owned(), example.as_bytes().to_vec())]);
    for name in ["left/color/000000.png", "left/depth/000099.png"] {
        files.insert(name.to_owned(), Vec::new());
    }
    let recording = describe(&files).unwrap();
    assert_eq!((recording.frame_count, recording.cameras[0].name.as_str()), (100, "left"));
    // It looks down from half a metre.
    let point = recording.cameras[0].unproject([423.5, 239.5], 0.5, 0);
    assert_eq!(point, [0.0; 3]);
}

/// Patterns say where names have their number, not how it is written.
#[test]
fn images_may_be_numbered_from_anywhere() {
    let (_guard, recording) = rich();
    let files = unpack(&written(&recording));
    let renamed = |first: usize, digits: usize| -> FileMap {
        let new = |name: &str| {
            let (folder, file) = name.rsplit_once('/')?;
            let n: usize = file.strip_suffix(".png")?.parse().ok()?;
            Some(format!("{folder}/{:0digits$}.png", n + first))
        };
        files
            .iter()
            .map(|(name, bytes)| (new(name).unwrap_or(name.clone()), bytes.clone()))
            .collect()
    };
    for (first, digits) in [(1, 6), (0, 1), (77, 4)] {
        let (_zip, path) = archive(&renamed(first, digits));
        let mut back = raw::open(&path, &Limits::default()).unwrap();
        assert_eq!(back.notes.iter().any(|n| n.code == "FRAMES_NUMBERED"), first > 0);
        back.name.clone_from(&recording.name);
        expect_same(&recording, &back);
    }
    let mut masks_from_0 = renamed(1, 6);
    masks_from_0.retain(|name, _| !name.contains("/object/"));
    masks_from_0.extend(
        files.iter().filter(|(n, _)| n.contains("/object/")).map(|(n, b)| (n.clone(), b.clone())),
    );
    assert_eq!(reason(describe(&masks_from_0)), "FRAME_NUMBERS_UNCLEAR");
    let mut maskless = files.clone();
    maskless.retain(|name, _| !name.contains("0/object/"));
    let notes = describe(&maskless).unwrap().notes;
    let note = notes.iter().find(|note| note.code == "MASKS_NOT_FOUND").unwrap();
    assert!(
        note.message.contains("no `cameras/0/object`, and `cameras/0` has"),
        "{}",
        note.message
    );
    assert_eq!(note.cameras, [0]);
    let mut elsewhere = files.clone();
    elsewhere.retain(|name, _| !name.starts_with("cameras/0/depth"));
    elsewhere.insert("cameras/0/depth/a.tif".into(), Vec::new());
    let text = describe(&elsewhere).unwrap_err().to_string();
    for part in ["no depth images", "cameras/0/depth/{frame:06}.png", "one file (a.tif)"] {
        assert!(text.contains(part), "{text} lacks {part}");
    }
}

#[test]
fn cameras_may_have_rates_and_offsets_of_their_own() {
    let shown = |change: &dyn Fn(&mut Value)| {
        let folder = folder(&with(|document| change(&mut document["raw"]["cameras"][1])));
        let recording = raw::open(folder.path(), &Limits::default()).unwrap();
        let mut frames = recording.source.frames(1).unwrap();
        let images = (0..FRAMES).map(|frame| {
            let color = frames.color(frame).unwrap()?;
            (0..FRAMES).find(|image| color.get(0, 0) == Some(color_at(1, *image, 0, 0)))
        });
        (images.collect::<Vec<_>>(), recording.cameras[1].fps)
    };
    let early = shown(&|camera| camera["frame_offset"] = json!(-1));
    assert_eq!(early, (vec![Some(1), Some(2), Some(3), None], None));
    let late = shown(&|camera| camera["frame_offset"] = json!(1));
    assert_eq!(late, (vec![None, Some(0), Some(1), Some(2)], None));
    let half = shown(&|camera| camera["fps"] = json!(15));
    assert_eq!(half, (vec![Some(0), None, Some(1), None], Some(15.0)));
    let wrong = |key: &str, value: Value| {
        reason(describe(&with(|document| document["raw"]["cameras"][1][key] = value)))
    };
    assert_eq!(wrong("fps", json!(60)), "INVALID_DOCUMENT");
    assert_eq!(wrong("fps", json!(0)), "LENGTH_MISMATCH");
    assert_eq!(wrong("frame_offset", json!(i64::MIN)), "LENGTH_MISMATCH");
}

#[test]
fn depth_of_another_camera_is_aligned() {
    let lens = json!({"fx": 10.0, "fy": 11.0, "cx": 3.5, "cy": 2.5});
    let same = json!({"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, 0]});
    let read = |change: &dyn Fn(&mut Value)| {
        let files = with(|document| {
            let camera = &mut document["raw"]["cameras"][0];
            camera["distortion"] = json!({"model": "none"});
            change(&mut camera["depth"]);
        });
        let folder = folder(&files);
        let recording = raw::open(folder.path(), &Limits::default())?;
        recording.source.frames(0)?.depth(1)
    };
    let aligned = read(&|_| {}).unwrap().unwrap();
    let own = read(&|depth| {
        depth["intrinsics"] = lens.clone();
        depth["pose"] = same.clone();
    });
    assert_eq!(own.unwrap().unwrap(), aligned, "the same camera sees the same");
    let aside = read(&|depth| {
        depth["intrinsics"] = lens.clone();
        depth["pose"] =
            json!({"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0.06, 0, 0]});
    });
    // At 0.6 m with a focal length of 10 pixels, 6 cm are one column.
    let aside = aside.unwrap().unwrap();
    assert_eq!(aside.get(0, 3), Some(0.0), "the depth camera does not see there");
    assert!(aside.get(4, 3).is_some_and(|z| z > 0.5) && aside != aligned);
    assert_eq!(reason(read(&|depth| depth["pose"] = same.clone())), "INVALID_DOCUMENT");
    assert_eq!(reason(read(&|depth| depth["unit_m"] = json!(1000))), "INVALID_DOCUMENT");
}

#[test]
fn other_axes_and_units_are_converted() {
    let mut files = with(|document| {
        document["units"] = json!("cm");
        document["up_axis"] = json!("+y");
        document["gravity_m_s2"] = Value::Null;
        document["raw"]["cameras"][0]["pose"] = json!({
            "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [10, 20, 30]
        });
        document["raw"]["mesh"]["to_world"] = json!({
            "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "scale": 100, "translation": [0, 50, 0]
        });
    });
    let poses = [[0, 1, 0, 0, 0, 0, 1]; FRAMES];
    let grippers = json!({
        "format": "bendtwin-grippers", "version": 1, "grippers": [{ "poses": poses }]
    });
    files.insert("grippers.json".to_owned(), grippers.to_string().into_bytes());
    let recording = describe(&files).unwrap();
    // Grippers are given in metres.
    assert_eq!(recording.grippers[0].poses[0].unwrap().translation, [0.0, 0.0, 1.0]);
    let pose = recording.cameras[0].poses[0];
    let expected = [0.1, -0.3, 0.2];
    assert!((0..3).all(|i| (pose.translation[i] - expected[i]).abs() < 1e-12), "{pose:?}");
    // The camera's z, its view, was the bundle's z, which is the world's -y.
    assert_eq!(pose.rotation.map(|row| row[2]), [0.0, -1.0, 0.0]);
    let Alignment { scale, translation, .. } = recording.mesh.unwrap().to_world.unwrap();
    assert!((scale - 1.0).abs() < 1e-6 && (translation[2] - 0.5).abs() < 1e-6);
}

#[test]
fn depth_keeps_the_unit_it_is_written_in() {
    let (_guard, recording) = rich();
    let options = BundleOptions { depth_unit_m: 0.0001 };
    let bytes = write_bundle_to(&recording, Cursor::new(Vec::new()), &options).unwrap();
    let (_zip, path) = archive(&unpack(&bytes.into_inner()));
    let back = raw::open(&path, &Limits::default()).unwrap();
    let depth = |r: &Recording| r.source.frames(0).unwrap().depth(3).unwrap().unwrap();
    let (a, b) = (depth(&recording), depth(&back));
    assert!(pixels().all(|(c, r)| (a.get(c, r).unwrap() - b.get(c, r).unwrap()).abs() < 1e-6));
}

#[test]
fn wrong_documents_are_refused() {
    let camera = |document: &mut Value, key: &str, value: Value| {
        document["raw"]["cameras"][0][key] = value;
    };
    let refused = |change: &dyn Fn(&mut Value)| reason(describe(&with(|d| change(d))));
    assert_eq!(refused(&|_| ()), "no error");
    let document = "INVALID_DOCUMENT";
    assert_eq!(refused(&|d| camera(d, "colour", json!("x"))), document);
    assert_eq!(refused(&|d| camera(d, "color", json!("a/../../{frame}.png"))), document);
    assert_eq!(refused(&|d| camera(d, "color", json!("/a/{frame}.png"))), document);
    assert_eq!(refused(&|d| camera(d, "color", json!("a/0.png"))), document);
    assert_eq!(refused(&|d| camera(d, "color", json!("a/{frame:099}.png"))), document);
    assert_eq!(refused(&|d| camera(d, "color", json!("{frame}/{frame}.png"))), document);
    assert_eq!(refused(&|d| camera(d, "pose", Value::Null)), document);
    assert_eq!(refused(&|d| camera(d, "poses", json!("p.npy"))), document);
    assert_eq!(
        refused(&|d| camera(d, "depth", json!({"files": "{frame}.png", "unit_m": 0}))),
        document
    );
    let radial = json!({"model": "brown_conrady", "coefficients": [1, 2, 3]});
    assert_eq!(refused(&|d| camera(d, "distortion", radial.clone())), document);
    let unknown = json!({"model": "ftheta", "coefficients": [1]});
    assert_eq!(refused(&|d| camera(d, "distortion", unknown.clone())), document);
    let zero = json!({"fx": 0, "fy": 1, "cx": 0, "cy": 0});
    assert_eq!(refused(&|d| camera(d, "intrinsics", zero.clone())), "INVALID_CAMERA");
    let huge = json!([1_000_000, 1_000_000]);
    assert_eq!(refused(&|d| camera(d, "size", huge.clone())), "CAPTURE_TOO_MANY");
    assert_eq!(refused(&|d| camera(d, "times", json!("none.npy"))), "MISSING_FILE");
    let mirror = json!({"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, -1]], "translation": [0, 0, 0]});
    assert_eq!(refused(&|d| camera(d, "pose", mirror.clone())), "MIRRORED_EXTRINSICS");
    assert_eq!(refused(&|d| d["raw"]["frame_count"] = json!(1_000_000_000)), "CAPTURE_TOO_MANY");
    assert_eq!(refused(&|d| d["raw"]["frame_count"] = json!(5)), "WRONG_SHAPE");
    assert_eq!(refused(&|d| d["raw"]["train_frame_count"] = json!(5)), "SPLIT_OUT_OF_RANGE");
    assert_eq!(refused(&|d| d["raw"]["cameras"] = json!([])), "LENGTH_MISMATCH");
    assert_eq!(refused(&|d| d["raw"] = Value::Null), document);
    assert_eq!(refused(&|d| d["raw"]["mesh"]["file"] = json!("other.glb")), "MISSING_FILE");
    assert_eq!(refused(&|d| d["raw"]["mesh"]["to_world"]["scale"] = json!(-1)), document);
}

#[test]
fn a_cut_off_archive_is_refused() {
    let (_guard, recording) = rich();
    let bytes = written(&recording);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.zip");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(reason(raw::open(&path, &Limits::default())), "ARCHIVE_DAMAGED");
    // A poses array that ends early.
    let mut files = unpack(&bytes);
    let poses = files["cameras/1/poses.npy"].clone();
    files.insert("cameras/1/poses.npy".into(), poses[..poses.len() - 8].to_vec());
    std::fs::write(&path, pack(&files)).unwrap();
    assert_eq!(reason(raw::open(&path, &Limits::default())), "HEADER_CLAIMS_TOO_MUCH");
}

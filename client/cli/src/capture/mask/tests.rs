use bendtwin_synth::{FilmOptions, Scene, Shape, film};

use super::*;

/// A recording without masks in a folder, and the same as an archive beside it.
fn recorded() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("toy");
    let options = FilmOptions {
        frames: 4,
        size: [160, 120],
        tracks: false,
        shape: Shape::Absent,
        ..FilmOptions::tiny(3)
    };
    let recording = film(Scene::Toy, &options).unwrap();
    raw::write_case(&recording, &path).unwrap();
    std::fs::remove_dir_all(path.join("mask")).unwrap();
    (folder, path)
}

fn args(recording: &std::path::Path, clicks: [&str; 2], out: Option<PathBuf>) -> Mask {
    let [object, hand] = clicks.map(|click| vec![click.parse().unwrap()]);
    Mask {
        recording: recording.to_owned(),
        object,
        hand,
        background: Vec::new(),
        radius: 4.0,
        strokes: None,
        out,
        preview: Some(recording.with_extension("pictures")),
        force: false,
    }
}

const CLICKS: [&str; 2] = ["made0:83,74", "0:100,55"];

#[test]
fn masks_are_written_where_the_next_check_reads_them() {
    let (_guard, path) = recorded();
    let cancel = CancelToken::default();
    let made = make(&args(&path, CLICKS, None), &cancel, true).unwrap();
    assert_eq!((made.frames, made.cameras.len()), (4, 2));
    let masks = raw::MaskSet::of(&raw::open(&path, &Limits::default()).unwrap()).unwrap();
    let shows = |camera: usize, frame: usize, region| {
        masks.mask(camera, frame, region).unwrap().pixels.iter().filter(|p| **p).count()
    };
    for camera in 0..2 {
        for frame in [0, 3] {
            assert!(shows(camera, frame, raw::Region::Object) > 100);
            assert!(shows(camera, frame, raw::Region::Manipulator) > 100);
        }
    }
    assert!(path.with_extension("pictures").join("1_00003.png").is_file());
    let again = args(&path, CLICKS, None);
    assert!(make(&again, &cancel, true).is_err_and(|e| e.is::<Usage>()), "masks are there");
    let forced = Mask { force: true, ..args(&path, ["0:83,74", "0@2:100,55"], None) };
    make(&forced, &cancel, true).unwrap();

    // What was written is what a later call starts from.
    let strokes = Some(path.join("mask/following.json"));
    let zip = path.with_extension("zip");
    let more = Mask {
        strokes,
        object: Vec::new(),
        hand: Vec::new(),
        ..args(&path, CLICKS, Some(zip.clone()))
    };
    make(&more, &cancel, true).unwrap();
    let recording = raw::open(&path, &Limits::default()).unwrap();
    let read = recording.clone().with_mask_files(&zip, &Limits::default()).unwrap();
    assert_eq!(raw::MaskSet::of(&read).unwrap(), raw::MaskSet::of(&recording).unwrap());
}

#[test]
fn an_archive_has_no_place_for_masks_and_is_read_all_the_same() {
    let (_guard, path) = recorded();
    let recording = raw::open(&path, &Limits::default()).unwrap();
    let bundle = path.with_extension("zip");
    raw::write_bundle(&recording, &bundle).unwrap();
    let cancel = CancelToken::default();
    let nowhere = make(&args(&bundle, CLICKS, None), &cancel, true);
    assert!(nowhere.is_err_and(|e| e.is::<Usage>() && e.to_string().contains("--out")));
    let out = path.with_file_name("elsewhere");
    let made = make(&args(&bundle, CLICKS, Some(out.clone())), &cancel, true).unwrap();
    assert_eq!(made.path, out.join("mask"));
    assert!(out.join("mask/0/object/3.png").is_file());
    cancel.cancel();
    let stopped = make(&args(&bundle, CLICKS, Some(path.join("third"))), &cancel, true);
    assert!(stopped.is_err_and(|e| e.to_string().contains("cancelled")));
}

#[test]
fn clicks_are_read_or_explained() {
    let at = |text: &str| -> Click { text.parse().unwrap() };
    let names = ["left", "rig:2", "1"];
    let stroke = |text: &str| at(text).stroke(Part::Hand, 4.0, &names);
    let read = stroke("rig:2@12:120.5,88").unwrap();
    assert_eq!((read.camera, read.frame, read.points), (1, 12, vec![[120.5, 88.0]]));
    assert_eq!(stroke("1:0,0").unwrap().camera, 2, "a name counts more than a number");
    assert_eq!(stroke("0:0,0").unwrap().camera, 0);
    assert!(stroke("3:0,0").is_err_and(|e| e.is::<Usage>()));
    for wrong in ["", "0", "0:1", "0:1,", ":1,2", "0@x:1,2", "0@-1:1,2", "0:nan,2", "0:1,2,3"] {
        assert!(wrong.parse::<Click>().is_err(), "{wrong}");
    }
}

#[test]
fn nothing_marked_is_wrong_usage() {
    let (_guard, path) = recorded();
    let none = Mask { object: Vec::new(), hand: Vec::new(), ..args(&path, CLICKS, None) };
    let refused = make(&none, &CancelToken::default(), true);
    assert!(refused.is_err_and(|e| e.is::<Usage>() && e.to_string().contains("--object")));
    let far = Mask { radius: f64::NAN, ..args(&path, CLICKS, None) };
    assert!(make(&far, &CancelToken::default(), true).is_err_and(|e| e.is::<Usage>()));
}

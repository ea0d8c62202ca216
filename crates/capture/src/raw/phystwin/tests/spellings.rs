//! Cases as labs spell them.

use super::*;
use crate::raw::testing::{color_png, floats_npy, mask_png, png_file};

pub(super) type FileMap = std::collections::BTreeMap<String, Vec<u8>>;

/// The tiny case with its images under other names.
fn renamed(rename: impl Fn(&str, usize) -> Option<String>) -> FileMap {
    let new = |name: &str| {
        let (stem, _) = name.rsplit_once('.').filter(|_| !name.starts_with("cotracker"))?;
        let number = stem.rsplit_once('/')?.1.parse().ok()?;
        rename(name, number)
    };
    case().into_iter().map(|(name, bytes)| (new(&name).unwrap_or(name), bytes)).collect()
}

fn folder_of(name: &str) -> &str {
    name.rsplit_once('/').unwrap().0
}

/// Opens files as a recording and keeps them there.
pub(super) fn opened(files: &FileMap) -> (tempfile::TempDir, Recording) {
    let folder = folder(files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    (folder, recording)
}

pub(super) fn message(files: &FileMap) -> String {
    describe(files).unwrap_err().to_string()
}

pub(super) fn metadata(files: &mut FileMap, from: &str, to: &str) {
    let text = String::from_utf8(files["metadata.json"].clone()).unwrap();
    assert!(text.contains(from));
    files.insert("metadata.json".into(), text.replace(from, to).into_bytes());
}

#[test]
fn names_may_have_zeros_other_extensions_and_any_first_number() {
    let padded =
        renamed(|name, n| Some(format!("{}/{n:04}.{}", folder_of(name), name.rsplit('.').next()?)));
    expect_whole(&opened(&padded).1);
    let jpeg = renamed(|name, n| {
        let ending = if n % 2 == 0 { "JPG" } else { "jpeg" };
        name.starts_with("color").then(|| format!("{}/frame_{n}.{ending}", folder_of(name)))
    });
    expect_whole(&opened(&jpeg).1);
    for first in [1, 1000] {
        let ending = |name: &str| name.rsplit('.').next().unwrap().to_owned();
        let later =
            renamed(|name, n| Some(format!("{}/{}.{}", folder_of(name), n + first, ending(name))));
        let (_guard, recording) = opened(&later);
        expect_whole(&recording);
        let note = recording.notes.iter().find(|n| n.code == "FRAMES_NUMBERED").unwrap();
        assert!(note.message.contains(&format!("number {first} is frame 0")), "{}", note.message);
        let (_guard, path) = archive(&later);
        expect_whole(&raw::open(&path, &Limits::default()).unwrap());
    }
}

#[test]
fn a_hole_in_the_numbers_is_a_missing_frame() {
    let mut files = renamed(|name, n| {
        Some(format!("{}/{:03}.{}", folder_of(name), n + 1, name.rsplit('.').next()?))
    });
    files.remove("color/0/003.png");
    let (_guard, recording) = opened(&files);
    let mut frames = recording.source.frames(0).unwrap();
    assert!(frames.color(2).unwrap().is_none());
    assert_eq!(frames.color(3).unwrap().unwrap().get(0, 0), Some(color_at(0, 3, 0, 0)));
}

#[test]
fn frames_are_counted_where_nothing_says_how_many() {
    let mut files = case();
    metadata(&mut files, "\"frame_num\": 4, ", "");
    expect_whole(&opened(&files).1);
}

#[test]
fn a_wrong_number_of_frames_is_blamed_and_nothing_else() {
    for (wrong, found) in [("3", "0 to 3, which is 4 frames"), ("9", "0 to 3, which is 4 frames")] {
        let mut files = case();
        metadata(&mut files, "\"frame_num\": 4", &format!("\"frame_num\": {wrong}"));
        let text = message(&files);
        assert!(
            text.contains("`frame_num` of metadata.json is ") && text.contains(found),
            "{text}"
        );
    }
}

#[test]
fn images_that_are_numbered_differently_are_refused() {
    let shifted = renamed(|name, n| {
        name.starts_with("color").then(|| format!("{}/{}.png", folder_of(name), n + 1))
    });
    let text = message(&shifted);
    let named = text.contains("`color/0` from 1 to 4") && text.contains("`depth/0` from 0 to 3");
    assert!(named || text.contains("0 to 4, which is 5 frames"), "{text}");
    let mut uncounted = shifted;
    metadata(&mut uncounted, "\"frame_num\": 4, ", "");
    let text = message(&uncounted);
    assert!(
        text.contains("`color/0` from 1 to 4") && text.contains("`depth/0` from 0 to 3"),
        "{text}"
    );
    let masks = renamed(|name, n| {
        name.starts_with("mask").then(|| format!("{}/{}.png", folder_of(name), n + 1))
    });
    let text = message(&masks);
    assert!(
        text.contains("`mask/0/0` from 1 to 4") && text.contains("`color/0` from 0 to 3"),
        "{text}"
    );
}

#[test]
fn two_images_of_one_number_are_refused_unless_one_is_preferred() {
    let mut files = case();
    files.insert("color/0/001.png".into(), color_png(0, 1));
    assert_eq!(reason(describe(&files)), "FRAME_NUMBERS_UNCLEAR");
    let mut files = case();
    files.insert("color/0/1.jpg".into(), b"a worse copy".to_vec());
    files.insert("depth/0/1.png".into(), b"a picture of it".to_vec());
    expect_whole(&opened(&files).1);
}

#[test]
fn depth_may_be_png_and_float_metres() {
    let mut pngs = case();
    let mut metres = case();
    for camera in 0..2 {
        for frame in 0..FRAMES {
            pngs.remove(&format!("depth/{camera}/{frame}.npy"));
            let of = |(c, r)| depth_mm_at(camera, frame, c, r);
            let data: Vec<u8> = pixels().flat_map(|p| of(p).to_be_bytes()).collect();
            let png = png_file(WIDTH, HEIGHT, ::png::ColorType::Grayscale, true, &data);
            pngs.insert(format!("depth/{camera}/{frame:05}.png"), png);
            let floats = pixels().map(|p| f32::from(of(p)) / 1000.0);
            let array = floats_npy(&[HEIGHT, WIDTH], floats);
            metres.insert(format!("depth/{camera}/{frame}.npy"), array);
        }
    }
    expect_whole(&opened(&pngs).1);
    expect_whole(&opened(&metres).1);
}

/// Depth [m] of the first measured pixel.
fn first_depth(files: &FileMap) -> f32 {
    let (_guard, recording) = opened(files);
    let depth = recording.source.frames(0).unwrap().depth(0).unwrap().unwrap();
    depth.pixels[WIDTH]
}

#[test]
fn a_declared_unit_of_depth_counts() {
    let mut files = case();
    let millimetres = first_depth(&files);
    metadata(&mut files, "\"fps\"", "\"depth_unit_m\": 0.0001, \"fps\"");
    assert!((first_depth(&files) - millimetres / 10.0).abs() < 1e-7);
    // Whole numbers, and numbers beyond 50, are millimetres also as floats.
    for values in [512.0, 49.0] {
        let mut files = case();
        let array = floats_npy(&[HEIGHT, WIDTH], vec![values; WIDTH * HEIGHT]);
        files.insert("depth/0/0.npy".into(), array);
        assert!((first_depth(&files) - values / 1000.0).abs() < 1e-7, "{values}");
        metadata(&mut files, "\"fps\"", "\"depth_scale\": 1.0, \"fps\"");
        assert!((first_depth(&files) - values).abs() < 1e-4, "{values}");
    }
    let mut files = case();
    metadata(&mut files, "\"fps\"", "\"depth_unit_m\": -1, \"fps\"");
    assert_eq!(reason(describe(&files)), "INVALID_DOCUMENT");
}

#[test]
fn poses_may_lack_their_last_row_and_stand_in_json() {
    let rows = LOOKING_DOWN[..3].to_vec();
    for matrix in [rows, LOOKING_DOWN.to_vec()] {
        let mut files = case();
        files.remove("calibrate.pkl");
        let json = serde_json::to_vec(&[&matrix, &matrix]).unwrap();
        files.insert("calibrate.json".into(), json);
        assert_eq!(describe(&files).unwrap().cameras, describe(&case()).unwrap().cameras);
    }
    let mut files = case();
    // A pickled [2, 3, 4]: a shape of three numbers, and 192 bytes.
    let upper: Vec<u8> = [LOOKING_DOWN; 2]
        .iter()
        .flat_map(|m| &m[..3])
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let mut pickle =
        b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R"
            .to_vec();
    pickle.extend(b"(K\x01K\x02K\x03K\x04\x87cnumpy\ndtype\nX\x02\x00\x00\x00f8\x89\x88\x87R");
    pickle.extend(b"(K\x03X\x01\x00\x00\x00<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B\xc0\x00\x00\x00");
    pickle.extend(upper);
    pickle.extend(b"tb.");
    files.insert("calibrate.pkl".into(), pickle);
    assert_eq!(describe(&files).unwrap().cameras, describe(&case()).unwrap().cameras);
    let mut files = case();
    files.remove("calibrate.pkl");
    files.insert("calibrate.json".into(), b"[[[1, 0, 0, 0]], [[1, 0, 0, 0]]]".to_vec());
    assert_eq!(reason(describe(&files)), "INVALID_CAMERA");
}

#[test]
fn the_world_may_have_z_up() {
    let mut files = case();
    metadata(&mut files, "\"fps\"", "\"up_axis\": \"+z\", \"fps\"");
    assert_eq!(describe(&files).unwrap().cameras[0].poses[0].translation, [0.1, 0.2, -0.5]);
    metadata(&mut files, "+z", "up");
    assert_eq!(reason(describe(&files)), "INVALID_AXES");
}

#[test]
fn documents_may_begin_with_a_mark_and_may_not_be_utf_16() {
    let mut files = case();
    for name in ["metadata.json", "split.json", "mask/mask_info_0.json"] {
        let marked = [b"\xef\xbb\xbf".to_vec(), files[name].clone()].concat();
        files.insert(name.into(), marked);
    }
    expect_whole(&opened(&files).1);
    let text = String::from_utf8(case()["metadata.json"].clone()).unwrap();
    let wide: Vec<u8> =
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    files.insert("metadata.json".into(), wide);
    assert!(message(&files).contains("save it as UTF-8"));
}

#[test]
fn a_case_may_lie_anywhere_but_alone() {
    let at = |place: &str| -> FileMap {
        let moved = case().into_iter().map(|(name, bytes)| (format!("{place}/{name}"), bytes));
        moved.collect()
    };
    let deep = at("data/different_types/toy");
    for files in [deep.clone(), at("a/b/c/d/e/toy")] {
        let (_guard, recording) = opened(&files);
        assert_eq!(recording.name, "toy");
        expect_whole(&recording);
        let (_guard, path) = archive(&files);
        expect_whole(&raw::open(&path, &Limits::default()).unwrap());
    }
    let both: FileMap = deep.into_iter().chain(at("data/other_types/bear")).collect();
    let text = message(&both);
    assert!(text.contains("data/different_types/toy, data/other_types/bear"), "{text}");
    // A bundle inside a case is no second capture.
    let mut inner = case();
    inner.insert("results/capture.json".into(), b"{}".to_vec());
    expect_whole(&opened(&inner).1);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let mut files =
        renamed(|name, n| name.starts_with("color/1").then(|| format!("color/1/{n}.bmp")));
    let text = message(&files);
    for part in [
        "camera `right`",
        "no colour images",
        "`color/1/NUMBER.png`",
        "4 files (0.bmp, 1.bmp, 2.bmp, 3.bmp)",
    ] {
        assert!(text.contains(part), "{text} lacks {part}");
    }
    files.retain(|name, _| !name.starts_with("color/1"));
    let text = message(&files);
    assert!(text.contains("there is no `color/1`, and `color` has one folder (0)"), "{text}");
    files.insert("color/1.mp4".into(), b"video".to_vec());
    let text = message(&files);
    assert!(text.contains("ffmpeg -i color/1.mp4") && text.contains("color/1/%d.png"), "{text}");
    let only_color: FileMap = case().into_iter().filter(|(n, _)| !n.starts_with("depth")).collect();
    assert!(message(&only_color).contains("no depth images"));
}

#[test]
fn masks_need_labels_unless_their_folders_are_the_labels() {
    let mut files = case();
    files.remove("mask/mask_info_1.json");
    let text = message(&files);
    assert!(text.contains("masks in `mask/1` have the labels 0 (12.5 % of"), "{text}");
    assert!(text.contains("mask/mask_info_1.json"), "{text}");
    // Folders named by their label.
    let mut named = FileMap::new();
    for (name, bytes) in case() {
        let parts: Vec<&str> = name.split('/').collect();
        match parts.as_slice() {
            ["mask", camera, part, file] => {
                let part =
                    ["toy", "left_hand", "gripper", "handkerchief"][part.parse::<usize>().unwrap()];
                named.insert(format!("mask/{camera}/{part}/{file}"), bytes);
            }
            ["mask", _] => {}
            _ => drop(named.insert(name, bytes)),
        }
    }
    expect_whole(&opened(&named).1);
    // The only one is the object.
    let mut single = case();
    single.retain(|name, _| {
        !name.starts_with("mask") || (name.contains("/0/") && name.split('/').nth(2) == Some("0"))
    });
    single.insert("mask/1/0/0.png".into(), mask_png(0..1));
    let (_guard, recording) = opened(&single);
    let mut frames = recording.source.frames(1).unwrap();
    assert!(frames.mask(0, Region::Object).unwrap().is_some());
    assert!(frames.mask(0, Region::Manipulator).unwrap().is_none());
}

#[test]
fn labels_that_do_not_fit_their_folders_are_named() {
    let mut files = case();
    let info = br#"{"0": "toy", "1": "hand", "7": "gripper"}"#;
    files.insert("mask/mask_info_0.json".into(), info.to_vec());
    let (_guard, recording) = opened(&files);
    let note = recording.notes.iter().find(|n| n.code == "MASK_INFO_MISMATCH").unwrap();
    for part in ["7 (gripper)", "without a label, which are passed over: 2, 3"] {
        assert!(note.message.contains(part), "{}", note.message);
    }
    assert_eq!(note.cameras, [0]);
    files.insert("mask/mask_info_0.json".into(), br#"{"10": "toy", "11": "hand"}"#.to_vec());
    let text = message(&files);
    assert!(
        text.contains("10 (toy), 11 (hand)") && text.contains("4 folders (0, 1, 2, 3)"),
        "{text}"
    );
    files.insert("mask/mask_info_0.json".into(), br#"{"../0": "toy"}"#.to_vec());
    assert_eq!(reason(describe(&files)), "INVALID_DOCUMENT");
}

#[test]
fn labels_are_reported_and_the_description_decides() {
    let (_guard, recording) = opened(&case());
    let note = recording.notes.iter().find(|n| n.code == "MASK_LABELS").unwrap();
    assert!(note.message.contains("the object is `handkerchief`, `toy`"), "{}", note.message);
    assert!(note.message.contains("moves it is `Gripper2`, `left_hand`"), "{}", note.message);
    let mut files = case();
    for camera in 0..2 {
        let info = br#"{"0": "panda bear", "1": "hand", "2": "sleeve", "3": "Panda Bear"}"#;
        files.insert(format!("mask/mask_info_{camera}.json"), info.to_vec());
    }
    let text = message(&files);
    assert!(text.contains("`Panda Bear` may be") && text.contains("\"object_labels\""), "{text}");
    metadata(&mut files, "\"fps\"", "\"object_labels\": [\"panda bear\"], \"fps\"");
    expect_whole(&opened(&files).1);
    metadata(&mut files, "panda bear", "zebra");
    assert!(message(&files).contains("`zebra`, which is not one of them"));
}

#[test]
fn masks_of_16_bits_are_read_as_a_whole() {
    let mut files = case();
    let low: Vec<u8> =
        pixels().flat_map(|(c, _)| [0, if c == 0 || c == 3 { 255 } else { 0 }]).collect();
    let png = png_file(WIDTH, HEIGHT, ::png::ColorType::Grayscale, true, &low);
    files.insert("mask/0/0/0.png".into(), png);
    expect_whole(&opened(&files).1);
}

/// A description that names the files of one folder many times may not fill the memory.
#[test]
fn names_are_charged() {
    let (_guard, path) = archive(&case());
    let tight = Limits { total_bytes: 15_000, ..Limits::default() };
    assert_eq!(reason(raw::open(&path, &tight)), "CAPTURE_TOO_LARGE");
}

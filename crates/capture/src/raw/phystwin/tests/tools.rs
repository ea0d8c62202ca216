//! Masks as tools write them. All have the pixels of the tiny case: the object in the columns 0 and 3,
//! the hand in 1 and 2.

use serde_json::{Value, json};

use super::*;
use crate::{
    check::testing::{FileMap, pack},
    raw::testing::{floats_npy, mask_png, png_file},
};

/// The label of a column.
fn label(column: usize) -> u8 {
    match column {
        0 | 3 => 1,
        1 | 2 => 2,
        _ => 0,
    }
}

fn labels() -> Vec<u8> {
    pixels().map(|(column, _)| label(column)).collect()
}

/// The tiny case without masks.
fn bare() -> FileMap {
    case().into_iter().filter(|(name, _)| !name.starts_with("mask")).collect()
}

/// The tiny case with masks of each frame of a camera, and other files of each camera.
fn with(
    each: impl Fn(usize, usize) -> Vec<(String, Vec<u8>)>,
    whole: impl Fn(usize) -> Vec<(String, Vec<u8>)>,
) -> FileMap {
    let mut files = bare();
    for camera in 0..2 {
        files.extend(whole(camera));
        for frame in 0..FRAMES {
            files.extend(each(camera, frame));
        }
    }
    files
}

fn document(at: &str, value: &Value) -> (String, Vec<u8>) {
    (at.to_owned(), value.to_string().into_bytes())
}

/// Names of the labels for all cameras.
fn named(mut files: FileMap) -> FileMap {
    files.extend([document("mask/labels.json", &json!({"1": "toy", "2": "hand"}))]);
    files
}

fn expect(files: &FileMap) -> Recording {
    let (_guard, path) = archive(files);
    expect_whole(&raw::open(&path, &Limits::default()).unwrap());
    let folder = folder(files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    expect_whole(&recording);
    // What was read is what a push sends.
    let sent = crate::files_read(folder.path(), &Limits::default()).unwrap().files;
    let masks: Vec<&String> = files.keys().filter(|name| name.starts_with("mask")).collect();
    assert!(masks.iter().all(|name| sent.contains(name)), "{masks:?} {sent:?}");
    recording
}

fn refusal(files: &FileMap) -> String {
    assert_eq!(reason(describe(files)), "MASK_LABELS_UNCLEAR");
    describe(files).unwrap_err().to_string()
}

fn gray(values: &[u8]) -> Vec<u8> {
    png_file(WIDTH, HEIGHT, ::png::ColorType::Grayscale, false, values)
}

/// An image of indices of two bits, with the palette of DAVIS.
fn palette() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(::png::ColorType::Indexed);
    encoder.set_depth(::png::BitDepth::Two);
    encoder.set_palette(vec![0, 0, 0, 128, 0, 0, 0, 128, 0]);
    let packed = |four: &[u8]| four.iter().fold(0, |byte, index| byte << 2 | index);
    let data: Vec<u8> = labels().chunks(4).map(packed).collect();
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    bytes
}

#[test]
fn images_of_labels_are_read_by_number() {
    let color: Vec<u8> =
        labels().iter().flat_map(|l| [[0; 3], [255, 0, 0], [0, 9, 0]][*l as usize]).collect();
    let deep: Vec<u8> = labels().iter().flat_map(|label| [0, *label]).collect();
    for image in [
        gray(&labels()),
        palette(),
        png_file(WIDTH, HEIGHT, ::png::ColorType::Grayscale, true, &deep),
    ] {
        let each = |c, f| vec![(format!("mask/{c}/{f:05}.png"), image.clone())];
        let files = with(each, |_| Vec::new());
        let text = refusal(&files);
        for part in [
            "labels 1 (25.0 % of the image, moving 0 pixels), 2 (25.0 %",
            "`mask/labels.json`, as in {\"1\": \"object\", \"2\": \"hand\"}",
            "`mask/mask_info_0.json`",
            "docs/use/cameras.md#masks",
        ] {
            assert!(text.contains(part), "{text} lacks {part}");
        }
        let recording = expect(&named(files));
        let lines: Vec<String> = recording.sources.lines().collect();
        let line = "object masks of left: mask/0 (.png, label 1 is `toy`)";
        assert!(lines.iter().any(|l| l == line), "{lines:?}");
    }
    // Colours are labels too.
    let image = png_file(WIDTH, HEIGHT, ::png::ColorType::Rgb, false, &color);
    let mut files = with(|c, f| vec![(format!("mask/{c}/{f}.png"), image.clone())], |_| Vec::new());
    files.extend([document("mask/labels.json", &json!({"#ff0000": "toy", "#000900": "hand"}))]);
    expect(&files);
}

#[test]
fn documents_have_many_forms_and_places() {
    let image = gray(&labels());
    let files =
        with(|c, f| vec![(format!("masks/right{c}/{f}.png"), image.clone())], |_| Vec::new());
    let moved = |to: &dyn Fn(&str) -> String| -> FileMap {
        files
            .iter()
            .map(|(name, bytes)| (name.replace("masks/right", &to(name)), bytes.clone()))
            .collect()
    };
    for value in [
        json!({"1": "toy", "2": "hand"}),
        json!({"01": {"class_name": "toy"}, "2": {"name": "hand"}}),
        json!({"toy": 1, "hand": [2, 7]}),
        json!({"labels": {"1": {"instance_id": 1, "class_name": "toy"}, "2": {"class_name": "hand"}}}),
        json!([{"id": 1, "name": "toy"}, {"id": 2, "name": "hand"}]),
    ] {
        let mut files = moved(&|_| "mask/cam_".to_owned());
        files.extend([document("mask/labels.json", &value)]);
        expect(&files);
    }
    for place in ["mask/mask_info_{}.json", "mask/{}/labels.json", "mask/mask_info_{name}.json"] {
        let mut files = moved(&|_| "mask/".to_owned());
        for (camera, name) in ["left", "right"].iter().enumerate() {
            let at = place.replace("{}", &camera.to_string()).replace("{name}", name);
            files.extend([document(&at, &json!({"1": "toy", "2": "hand"}))]);
        }
        expect(&files);
    }
    for value in [json!("toy"), json!([1]), json!({"1": true}), json!({"1": {"score": 1}})] {
        let mut files = moved(&|_| "mask/".to_owned());
        files.extend([document("mask/labels.json", &value)]);
        assert_eq!(reason(describe(&files)), "INVALID_DOCUMENT", "{value}");
    }
}

#[test]
fn cameras_are_found_by_number_name_and_in_their_own_folders() {
    let image = gray(&labels());
    for [first, second] in [
        ["mask/left", "mask/right"],
        ["mask/Camera_0", "mask/camera_1"],
        ["masks/00", "masks/01"],
        ["left/mask", "right/mask"],
        ["cam0/masks", "cam1/masks"],
        ["mask/0/Annotations", "mask/1/Annotations"],
    ] {
        let each = |c, f| vec![(format!("{}/{f}.png", [first, second][c]), image.clone())];
        let mut files = with(each, |_| Vec::new());
        let root = if first.starts_with("mask") { first.split('/').next().unwrap() } else { "" };
        let at = format!("{root}/labels.json");
        files.extend([document(at.trim_start_matches('/'), &json!({"1": "toy", "2": "hand"}))]);
        let folder = folder(&files);
        expect_whole(&raw::open(folder.path(), &Limits::default()).unwrap());
    }
}

#[test]
fn a_folder_for_each_thing_may_have_arrays_and_numbers() {
    let mask = |of: u8| -> Vec<u8> { labels().iter().map(|l| u8::from(*l == of)).collect() };
    let parts = |names: [&'static str; 2], ending: &'static str, one: &dyn Fn(u8) -> Vec<u8>| {
        with(
            |c, f| {
                let file = |of: u8| {
                    (format!("mask/{c}/{}/{f:05}.{ending}", names[of as usize - 1]), one(of))
                };
                vec![file(1), file(2)]
            },
            |_| Vec::new(),
        )
    };
    let npy = |of| crate::npy::write("|b1", &[HEIGHT, WIDTH], &mask(of));
    expect(&parts(["object", "hand"], "npy", &npy));
    let squeezed = |of| crate::npy::write("|u1", &[1, HEIGHT, WIDTH], &mask(of));
    expect(&parts(["object", "hand"], "npy", &squeezed));
    let logits = |of| {
        floats_npy(&[HEIGHT, WIDTH], mask(of).iter().map(|m| if *m > 0 { 7.5 } else { -3.25 }))
    };
    expect(&parts(["object", "hand"], "npy", &logits));
    let shares = |of| {
        floats_npy(&[HEIGHT, WIDTH], mask(of).iter().map(|m| if *m > 0 { 0.75 } else { 0.25 }))
    };
    expect(&parts(["object", "hand"], "npy", &shares));
    // SAM 2's --per_obj_png_file: the example has the numbers that are there.
    let png = |of| gray(&mask(of));
    let numbered = parts(["001", "003"], "png", &png);
    let text = refusal(&numbered);
    assert!(text.contains("{\"001\": \"object\", \"003\": \"hand\"}"), "{text}");
    let mut files = numbered;
    files.extend([document("mask/labels.json", &json!({"1": "toy", "3": "hand"}))]);
    expect(&files);
}

#[test]
fn jpeg_masks_are_cut_at_half() {
    let bytes = include_bytes!("../../../../testdata/plain.jpg");
    let size = [16, 8];
    let color = crate::raw::ColorImage::decode("a.jpg", bytes, size).unwrap();
    let mask = crate::raw::Mask::decode("a.jpg", bytes, size).unwrap();
    let bright = |p: &[u8; 3]| p.iter().any(|level| *level >= 128);
    assert!(color.pixels.iter().zip(&mask.pixels).all(|(p, m)| bright(p) == *m));
}

#[test]
fn grounded_sam_2_names_its_numbers() {
    let wide: Vec<u8> = labels().iter().flat_map(|label| [*label, 0]).collect();
    let array = crate::npy::write("<u2", &[HEIGHT, WIDTH], &wide);
    let info = json!({
        "mask_name": "mask_00000.npy", "mask_height": HEIGHT, "mask_width": WIDTH, "promote_type": "mask",
        "labels": {"1": {"instance_id": 1, "class_name": "toy", "x1": 0, "logit": 0.0}, "2": {"instance_id": 2, "class_name": "hand"}},
    });
    let each = |c, f| {
        vec![
            (format!("mask/{c}/mask_data/mask_{f:05}.npy"), array.clone()),
            document(&format!("mask/{c}/json_data/mask_{f:05}.json"), &info),
        ]
    };
    expect(&with(each, |_| Vec::new()));
}

#[test]
fn one_file_may_have_all_frames() {
    let all: Vec<u8> = (0..FRAMES).flat_map(|_| labels()).collect();
    let mask = |of: u8| -> Vec<u8> { all.iter().map(|l| u8::from(*l == of)).collect() };
    let npy = |shape: &[usize], data: &[u8]| crate::npy::write("|u1", shape, data);
    let shape = [FRAMES, HEIGHT, WIDTH];
    let archive_of = |arrays: &[(&str, Vec<u8>)]| {
        pack(&arrays.iter().map(|(name, bytes)| (format!("{name}.npy"), bytes.clone())).collect())
    };
    let both = [mask(1), mask(2)].concat();
    let by_thing = npy(&[2, FRAMES, HEIGHT, WIDTH], &both);
    let ids = crate::npy::write("<i4", &[2], &[1, 0, 0, 0, 2, 0, 0, 0]);
    let frames: Vec<(String, Vec<u8>)> =
        (0..FRAMES).map(|f| (format!("arr_{f}"), npy(&[HEIGHT, WIDTH], &labels()))).collect();
    let frames: Vec<(&str, Vec<u8>)> =
        frames.iter().map(|(n, b)| (n.as_str(), b.clone())).collect();
    for (ending, file) in [
        ("npy", npy(&shape, &all)),
        ("npz", archive_of(&[("masks", npy(&shape, &all))])),
        ("npz", archive_of(&[("1", npy(&shape, &mask(1))), ("2", npy(&shape, &mask(2)))])),
        ("npz", archive_of(&[("masks", by_thing), ("obj_ids", ids)])),
        ("npz", archive_of(&frames)),
    ] {
        let whole = |c| vec![(format!("mask/{c}.{ending}"), file.clone())];
        let files = with(|_, _| Vec::new(), whole);
        assert!(refusal(&files).contains("have the labels 1, 2"));
        expect(&named(files));
    }
    // Named arrays, and named files.
    let words = archive_of(&[("toy", npy(&shape, &mask(1))), ("hand", npy(&shape, &mask(2)))]);
    expect(&with(|_, _| Vec::new(), |c| vec![(format!("mask/{c}.npz"), words.clone())]));
    let whole = |c| {
        let file = |name, of| (format!("mask/{c}/{name}.npy"), npy(&shape, &mask(of)));
        vec![file("toy", 1), file("hand", 2)]
    };
    expect(&with(|_, _| Vec::new(), whole));
    // Fortran order, and frames that are not those of the recording.
    let mut column_first = Vec::new();
    for (column, row) in (0..WIDTH).flat_map(|c| (0..HEIGHT).map(move |r| (c, r))) {
        column_first.extend((0..FRAMES).map(|f| all[(f * HEIGHT + row) * WIDTH + column]));
    }
    let header = "{'descr': '|u1', 'fortran_order': True, 'shape': (4, 6, 8), }\n";
    let mut fortran = b"\x93NUMPY\x01\x00".to_vec();
    fortran.extend((header.len() as u16).to_le_bytes());
    fortran.extend(header.as_bytes());
    fortran.extend(column_first);
    let whole = |c| vec![(format!("mask/{c}.npy"), fortran.clone())];
    expect(&named(with(|_, _| Vec::new(), whole)));
    let fewer = npy(&[FRAMES - 1, HEIGHT, WIDTH], &all[..(FRAMES - 1) * HEIGHT * WIDTH]);
    let files = with(|_, _| Vec::new(), |c| vec![(format!("mask/{c}.npy"), fewer.clone())]);
    assert_eq!(reason(describe(&files)), "WRONG_SHAPE");
}

/// Run lengths of the columns with a label.
fn rle(of: u8) -> Vec<u32> {
    let mut counts = vec![0];
    let mut shown = false;
    for column in 0..WIDTH {
        if (label(column) == of) != shown {
            shown = !shown;
            counts.push(0);
        }
        *counts.last_mut().unwrap() += HEIGHT as u32;
    }
    counts
}

/// The same as pycocotools write it.
fn text(counts: &[u32]) -> String {
    let mut out = String::new();
    for (index, count) in counts.iter().enumerate() {
        let mut x = i64::from(*count) - if index > 2 { i64::from(counts[index - 2]) } else { 0 };
        loop {
            let bits = x & 0x1f;
            x >>= 5;
            let more = if bits & 0x10 == 0 { x != 0 } else { x != -1 };
            out.push(char::from((bits | if more { 0x20 } else { 0 }) as u8 + 48));
            if !more {
                break;
            }
        }
    }
    out
}

#[test]
fn run_lengths_of_coco_are_read_wherever_tools_put_them() {
    // `pycocotools.mask.encode` of a mask of 6 rows and 8 columns with the columns 1 and 2.
    assert_eq!(text(&rle(2)), "6<n0");
    let plain = |of| json!({"size": [HEIGHT, WIDTH], "counts": rle(of)});
    let packed = |of| json!({"size": [HEIGHT, WIDTH], "counts": text(&rle(of))});
    for rle in [&plain as &dyn Fn(u8) -> Value, &packed] {
        let of_frame = [
            json!([{"id": 1, "segmentation": rle(1)}, {"id": 2, "segmentation": rle(2)}]),
            json!({"1": rle(1), "2": rle(2)}),
            json!({"1": {"segmentation": rle(1)}, "2": {"segmentation": rle(2)}}),
        ];
        for value in of_frame {
            let each = |c, f| vec![document(&format!("mask/{c}/{f:05}.json"), &value)];
            let files = with(each, |_| Vec::new());
            refusal(&files);
            expect(&named(files));
        }
        // Grounded SAM 2 with names.
        let value = json!({"image_path": "a/0.jpg", "img_width": 8, "annotations": [
            {"class_name": "toy", "bbox": [0, 0, 4, 6], "segmentation": rle(1), "score": [0.9]},
            {"class_name": "hand", "segmentation": rle(2)},
        ]});
        expect(&with(|c, f| vec![document(&format!("mask/{c}/{f}.json"), &value)], |_| Vec::new()));
        let of = |of: u8| (0..FRAMES).map(|_| rle(of)).collect::<Vec<_>>();
        let frames: Vec<Value> = (0..FRAMES).map(|_| json!({"1": rle(1), "2": rle(2)})).collect();
        let keyed: serde_json::Map<_, _> =
            frames.iter().enumerate().map(|(f, value)| (f.to_string(), value.clone())).collect();
        let annotations: Vec<Value> = (0..FRAMES * 2)
            .map(|i| {
                let (frame, of) = (i / 2, i % 2 + 1);
                json!({"id": i, "image_id": frame + 10, "category_id": of, "segmentation": rle(of as u8)})
            })
            .collect();
        let images: Vec<Value> = (0..FRAMES)
            .map(|f| json!({"id": f + 10, "file_name": format!("left/{f:06}.jpg")}))
            .collect();
        let numbered = [
            json!(frames),
            json!({"frames": frames}),
            json!(keyed),
            json!({"1": of(1), "2": of(2)}),
            json!([{"obj_id": 1, "segmentations": of(1)}, {"obj_id": 2, "segmentations": of(2)}]),
            json!({"images": images, "annotations": annotations}),
        ];
        for value in numbered {
            let files =
                with(|_, _| Vec::new(), |c| vec![document(&format!("mask/{c}.json"), &value)]);
            expect(&named(files));
        }
        let categories = json!([{"id": 1, "name": "toy"}, {"id": 2, "name": "hand"}]);
        let value = json!({"images": images, "annotations": annotations, "categories": categories});
        expect(&with(|_, _| Vec::new(), |c| vec![document(&format!("mask/{c}.json"), &value)]));
        let value = json!({"toy": of(1), "hand": of(2)});
        expect(&with(|_, _| Vec::new(), |c| vec![document(&format!("mask/{c}.json"), &value)]));
        let masklet: Vec<Value> = (0..FRAMES).map(|_| json!([rle(1), rle(2)])).collect();
        let mut files = with(
            |_, _| Vec::new(),
            |c| vec![document(&format!("mask/{c}.json"), &json!({"masklet": masklet}))],
        );
        files.extend([document("mask/labels.json", &json!({"0": "toy", "1": "hand"}))]);
        expect(&files);
    }
    for (value, wanted) in [
        (json!({"size": [6, 9], "counts": [54]}), "WRONG_IMAGE_SIZE"),
        (json!({"size": [6, 8], "counts": [49]}), "FILE_DAMAGED"),
        (json!({"size": [6, 8], "counts": "\u{7f}"}), "FILE_DAMAGED"),
        (json!({"size": 6, "counts": []}), "FILE_DAMAGED"),
        (json!({"segmentation": [[1, 2, 3, 4]]}), "INVALID_DOCUMENT"),
        (json!([{"segmentation": {"size": [6, 8], "counts": [48]}}]), "INVALID_DOCUMENT"),
    ] {
        let files = with(|_, _| Vec::new(), |c| vec![document(&format!("mask/{c}.json"), &value)]);
        assert_eq!(reason(describe(&files)), wanted, "{value}");
    }
}

/// Where there is one label, it is the object under any number.
#[test]
fn a_single_label_is_the_object() {
    let values: Vec<u8> = labels().iter().map(|l| if *l == 1 { 255 } else { 0 }).collect();
    let files = with(|c, f| vec![(format!("mask/{c}/{f}.png"), gray(&values))], |_| Vec::new());
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    let mut frames = recording.source.frames(1).unwrap();
    let mask = frames.mask(2, Region::Object).unwrap().unwrap();
    assert!(pixels().all(|(c, r)| mask.get(c, r) == Some(label(c) == 1)));
    assert!(frames.mask(2, Region::Manipulator).unwrap().is_none());
}

#[test]
fn files_that_are_not_read_are_left_out_and_not_sent() {
    let mut files = case();
    files.insert("mask/0/overlay.png".into(), b"a picture".to_vec());
    files.insert("mask/0/empty/readme.txt".into(), b"nothing".to_vec());
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    expect_whole(&recording);
    let left: Vec<&str> = recording.sources.left_out.iter().map(|l| l.from.as_str()).collect();
    assert_eq!(left, ["mask/0/empty", "files in mask/0"]);
    let sent = crate::files_read(folder.path(), &Limits::default()).unwrap().files;
    assert!(sent.contains(&"mask/0/2/1.png".to_owned()));
    assert!(!sent.iter().any(|name| name.contains("overlay") || name.contains("empty")));
}

#[test]
fn masks_of_no_camera_are_named() {
    let files =
        with(|c, f| vec![(format!("mask/eye{c}/{f}.png"), gray(&labels()))], |_| Vec::new());
    let recording = describe(&files).unwrap();
    let lines: Vec<String> = recording.sources.lines().collect();
    let line = "left out: mask: no name in it is the number or the name of a camera: `mask` has 2 folders (eye0, eye1)";
    assert!(lines.iter().any(|l| l == line), "{lines:?}");
}

/// Masks that were made later replace those of the recording.
#[test]
fn masks_are_added_to_a_recording_of_any_format() {
    let recorded = folder(&bare());
    let open = || raw::open(recorded.path(), &Limits::default()).unwrap();
    let below = |root: &str| -> FileMap {
        let image = gray(&labels());
        let all = (0..2).flat_map(|c| (0..FRAMES).map(move |f| format!("{root}{c}/{f:05}.png")));
        let mut files: FileMap = all.map(|name| (name, image.clone())).collect();
        files.extend([document(&format!("{root}labels.json"), &json!({"1": "toy", "2": "hand"}))]);
        files
    };
    for root in ["mask/", "", "masks of today/mask/"] {
        let (_guard, path) = archive(&below(root));
        let recording = open().with_mask_files(&path, &Limits::default()).unwrap();
        expect_whole(&recording);
        assert!(recording.notes.iter().any(|note| note.code == "MASK_LABELS"));
    }
    // Numbers from another one on, and a number behind the last frame.
    let later = |first: usize| -> FileMap {
        let moved = |name: String| match name.strip_suffix(".png") {
            Some(stem) => {
                let (folder, number) = stem.rsplit_once('/').unwrap();
                format!("{folder}/{}.png", number.parse::<usize>().unwrap() + first)
            }
            None => name,
        };
        below("mask/").into_iter().map(|(name, bytes)| (moved(name), bytes)).collect()
    };
    let (_guard, path) = archive(&later(100));
    expect_whole(&open().with_mask_files(&path, &Limits::default()).unwrap());
    let mut more = below("mask/");
    more.insert("mask/1/9.png".into(), gray(&labels()));
    let (_guard, path) = archive(&more);
    let error = open().with_mask_files(&path, &Limits::default());
    assert!(error.as_ref().is_err_and(|error| error.to_string().contains("has 4 frames")));
    assert_eq!(reason(error), "FRAME_NUMBERS_UNCLEAR");
    let mut unclear = below("mask/");
    unclear.extend([document("mask/labels.json", &json!({"1": "toy robot", "2": "hand"}))]);
    let (_guard, path) = archive(&unclear);
    let error = open().with_mask_files(&path, &Limits::default()).unwrap_err().to_string();
    assert!(error.contains("beside masks that are added `labels.json`"), "{error}");
    let (_guard, path) = archive(&FileMap::from([("readme.txt".to_owned(), b"no".to_vec())]));
    let error = open().with_mask_files(&path, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("docs/use/cameras.md#masks"), "{error}");
    let (_guard, path) = archive(&FileMap::from([("mask/0/1/0.png".to_owned(), mask_png(0..1))]));
    let recording = open().with_mask_files(&path, &Limits::default()).unwrap();
    assert!(recording.source.frames(0).unwrap().mask(0, Region::Object).unwrap().is_some());
    assert!(recording.source.frames(1).unwrap().mask(0, Region::Object).unwrap().is_none());
}

/// Each may have nothing to show, and is decoded to find out.
#[test]
fn many_files_of_all_frames_are_refused_before_they_are_decoded() {
    let mut files = bare();
    files.extend((0..65).map(|i| (format!("mask/0/{i}_of_65_x.npy"), b"none".to_vec())));
    assert!(matches!(describe(&files), Err(Error::TooMany { .. })));
}

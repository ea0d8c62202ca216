//! JSON documents of captures: other numbers, other types, nesting without end.

use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, samples};

/// Captures with faulty documents.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "a document with damage", make: |rng| put(rng, damage::any) },
    Fault { what: "a document with other numbers", make: |rng| put(rng, numbers) },
    Fault { what: "a document of another form", make: |rng| put(rng, form) },
    Fault { what: "a document of nested brackets", make: |rng| put(rng, brackets) },
    Fault { what: "a document without end", make: |rng| put(rng, long) },
    Fault { what: "a document for another reader", make: nerfstudio },
    Fault { what: "a document of a rig", make: rig },
];

/// Another value for a number, or for a word, of a document.
pub fn numbers(rng: &mut Rng, text: &[u8]) -> Vec<u8> {
    const TO: [&str; 14] = [
        "-1",
        "0",
        "NaN",
        "Infinity",
        "1e308",
        "1e999",
        "-1e-320",
        "18446744073709551615",
        "18446744073709551616",
        "9223372036854775808",
        "null",
        "\"4\"",
        "[]",
        "1.5",
    ];
    let text = String::from_utf8_lossy(text);
    let is_number = |c: char| c.is_ascii_digit() || ".-+e".contains(c);
    let bytes = text.as_bytes();
    let starts: Vec<usize> = (1..bytes.len())
        .filter(|i| bytes[*i].is_ascii_digit() && !is_number(char::from(bytes[*i - 1])))
        .collect();
    let Some(&start) = starts.get(rng.random_range(0..starts.len().max(1))) else {
        return text.into_owned().into_bytes();
    };
    let end = text[start..].find(|c| !is_number(c)).map_or(text.len(), |n| start + n);
    [&text[..start], TO[rng.random_range(0..TO.len())], &text[end..]].concat().into_bytes()
}

/// Brackets within brackets.
pub fn brackets(rng: &mut Rng, _text: &[u8]) -> Vec<u8> {
    let open = ["[", "{\"fps\":", "{\"cameras\":[", "[{\"\":"][rng.random_range(0..4)];
    open.repeat(rng.random_range(100..100_000)).into_bytes()
}

fn form(rng: &mut Rng, text: &[u8]) -> Vec<u8> {
    match rng.random_range(0..6) {
        0 => b"[]".to_vec(),
        1 => b"null".to_vec(),
        2 => [b"\xef\xbb\xbf", text].concat(),
        3 => text.iter().flat_map(|b| [*b, 0]).collect(),
        4 => [text, text].concat(),
        _ => String::from_utf8_lossy(text).replace("\"fps\"", "\"fps\": 1, \"fps\"").into_bytes(),
    }
}

fn long(rng: &mut Rng, text: &[u8]) -> Vec<u8> {
    let value = ["0,", "[],", "{},", "\"a\","][rng.random_range(0..4)];
    let list = format!("{{\"sequences\": [{}0],", value.repeat(rng.random_range(1000..100_000)));
    String::from_utf8_lossy(text).replacen('{', &list, 1).into_bytes()
}

fn put(rng: &mut Rng, change: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut files = archives::any_files(rng);
    let names: Vec<String> = files.keys().filter(|n| n.ends_with(".json")).cloned().collect();
    let name = &names[rng.random_range(0..names.len())];
    if let Some(text) = files.get_mut(name) {
        *text = change(rng, text);
    }
    archives::pack(&files)
}

/// A valid `transforms.json` for the images of the recording.
pub fn transforms() -> Vec<u8> {
    let frame = |camera: usize, frame: usize| {
        serde_json::json!({
            "file_path": format!("cameras/{camera}/color/{frame:06}.png"),
            "depth_file_path": format!("cameras/{camera}/depth/{frame:06}.png"),
            "mask_path": format!("cameras/{camera}/object/{frame:06}.png"),
            "transform_matrix": [
                [1.0, 0.0, 0.0, 0.05 * camera as f64], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.5],
                [0.0, 0.0, 0.0, 1.0],
            ],
            "camera_label": format!("cam{camera}"),
            "frame_index": frame,
        })
    };
    let frames: Vec<_> =
        (0..2).flat_map(|c| (0..samples::FRAMES).map(move |f| frame(c, f))).collect();
    serde_json::json!({
        "camera_model": "OPENCV", "fl_x": 20.0, "fl_y": 20.0, "cx": 8.0, "cy": 6.0,
        "w": samples::SIZE[0], "h": samples::SIZE[1], "k1": 0.0, "fps": 30.0, "up_axis": "+z",
        "depth_unit_scale_factor": 0.001, "ground": null, "frames": frames,
    })
    .to_string()
    .into_bytes()
}

/// Valid documents of grippers, for the images of the recording: with poses of each frame, and from
/// what the recording or a dataset has, which a raw bundle lacks.
pub fn grippers() -> Vec<Vec<u8>> {
    let poses = vec![[0.1, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0]; samples::FRAMES];
    let table = serde_json::json!({
        "file": "a.parquet", "episode": 1, "column": "action", "elements": [0, 1, 2, 3, 4, 5],
        "start_s": 0.5,
    });
    let all = [
        serde_json::json!({
            "name": "left", "poses": poses, "widths": vec![0.04; samples::FRAMES],
            "base": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
            "axes": {"approach": "+x", "opening": "-y"},
            "pad": {"length_m": 0.03, "breadth_m": 0.01},
        }),
        serde_json::json!({
            "poses": {"frame": "tcp"},
            "widths": {"joints": ["a", "b"], "topic": "/joints", "scale": 2.0, "offset_m": -0.01},
        }),
        serde_json::json!({
            "poses": {"lerobot": table, "rotation": "rotation_vector"},
            "widths": {"lerobot": table, "scale": 0.08, "offset_m": 0.0},
        }),
    ];
    let document = |gripper| serde_json::json!({"format": "bendtwin-grippers", "version": 1, "grippers": [gripper]});
    all.into_iter().map(|gripper| document(gripper).to_string().into_bytes()).collect()
}

/// Valid documents of a raw case, for the images of the recording: of cameras of different rates, with
/// depth of another camera, and with times.
pub fn metadata() -> Vec<Vec<u8>> {
    let lens = serde_json::json!([[20.0, 0, 7.5], [0, 20.0, 5.5], [0, 0, 1]]);
    let with = |more: serde_json::Value| {
        let mut all =
            serde_json::json!({"intrinsics": [lens, lens], "WH": samples::SIZE, "fps": 30.0});
        if let (Some(all), serde_json::Value::Object(more)) = (all.as_object_mut(), more) {
            all.extend(more);
        }
        all.to_string().into_bytes()
    };
    let times = |late: f64| {
        let time = |frame: usize| (frame.to_string(), (100.0 + late + frame as f64 / 30.0).into());
        serde_json::Value::Object((0..samples::FRAMES).map(time).collect())
    };
    vec![
        with(
            serde_json::json!({"fps": [30, 15], "frame_offsets": [0, 1], "serial_numbers": [1, "b"]}),
        ),
        with(serde_json::json!({
            "depth_intrinsics": lens, "depth_pose": [[1, 0, 0, 0.05], [0, 1, 0, 0], [0, 0, 1, 0]],
            "depth_size": [8, 6], "depth_distortion": [0.1, 0, 0, 0], "depth_unit_m": [0.001, 0.0001],
        })),
        with(serde_json::json!({
            "recording": {"0": times(0.0), "1": times(0.01)}, "image_orientation": "shown",
            "depth_folder": "depth",
        })),
    ]
}

/// The images of the recording under a faulty `metadata.json`.
fn rig(rng: &mut Rng) -> Vec<u8> {
    let change = [damage::any, numbers, form, brackets][rng.random_range(0..4)];
    let documents = metadata();
    let document = &documents[rng.random_range(0..documents.len())];
    let text = change(rng, document);
    archives::with(samples::raw_case(), "metadata.json", text)
}

/// The images of the recording under a faulty `transforms.json`.
fn nerfstudio(rng: &mut Rng) -> Vec<u8> {
    let change = [damage::any, numbers, form, brackets][rng.random_range(0..4)];
    let mut files = samples::raw_bundle();
    files.remove("capture.json");
    let text = change(rng, &transforms());
    archives::with(files, "transforms.json", text)
}

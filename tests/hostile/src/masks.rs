//! Masks of all frames of a camera: arrays and run lengths that are not those of its images.

use rand::RngExt as _;
use serde_json::{Value, json};

use crate::{Fault, Rng, archives, arrays, damage, documents, samples};

/// Faults of masks.
pub const FAULTS: &[Fault] = &[
    Fault { what: "masks with damage", make: |rng| any(rng, damage::any) },
    Fault { what: "masks with other numbers", make: |rng| any(rng, documents::numbers) },
    Fault { what: "run lengths of another image", make: lengths },
    Fault { what: "run lengths as text by chance", make: text },
    Fault { what: "masks of things without end", make: things },
    Fault { what: "masks of frames without end", make: frames },
    Fault { what: "masks in nested brackets", make: |rng| documents::brackets(rng, b"") },
    Fault { what: "masks of a huge shape", make: huge },
];

/// Captures with such masks.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "a capture with faulty masks", make: in_capture },
    Fault { what: "a capture with faulty labels of masks", make: labels },
];

/// Names of the labels of [`valid`].
const NAMES: &[u8] = br#"{"1": "toy", "2": "hand", "0": "cloth"}"#;

/// Masks of two things in all frames, in each form.
pub fn valid() -> Vec<Vec<u8>> {
    let [width, height] = samples::SIZE;
    let pixels = width * height;
    let rle = |counts: Value| json!({"size": [height, width], "counts": counts});
    let of = |counts: Value| vec![rle(counts); samples::FRAMES];
    let keyed = json!({"1": of(json!([24, 48, 120])), "2": of(json!("h1h02"))});
    let coco = json!({
        "images": (0..samples::FRAMES).map(|f| json!({"id": f, "file_name": format!("{f}.jpg")})).collect::<Vec<_>>(),
        "categories": [{"id": 1, "name": "toy"}],
        "annotations": [{"image_id": 1, "category_id": 1, "segmentation": rle(json!([0, pixels]))}],
    });
    let labels: Vec<u8> = (0..pixels * samples::FRAMES).map(|i| (i % 3) as u8).collect();
    let array =
        arrays::with_data("|u1", &format!("({}, {height}, {width})", samples::FRAMES), &labels);
    let npz = archives::pack(&[("masks.npy".to_owned(), array.clone())].into());
    vec![keyed.to_string().into_bytes(), coco.to_string().into_bytes(), array, npz]
}

/// A recording whose first camera has these masks of all frames, and of its second frame.
pub fn capture(masks: Vec<u8>) -> [Vec<u8>; 2] {
    let ending = match masks.as_slice() {
        [b'P', b'K', ..] => "npz",
        [0x93, ..] => "npy",
        [0x89, ..] => "png",
        [0xff, ..] => "jpg",
        _ => "json",
    };
    let mut files = samples::raw_case();
    files.retain(|name, _| !name.starts_with("mask/"));
    files.insert("mask/labels.json".to_owned(), NAMES.to_vec());
    ["mask/0", "mask/0/1"]
        .map(|name| archives::with(files.clone(), &format!("{name}.{ending}"), masks.clone()))
}

fn any(rng: &mut Rng, change: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let all = valid();
    let masks = &all[rng.random_range(0..all.len())];
    change(rng, masks)
}

/// Masks of all frames with these run lengths.
fn with_counts(counts: &Value) -> Vec<u8> {
    let [width, height] = samples::SIZE;
    let rle = json!({"size": [height, width], "counts": counts});
    json!({"1": vec![rle; samples::FRAMES]}).to_string().into_bytes()
}

fn lengths(rng: &mut Rng) -> Vec<u8> {
    let numbers = [0, 1, 191, 192, 193, u64::from(u32::MAX), u64::from(u32::MAX) + 1, u64::MAX];
    let counts: Vec<u64> =
        (0..rng.random_range(0..6)).map(|_| numbers[rng.random_range(0..numbers.len())]).collect();
    with_counts(&json!(counts))
}

fn text(rng: &mut Rng) -> Vec<u8> {
    let letters: String =
        (0..rng.random_range(0..40)).map(|_| char::from(rng.random_range(48..112_u8))).collect();
    with_counts(&json!(letters))
}

fn things(rng: &mut Rng) -> Vec<u8> {
    let [width, height] = samples::SIZE;
    let rle = json!({"size": [height, width], "counts": [0, 1]});
    let count = rng.random_range(100..5000);
    let all: serde_json::Map<_, _> = (0..count).map(|i| (i.to_string(), rle.clone())).collect();
    json!(vec![Value::Object(all); samples::FRAMES]).to_string().into_bytes()
}

fn frames(rng: &mut Rng) -> Vec<u8> {
    let [width, height] = samples::SIZE;
    let rle = json!({"size": [height, width], "counts": [0, 1]});
    let frame = [4, 1000, u64::from(u32::MAX), u64::MAX][rng.random_range(0..4)];
    json!([{"frame_index": frame, "obj_id": 1, "segmentation": rle}]).to_string().into_bytes()
}

fn huge(rng: &mut Rng) -> Vec<u8> {
    let shapes = [
        "(4, 12, 16, 1)",
        "(4, 1000000, 12, 16)",
        "(18446744073709551615, 12, 16)",
        "(0, 12, 16)",
        "(4, 0, 12, 16)",
        "(12, 16)",
        "(16, 12)",
    ];
    let types = ["|u1", "|b1", "<i8", "<f4"];
    let shape = shapes[rng.random_range(0..shapes.len())];
    arrays::with_data(types[rng.random_range(0..types.len())], shape, &[7; 768])
}

fn in_capture(rng: &mut Rng) -> Vec<u8> {
    let masks = (FAULTS[rng.random_range(0..FAULTS.len())].make)(rng);
    let [whole, single] = capture(masks);
    if rng.random() { whole } else { single }
}

fn labels(rng: &mut Rng) -> Vec<u8> {
    let change = [damage::any, documents::numbers, documents::brackets][rng.random_range(0..3)];
    let names = change(rng, NAMES);
    let mut files = samples::raw_case();
    files.retain(|name, _| !name.starts_with("mask/mask_info"));
    archives::with(files, "mask/labels.json", names)
}

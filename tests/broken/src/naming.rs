//! Names, numbers and labels as labs write them: read, or refused with what lies there.

use crate::{
    Broken,
    Expected::{Refused, Sound},
    Make, broken,
    files::{FileMap, bundle, npy, reword},
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [numbers(), images(), labels()].concat()
}

fn read(name: &'static str, code: &'static str, change: fn(&mut FileMap)) -> Broken {
    broken(name, Sound(code), Make::Case(change))
}

fn refused(name: &'static str, reason: &'static str, change: fn(&mut FileMap)) -> Broken {
    broken(name, Refused(reason), Make::Case(change))
}

fn numbers() -> Vec<Broken> {
    vec![
        read("frames numbered from 1", "FRAMES_NUMBERED", |f| {
            rename(f, "", |n, ending| format!("{}.{ending}", n + 1));
        }),
        read("names with zeros before the number", "MASK_LABELS", |f| {
            rename(f, "", |n, ending| format!("{n:06}.{ending}"));
        }),
        refused("colour numbered from 1 and depth from 0", "FRAME_NUMBERS_UNCLEAR", |f| {
            rename(f, "color/", |n, ending| format!("{}.{ending}", n + 1));
        }),
        refused("masks numbered from 1 and images from 0", "FRAME_NUMBERS_UNCLEAR", |f| {
            rename(f, "mask/", |n, ending| format!("{}.{ending}", n + 1));
        }),
        read("no number of frames", "MASK_LABELS", |f| reword(f, "\"frame_num\":36,", "")),
        refused("fewer frames than images", "FRAME_NUMBERS_UNCLEAR", |f| {
            reword(f, "\"frame_num\":36", "\"frame_num\":30");
        }),
        refused("more frames than images", "FRAME_NUMBERS_UNCLEAR", |f| {
            reword(f, "\"frame_num\":36", "\"frame_num\":40");
        }),
        refused("times for the names of images", "FRAME_NUMBERS_UNCLEAR", |f| {
            reword(f, "\"frame_num\":36,", "");
            rename(f, "", |n, ending| format!("{}.{ending}", 1_700_000_000_000_u64 + 33 * n));
        }),
    ]
}

fn images() -> Vec<Broken> {
    vec![
        read("colour as .jpg", "MASK_LABELS", |f| {
            rename(f, "color/", |n, _| format!("frame_{n:04}.jpg"));
        }),
        read("depth as PNG", "MASK_LABELS", |f| {
            f.retain(|name, _| !name.starts_with("depth/"));
            for (name, bytes) in bundle() {
                let parts: Vec<&str> = name.split('/').collect();
                if let ["cameras", camera, "depth", file] = parts.as_slice() {
                    f.insert(format!("depth/{camera}/{file}"), bytes.clone());
                }
            }
        }),
        read("depth in metres", "MASK_LABELS", |f| {
            let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (120, 160), }";
            for (_, bytes) in f.iter_mut().filter(|(name, _)| name.starts_with("depth/")) {
                let numbers = bytes[bytes.len() - 160 * 120 * 2..].as_chunks().0.iter();
                let metres = numbers.map(|n| f32::from(u16::from_le_bytes(*n)) / 1000.0);
                *bytes = npy(header, &metres.flat_map(f32::to_le_bytes).collect::<Vec<_>>());
            }
        }),
        refused("colour as .bmp", "IMAGES_NOT_FOUND", |f| {
            rename(f, "color/", |n, _| format!("{n}.bmp"));
        }),
        refused("videos for colour", "FORMAT_NOT_READ", |f| {
            f.retain(|name, _| !name.starts_with("color/"));
            for camera in 0..3 {
                f.insert(format!("color/{camera}.mp4"), b"\0\0\0\x20ftypisom".to_vec());
            }
        }),
        read("documents with a mark before them", "MASK_LABELS", |f| {
            for name in ["metadata.json", "split.json"] {
                let bytes = f.get_mut(name).expect("it is there");
                bytes.splice(0..0, *b"\xef\xbb\xbf");
            }
        }),
        refused("a description in UTF-16", "INVALID_DOCUMENT", |f| {
            let text = String::from_utf8_lossy(&f["metadata.json"]).into_owned();
            let wide = std::iter::once(0xFEFF).chain(text.encode_utf16());
            f.insert("metadata.json".to_owned(), wide.flat_map(u16::to_le_bytes).collect());
        }),
    ]
}

fn labels() -> Vec<Broken> {
    vec![
        read("a person for a hand", "MASK_LABELS", |f| label(f, "toy", "person")),
        read("a robot's arm for a hand", "MASK_LABELS", |f| label(f, "toy", "panda arm")),
        refused("a panda for a toy", "MASK_LABELS_UNCLEAR", |f| label(f, "panda", "hand")),
        refused("a hand towel", "MASK_LABELS_UNCLEAR", |f| label(f, "hand towel", "hand")),
        refused("labels of nothing that moves", "MASK_LABELS_UNCLEAR", |f| label(f, "toy", "rig")),
        refused("masks without labels", "MASK_LABELS_UNCLEAR", |f| {
            f.remove("mask/mask_info_1.json");
        }),
        refused("labels of other masks", "MASK_LABELS_UNCLEAR", |f| {
            let info = br#"{"5": "toy", "6": "hand"}"#;
            f.insert("mask/mask_info_2.json".to_owned(), info.to_vec());
        }),
    ]
}

/// Other names for the images below a folder, by their number and extension.
fn rename(files: &mut FileMap, below: &str, name: impl Fn(u64, &str) -> String) {
    let new = |old: &str| {
        let (folder, file) = old.rsplit_once('/')?;
        let kinds = ["color/", "depth/", "mask/"];
        let is_image = kinds.iter().any(|kind| old.starts_with(kind)) && old.starts_with(below);
        let (number, ending) = file.split_once('.').filter(|_| is_image)?;
        Some(format!("{folder}/{}", name(number.parse().ok()?, ending)))
    };
    let renamed = std::mem::take(files).into_iter();
    files.extend(renamed.map(|(old, bytes)| (new(&old).unwrap_or(old), bytes)));
}

/// Labels the masks of all cameras.
fn label(files: &mut FileMap, object: &str, hand: &str) {
    for camera in 0..3 {
        let info = format!("{{\"0\": \"{object}\", \"1\": \"{hand}\"}}");
        files.insert(format!("mask/mask_info_{camera}.json"), info.into_bytes());
    }
}

//! Names, numbers and labels as labs write them: read, or refused with what lies there.

use crate::{
    Broken,
    Expected::{Found, Refused, Sound},
    Make, broken,
    files::{FileMap, bundle, npy, reword},
};

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    [numbers(), images(), labels(), rigs()].concat()
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

/// Cameras, folders and units of other rigs.
fn rigs() -> Vec<Broken> {
    vec![
        read("a camera of half the rate", "CAMERA_SLOWER", |f| {
            reword(f, "\"frame_num\":36,", "");
            reword(f, "\"fps\":30.0", "\"fps\":[30, 15, 30]");
            at_half_rate(f);
        }),
        broken(
            "a camera of half the rate that nothing tells",
            Found("CAMERA_RATE_UNCLEAR"),
            Make::Case(|f| {
                reword(f, "\"frame_num\":36,", "");
                at_half_rate(f);
            }),
        ),
        read("a camera that began three frames late", "FRAMES_SHARED", |f| {
            reword(f, "\"fps\"", "\"frame_offsets\":[0, 3, 0],\"fps\"");
            reword(f, "\"frame_num\":36,", "");
            f.remove("gt_track_3d.pkl");
            renumber_camera_1(f, |n| n.checked_sub(3));
        }),
        refused("cameras without a frame in common", "LENGTH_MISMATCH", |f| {
            reword(f, "\"fps\"", "\"frame_offsets\":[0, 90, 0],\"fps\"");
        }),
        refused("the units in a metre for a unit", "INVALID_DOCUMENT", |f| {
            reword(f, "\"fps\"", "\"depth_scale\":1000,\"fps\"");
        }),
        refused("pictures of depth", "WRONG_DTYPE", |f| {
            let header = "{'descr': '|u1', 'fortran_order': False, 'shape': (120, 160), }";
            for (_, bytes) in f.iter_mut().filter(|(name, _)| name.starts_with("depth/")) {
                *bytes = npy(header, &vec![90; 160 * 120]);
            }
        }),
        refused("colour that is to be shown upside down", "IMAGE_TURNED", |f| {
            for (_, bytes) in f.iter_mut().filter(|(name, _)| name.starts_with("color/2/")) {
                orient(bytes, 3);
            }
        }),
        read("colour that its size shows to be upright", "IMAGE_TURNED", |f| {
            for (_, bytes) in f.iter_mut().filter(|(name, _)| name.starts_with("color/2/")) {
                orient(bytes, 6);
            }
        }),
        read("folders by serial numbers", "MASK_LABELS", |f| {
            place(f, |kind, camera, rest| format!("{kind}/02362227088{camera}/{rest}"));
            let text = String::from_utf8_lossy(&f["metadata.json"]).into_owned();
            let (before, rest) = text.split_once("\"serial_numbers\":[").expect("it has them");
            let (_, after) = rest.split_once(']').expect("they end");
            let serials = (0..3).map(|c| format!("\"02362227088{c}\"")).collect::<Vec<_>>();
            let text = format!("{before}\"serial_numbers\":[{}]{after}", serials.join(","));
            f.insert("metadata.json".to_owned(), text.into_bytes());
        }),
        read("a folder for each camera", "MASK_LABELS", |f| {
            place(f, |kind, camera, rest| format!("cam{camera}/{kind}/{rest}"));
        }),
        read("folders of cameras that are counted from 1", "CAMERAS_BY_ORDER", |f| {
            place(f, |kind, camera, rest| format!("{kind}/cam{}/{rest}", camera + 1));
        }),
        refused("a folder of depth that is not there", "INVALID_DOCUMENT", |f| {
            reword(f, "\"fps\"", "\"depth_folder\":\"depth_ffs\",\"fps\"");
        }),
        refused("the place of a depth camera without its lens", "INVALID_DOCUMENT", |f| {
            reword(f, "\"fps\"", "\"depth_pose\":[[1,0,0,0],[0,1,0,0],[0,0,1,0]],\"fps\"");
        }),
        broken(
            "the place of a depth camera in millimetres",
            Refused("INVALID_CAMERA"),
            Make::Case(|f| {
                let lens = "[[150,0,80],[0,150,60],[0,0,1]]";
                let pose = "[[1,0,0,15],[0,1,0,0],[0,0,1,0]]";
                let keys = format!("\"depth_intrinsics\":{lens},\"depth_pose\":{pose},\"fps\"");
                reword(f, "\"fps\"", &keys);
            }),
        ),
    ]
}

/// Every second image of camera 1, numbered one after another.
fn at_half_rate(files: &mut FileMap) {
    renumber_camera_1(files, |n| n.is_multiple_of(2).then_some(n / 2));
}

/// Other numbers for the images of camera 1, which loses its tracks; images without a number go.
fn renumber_camera_1(files: &mut FileMap, to: impl Fn(u64) -> Option<u64>) {
    files.remove("cotracker/1.npz");
    let renumbered = std::mem::take(files).into_iter().filter_map(|(name, bytes)| {
        let image = name.rsplit_once('/').filter(|_| of_camera_1(&name));
        let Some((folder, file)) = image else { return Some((name, bytes)) };
        let (number, ending) = file.split_once('.')?;
        let number = to(number.parse().ok()?)?;
        Some((format!("{folder}/{number}.{ending}"), bytes))
    });
    files.extend(renumbered);
}

fn of_camera_1(name: &str) -> bool {
    ["color/1/", "depth/1/", "mask/1/"].iter().any(|folder| name.starts_with(folder))
}

/// Other places for colour and depth, by kind, camera and the rest of the name.
fn place(files: &mut FileMap, to: impl Fn(&str, usize, &str) -> String) {
    let moved = std::mem::take(files).into_iter().map(|(name, bytes)| {
        let parts: Vec<&str> = name.splitn(3, '/').collect();
        let new = match parts.as_slice() {
            [kind @ ("color" | "depth"), camera, rest] => {
                camera.parse().ok().map(|camera| to(kind, camera, rest))
            }
            _ => None,
        };
        (new.unwrap_or(name), bytes)
    });
    files.extend(moved);
}

/// Makes a PNG declare an orientation, in a chunk after its header.
fn orient(image: &mut Vec<u8>, orientation: u8) {
    let mut exif = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    let mut chunk = (exif.len() as u32).to_be_bytes().to_vec();
    chunk.extend(b"eXIf");
    chunk.extend(&exif);
    let sum = crc32fast::hash(&chunk[4..]);
    chunk.extend(sum.to_be_bytes());
    image.splice(33..33, chunk);
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

//! Cases of other rigs: cameras of other rates, depth of other units and forms, folders of other
//! programs.

use bendtwin_core::Severity;

use super::{
    spellings::{FileMap, message, metadata, opened},
    *,
};
use crate::{
    npy,
    raw::testing::{floats_npy, png_file},
};

pub(super) fn listed(recording: &Recording) -> String {
    recording.sources.lines().collect::<Vec<_>>().join("\n")
}

/// The tiny case with more in its description.
fn with(keys: &str) -> FileMap {
    let mut files = case();
    metadata(&mut files, "\"fps\"", &format!("{keys}, \"fps\""));
    files
}

/// Depth of all images through `write`, which gets the numbers of one [mm].
fn rewrite_depth(files: &mut FileMap, write: impl Fn(&[u16]) -> (Vec<u8>, &'static str)) {
    for camera in 0..2 {
        for frame in 0..FRAMES {
            let numbers: Vec<u16> =
                pixels().map(|(c, r)| depth_mm_at(camera, frame, c, r)).collect();
            files.remove(&format!("depth/{camera}/{frame}.npy"));
            let (bytes, ending) = write(&numbers);
            files.insert(format!("depth/{camera}/{frame}.{ending}"), bytes);
        }
    }
}

#[test]
fn what_was_taken_is_listed() {
    let (_guard, recording) = opened(&case());
    let lines = listed(&recording);
    for part in [
        "colour of left: color/0 (PNG)",
        "depth of right: depth/1 (uint16, 1 is 0.001 m by default)",
        "tracks of left: cotracker/0.npz (`tracks` [T, N, 2] as row, column, `visibility`)",
        "pose: calibrate.pkl (camera to world, in the cameras' order)",
        "mesh: shape/matching/final_mesh.glb (in the world)",
        "split: split.json",
    ] {
        assert!(lines.contains(part), "{lines}\nlacks {part}");
    }
    assert!(recording.sources.left_out.is_empty());
}

#[test]
fn units_of_depth_may_be_given_for_each_camera() {
    let first = |files: &FileMap, camera: usize| {
        let (_guard, recording) = opened(files);
        let mut frames = recording.source.frames(camera).unwrap();
        frames.depth(0).unwrap().unwrap().pixels[WIDTH]
    };
    let plain = [first(&case(), 0), first(&case(), 1)];
    let files = with("\"depth_scale\": [0.001, 0.0001]");
    assert_eq!(first(&files, 0), plain[0]);
    assert!((first(&files, 1) - plain[1] / 10.0).abs() < 1e-7);
    let text = message(&with("\"depth_scale\": [0.001]"));
    assert!(text.contains("`depth_scale`") && text.contains("1 values for 2 cameras"), "{text}");
    let text = message(&with("\"depth_scale\": \"mm\""));
    assert!(text.contains("one value, or a list with one for each camera"), "{text}");
}

#[test]
fn units_in_a_metre_are_refused_with_the_reciprocal() {
    for key in ["depth_scale", "depth_unit_m"] {
        let text = message(&with(&format!("\"{key}\": 1000")));
        assert!(
            text.contains(&format!("`{key}` is 1000")) && text.contains("give 0.001"),
            "{text}"
        );
    }
    for wrong in ["-1", "0", "[0.001, -1]"] {
        assert_eq!(
            reason(describe(&with(&format!("\"depth_scale\": {wrong}")))),
            "INVALID_DOCUMENT"
        );
    }
}

#[test]
fn depth_may_be_float16_and_signed() {
    let mut halves = case();
    rewrite_depth(&mut halves, |numbers| {
        // Powers of two and their halves are exact in half precision.
        let bits = |n: &u16| if *n == 0 { 0_u16 } else { 0x3800 };
        let data: Vec<u8> = numbers.iter().flat_map(|n| bits(n).to_le_bytes()).collect();
        (npy::write("<f2", &[HEIGHT, WIDTH], &data), "npy")
    });
    let (_guard, recording) = opened(&halves);
    let depth = recording.source.frames(0).unwrap().depth(1).unwrap().unwrap();
    assert_eq!((depth.pixels[0], depth.pixels[WIDTH]), (0.0, 0.5));
    assert!(
        listed(&recording).contains("float16, 1 is 1 m by their size"),
        "{}",
        listed(&recording)
    );
    let mut signed = case();
    rewrite_depth(&mut signed, |numbers| {
        let data: Vec<u8> = numbers.iter().flat_map(|n| i32::from(*n).to_le_bytes()).collect();
        (npy::write("<i4", &[HEIGHT, WIDTH], &data), "npy")
    });
    expect_whole(&opened(&signed).1);
}

#[test]
fn pictures_of_depth_are_refused_once() {
    let gray = |numbers: &[u16]| {
        let data: Vec<u8> = numbers.iter().map(|n| *n as u8).collect();
        (png_file(WIDTH, HEIGHT, ::png::ColorType::Grayscale, false, &data), "png")
    };
    let colors = |numbers: &[u16]| {
        let data: Vec<u8> = numbers.iter().flat_map(|n| [*n as u8; 3]).collect();
        (png_file(WIDTH, HEIGHT, ::png::ColorType::Rgb, false, &data), "png")
    };
    let bytes = |numbers: &[u16]| {
        let data: Vec<u8> = numbers.iter().map(|n| *n as u8).collect();
        (npy::write("|u1", &[HEIGHT, WIDTH], &data), "npy")
    };
    for (write, found) in [
        (&gray as &dyn Fn(&[u16]) -> (Vec<u8>, &'static str), "gray of 8 bits"),
        (&colors, "colours of 8 bits"),
        (&bytes, "numbers of 8 bits"),
    ] {
        let mut files = case();
        rewrite_depth(&mut files, write);
        assert_eq!(reason(describe(&files)), "WRONG_DTYPE");
        let text = message(&files);
        assert!(text.contains(found) && text.contains("cameras.md#depth"), "{text}");
    }
    // One file among others is a damaged frame.
    let mut files = case();
    files.insert("depth/0/0.npy".into(), bytes(&[7; WIDTH * HEIGHT]).0);
    let (_guard, recording) = opened(&files);
    assert_eq!(reason(recording.source.frames(0).unwrap().depth(0)), "WRONG_DTYPE");
    assert!(recording.source.frames(0).unwrap().depth(1).unwrap().is_some());
}

/// Camera 1 has every second image, numbered one after another.
fn half_rate() -> FileMap {
    let mut files = FileMap::new();
    for (name, bytes) in case() {
        let parts: Vec<&str> = name.split('/').collect();
        match parts.as_slice() {
            ["color" | "depth" | "mask", "1", rest @ ..] if parts.len() > 2 => {
                let (number, ending) = rest.last().unwrap().split_once('.').unwrap();
                let number: usize = number.parse().unwrap();
                if number.is_multiple_of(2) {
                    let folder = name.rsplit_once('/').unwrap().0;
                    files.insert(format!("{folder}/{}.{ending}", number / 2), bytes);
                }
            }
            ["cotracker", "1.npz"] => {}
            _ => drop(files.insert(name, bytes)),
        }
    }
    files
}

#[test]
fn a_camera_may_have_half_the_rate() {
    let mut files = half_rate();
    metadata(&mut files, "\"fps\": 30.0", "\"fps\": [30, 15]");
    metadata(&mut files, "\"frame_num\": 4, ", "");
    let (_guard, recording) = opened(&files);
    // The last frame that both have is the slow camera's last.
    assert_eq!((recording.fps, recording.frame_count), (30.0, 3));
    assert_eq!((recording.cameras[0].fps, recording.cameras[1].fps), (None, Some(15.0)));
    let mut frames = recording.source.frames(1).unwrap();
    for (frame, there) in [(0, true), (1, false), (2, true)] {
        let color = frames.color(frame).unwrap();
        assert_eq!(color.map(|c| c.get(0, 0)), there.then_some(Some(color_at(1, frame, 0, 0))));
        assert_eq!(frames.mask(frame, Region::Object).unwrap().is_some(), there);
    }
    assert!(recording.source.frames(0).unwrap().color(1).unwrap().is_some());
    let wrong = |rates: &str| {
        let mut files = half_rate();
        metadata(&mut files, "\"fps\": 30.0", &format!("\"fps\": {rates}"));
        reason(describe(&files))
    };
    assert_eq!(
        (wrong("[30]"), wrong("[30, 0]"), wrong("[30, 1e-9]")),
        ("LENGTH_MISMATCH", "LENGTH_MISMATCH", "LENGTH_MISMATCH")
    );
}

#[test]
fn cameras_may_begin_at_different_times() {
    let files = with("\"frame_offsets\": [0, 1]");
    let (_guard, recording) = opened(&files);
    // Camera 1 took its image 0 in frame 1: frames 1 to 3 are those of both.
    assert_eq!((recording.frame_count, recording.train_frame_count), (3, 2));
    let shown = |camera: usize, frame: usize| {
        let mut frames = recording.source.frames(camera).unwrap();
        frames.color(frame).unwrap().unwrap().get(0, 0)
    };
    assert_eq!(shown(0, 0), Some(color_at(0, 1, 0, 0)));
    assert_eq!(shown(1, 0), Some(color_at(1, 0, 0, 0)));
    let tracks =
        |camera: usize| recording.source.frames(camera).unwrap().tracks().unwrap().unwrap();
    // In frame t of the case the first track is in row 1 + t.
    assert_eq!((tracks(0).points[0], tracks(1).points[0]), ([6.0, 2.0], [6.0, 1.0]));
    let note = recording.notes.iter().find(|n| n.code == "FRAMES_SHARED").unwrap();
    assert!(note.message.contains("have are 1 to 3;"), "{}", note.message);
    let text = message(&with("\"frame_offsets\": [0, 9]"));
    assert!(text.contains("no time in common") && text.contains("cameras.md#time"), "{text}");
    assert_eq!(
        reason(describe(&with("\"frame_offsets\": [0, 9000000000000000000]"))),
        "LENGTH_MISMATCH"
    );
}

/// Images that last longer than their numbers say.
#[test]
fn a_slow_camera_may_begin_with_the_end_of_a_fast_one() {
    // Frames 2 to 5 of camera 0 and 0 to 6 of camera 1.
    let mut files = with("\"frame_offsets\": [2, 0]");
    metadata(&mut files, "\"fps\": 30.0", "\"fps\": [30, 15]");
    let gripper = r#"{"format": "bendtwin-grippers", "version": 1, "grippers": [{"widths": [0.01, 0.02, 0.03, 0.04],
        "poses": [[0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0, 1], [2, 0, 0, 0, 0, 0, 1]]}]}"#;
    files.insert("grippers.json".into(), gripper.as_bytes().to_vec());
    let (_guard, recording) = opened(&files);
    assert_eq!(recording.frame_count, 4);
    let color = |camera: usize, frame: usize| {
        let mut frames = recording.source.frames(camera).unwrap();
        frames.color(frame).unwrap().map(|color| color.get(0, 0))
    };
    assert_eq!(color(0, 3), Some(Some(color_at(0, 3, 0, 0))));
    assert_eq!(color(1, 0), Some(Some(color_at(1, 1, 0, 0))));
    assert_eq!((color(1, 2), color(1, 3)), (Some(Some(color_at(1, 2, 0, 0))), None));
    assert_eq!(recording.source.color_stem(1, 2).as_deref(), Some("2"));
    assert!(recording.notes.iter().any(|note| note.code == "FRAMES_SHARED"));
    // Grippers are given in the same frames, as far as images have numbers.
    let gripper = &recording.grippers[0];
    let x = |frame: usize| gripper.poses[frame].map(|pose| pose.translation[0]);
    assert_eq!([x(0), x(1), x(2), x(3)], [Some(1.0), Some(2.0), None, None]);
    assert_eq!((gripper.widths_m.len(), gripper.widths_m[1]), (4, 0.04));
}

/// Each camera counts on its own, and `recording` has the times.
#[test]
fn images_before_the_alignment_are_assigned_by_their_times() {
    let mut files = FileMap::new();
    for (name, bytes) in case() {
        let parts: Vec<&str> = name.split('/').collect();
        match parts.as_slice() {
            ["color" | "depth" | "mask", "1", ..] if parts.len() > 2 => {
                let (folder, file) = name.rsplit_once('/').unwrap();
                let (number, ending) = file.split_once('.').unwrap();
                files.insert(
                    format!("{folder}/{}.{ending}", number.parse::<u64>().unwrap() + 3),
                    bytes,
                );
            }
            _ => drop(files.insert(name, bytes)),
        }
    }
    metadata(&mut files, "\"frame_num\": 4, ", "");
    let time = |number: usize, late: f64| 1.7e9 + number as f64 / 30.0 + late;
    let times = |first: usize, late: f64| {
        let entries = (0..FRAMES).map(|i| format!("\"{}\": {}", first + i, time(i, late)));
        entries.collect::<Vec<_>>().join(", ")
    };
    let recording =
        format!("\"recording\": {{\"0\": {{{}}}, \"1\": {{{}}}}}", times(0, 0.0), times(3, 0.002));
    metadata(&mut files, "\"fps\"", &format!("{recording}, \"fps\""));
    let (_guard, recording) = opened(&files);
    assert_eq!((recording.fps, recording.frame_count), (30.0, FRAMES));
    for camera in 0..2 {
        let mut frames = recording.source.frames(camera).unwrap();
        for frame in 0..FRAMES {
            let color = frames.color(frame).unwrap().unwrap();
            assert_eq!(color.get(0, 0), Some(color_at(camera, frame, 0, 0)));
        }
    }
    let late = recording.cameras[1].times_s[2] - recording.cameras[0].times_s[2];
    assert!((late - 0.002).abs() < 1e-6, "{late}");
    assert!(recording.notes.iter().any(|n| n.code == "FRAMES_BY_TIME"));
    // What other programs keep under that name is no alignment.
    expect_whole(&opened(&with("\"recording\": \"toy\"")).1);
}

#[test]
fn depths_beside_each_other_are_chosen_and_listed() {
    let mut files = case();
    for (name, bytes) in case() {
        if let Some(rest) = name.strip_prefix("depth/") {
            files.insert(format!("depth_ffs/{rest}"), bytes);
        }
    }
    files.insert(
        "depth_ffs/0/0.npy".into(),
        floats_npy(&[HEIGHT, WIDTH], vec![0.7; WIDTH * HEIGHT]),
    );
    let (_guard, recording) = opened(&files);
    expect_whole(&recording);
    assert!(
        listed(&recording).contains("left out: depth_ffs: `depth` was taken for depth"),
        "{}",
        listed(&recording)
    );
    metadata(&mut files, "\"fps\"", "\"depth_folder\": \"depth_ffs\", \"fps\"");
    let (_guard, recording) = opened(&files);
    assert_eq!(recording.source.frames(0).unwrap().depth(0).unwrap().unwrap().pixels[0], 0.7);
    assert!(listed(&recording).contains("left out: depth: "), "{}", listed(&recording));
}

/// The case with other names of folders.
fn moved(to: impl Fn(&str, usize, &str) -> String) -> FileMap {
    let mut files = FileMap::new();
    for (name, bytes) in case() {
        let parts: Vec<&str> = name.splitn(3, '/').collect();
        let new = match parts.as_slice() {
            [kind @ ("color" | "depth"), camera, rest] => to(kind, camera.parse().unwrap(), rest),
            _ => name.clone(),
        };
        files.insert(new, bytes);
    }
    files
}

#[test]
fn folders_may_be_named_by_cameras_and_kinds_as_programs_do() {
    let names = ["left", "right"];
    for files in [
        moved(|kind, camera, rest| format!("{kind}/{}/{rest}", names[camera])),
        moved(|kind, camera, rest| {
            format!("{}/cam{camera}/{rest}", if kind == "color" { "rgb" } else { kind })
        }),
        moved(|kind, camera, rest| format!("cam{camera}/{kind}/{rest}")),
        moved(|kind, camera, rest| {
            format!(
                "camera_{}/{}/{rest}",
                names[camera],
                if kind == "color" { "rgb" } else { "depth_raw" }
            )
        }),
    ] {
        let (_guard, recording) = opened(&files);
        expect_whole(&recording);
        assert!(!recording.notes.iter().any(|n| n.code == "CAMERAS_BY_ORDER"));
        let (_guard, path) = archive(&files);
        expect_whole(&raw::open(&path, &Limits::default()).unwrap());
    }
    // Numbers from 1 name no camera: their order does, which is said.
    let files = moved(|kind, camera, rest| format!("{kind}/cam{}/{rest}", camera + 1));
    let (_guard, recording) = opened(&files);
    expect_whole(&recording);
    let note = recording.notes.iter().find(|n| n.code == "CAMERAS_BY_ORDER").unwrap();
    assert!(
        note.severity == Severity::Info && note.message.contains("cam1, cam2"),
        "{}",
        note.message
    );
}

#[test]
fn masks_may_lie_beside_the_images_of_a_camera() {
    let mut files = FileMap::new();
    for (name, bytes) in case() {
        let parts: Vec<&str> = name.splitn(3, '/').collect();
        let new = match parts.as_slice() {
            [kind @ ("color" | "depth" | "mask"), camera, rest] => {
                format!("cam{camera}/{kind}/{rest}")
            }
            ["mask", info] => {
                format!("cam{}/mask_info.json", info.trim_matches(|c: char| !c.is_ascii_digit()))
            }
            _ => name.clone(),
        };
        files.insert(new, bytes);
    }
    expect_whole(&opened(&files).1);
}

#[test]
fn poses_may_be_a_dictionary_by_name() {
    let mut second = LOOKING_DOWN;
    second[0][3] = 0.4;
    let expected = {
        let mut files = case();
        files.insert("calibrate.pkl".into(), pickled(&[LOOKING_DOWN, second]));
        describe(&files).unwrap().cameras
    };
    for names in [["left", "right"], ["0", "1"], ["cam0", "cam1"], ["camera_left", "camera_right"]]
    {
        let mut files = case();
        files.remove("calibrate.pkl");
        let json = serde_json::json!({names[1]: second, names[0]: LOOKING_DOWN});
        files.insert("calibrate.json".into(), json.to_string().into_bytes());
        let found = describe(&files).unwrap();
        assert_eq!(found.cameras, expected, "{names:?}");
        assert!(listed(&found).contains("by the cameras' names"));
        // {name: array, ...} in protocol 3: each array is what the list holds.
        let mut pickle = b"\x80\x03}".to_vec();
        for (name, matrix) in [(names[1], second), (names[0], LOOKING_DOWN)] {
            let list = pickled(&[matrix]);
            pickle.extend(
                [b"X".as_slice(), &(name.len() as u32).to_le_bytes(), name.as_bytes()].concat(),
            );
            pickle.extend(&list[3..list.len() - 2]);
            pickle.push(b's');
        }
        pickle.push(b'.');
        let mut files = case();
        files.insert("calibrate.pkl".into(), pickle);
        assert_eq!(describe(&files).unwrap().cameras, expected, "{names:?}");
    }
    let mut files = case();
    files.remove("calibrate.pkl");
    let json = serde_json::json!({"top": LOOKING_DOWN, "side": second});
    files.insert("calibrate.json".into(), json.to_string().into_bytes());
    let text = message(&files);
    assert!(text.contains("poses of side, top") && text.contains("left, right"), "{text}");
}

#[test]
fn depth_of_another_camera_needs_both_its_lens_and_its_place() {
    let lens = "[[5.0, 0, 3.5], [0, 5.0, 2.5], [0, 0, 1]]";
    let near = "[[1, 0, 0, 0.02], [0, 1, 0, 0], [0, 0, 1, 0]]";
    let files = with(&format!("\"depth_intrinsics\": {lens}, \"depth_pose\": {near}"));
    let (_guard, recording) = opened(&files);
    let depth = recording.source.frames(0).unwrap().depth(0).unwrap().unwrap();
    assert_eq!((depth.width, depth.height), (WIDTH, HEIGHT));
    for keys in [
        format!("\"depth_pose\": {near}"),
        format!("\"depth_intrinsics\": {lens}, \"depth_distortion\": [1, 2, 3]"),
    ] {
        assert_eq!(reason(describe(&with(&keys))), "INVALID_DOCUMENT", "{keys}");
    }
    for keys in [
        format!(
            "\"depth_intrinsics\": {lens}, \"depth_pose\": [[1, 0, 0, 20], [0, 1, 0, 0], [0, 0, 1, 0]]"
        ),
        "\"depth_intrinsics\": [[0, 0, 3.5], [0, 5, 2.5], [0, 0, 1]]".to_owned(),
    ] {
        assert_eq!(reason(describe(&with(&keys))), "INVALID_CAMERA", "{keys}");
    }
    let huge = format!("\"depth_intrinsics\": {lens}, \"depth_size\": [100000, 100000]");
    assert_eq!(reason(describe(&with(&huge))), "CAPTURE_TOO_MANY");
}

use bendtwin_core::Problem as _;
use serde_json::{Value, json};

use super::*;
use crate::{
    Limits,
    check::testing::{FileMap, pack},
    raw::{
        self, Distortion, Region,
        testing::{
            FRAMES, HEIGHT, WIDTH, color_at, color_png, depth_mm_at, depth_npy, describe, folder,
            mask_png, pixels, reason,
        },
    },
};

/// A camera at (1, 2, 3) that looks down at a world with z up: OpenGL's own axes.
const LOOKING_DOWN: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]];

/// A document of two cameras in separate folders, numbered from 1.
fn document() -> Value {
    let frames: Vec<Value> =
        (0..2).flat_map(|camera| (0..FRAMES).map(move |frame| entry(camera, frame))).collect();
    json!({
        "camera_model": "OPENCV", "fl_x": 10.0, "fl_y": 11.0, "cx": 4.0, "cy": 3.0,
        "w": WIDTH, "h": HEIGHT, "k1": 0.1, "k2": 0.0, "p1": 0.01, "p2": 0.0,
        "fps": 25.0, "depth_unit_scale_factor": 0.001, "frames": frames,
        "ply_file_path": "ignored.ply", "aabb_scale": 16
    })
}

fn entry(camera: usize, frame: usize) -> Value {
    let number = frame + 1;
    json!({
        "file_path": format!("./cam{camera}/frame_{number:05}.png"),
        "depth_file_path": format!("depth{camera}/{number}.npy"),
        "mask_path": format!("mask{camera}/{number}.png"),
        "transform_matrix": LOOKING_DOWN
    })
}

fn files(document: &Value) -> FileMap {
    let mut files = FileMap::from([(MARKER.to_owned(), serde_json::to_vec(document).unwrap())]);
    for camera in 0..2 {
        for frame in 0..FRAMES {
            let number = frame + 1;
            files.insert(format!("cam{camera}/frame_{number:05}.png"), color_png(camera, frame));
            files.insert(format!("depth{camera}/{number}.npy"), depth_npy(camera, frame));
            files.insert(format!("mask{camera}/{number}.png"), mask_png(2..4));
        }
    }
    files
}

#[test]
fn cameras_in_folders_are_read() {
    let folder = folder(&files(&document()));
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    assert_eq!((recording.fps, recording.frame_count, recording.train_frame_count), (25.0, 4, 3));
    assert_eq!(recording.cameras.len(), 2);
    assert!(recording.environment.ground.is_none());
    let camera = &recording.cameras[1];
    assert_eq!(camera.name, "./cam1");
    assert_eq!((camera.intrinsics.cx, camera.intrinsics.cy), (3.5, 2.5));
    assert_eq!(
        camera.distortion,
        Distortion::BrownConrady([0.1, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0])
    );
    // It looks down: what it sees in the centre at 3 m lies below it at height 0.
    let point = camera.unproject([3.5, 2.5], 3.0, 0);
    assert!((0..3).all(|i| (point[i] - [1.0, 2.0, 0.0][i]).abs() < 1e-6), "{point:?}");
    // The image's upper edge is towards +y.
    assert!(camera.unproject([3.5, 0.0], 3.0, 0)[1] > 2.0);
    let mut frames = recording.source.frames(1).unwrap();
    let color = frames.color(2).unwrap().unwrap();
    let depth = frames.depth(2).unwrap().unwrap();
    for (c, r) in pixels() {
        assert_eq!(color.get(c, r), Some(color_at(1, 2, c, r)));
        assert_eq!(depth.get(c, r), Some(f32::from(depth_mm_at(1, 2, c, r)) / 1000.0));
    }
    assert_eq!(frames.mask(0, Region::Object).unwrap().unwrap().get(3, 0), Some(true));
    assert!(frames.mask(0, Region::Manipulator).unwrap().is_none());
    assert!(frames.tracks().unwrap().is_none());
}

#[test]
fn poses_may_lack_their_last_row_and_images_must_be_there() {
    let mut shorter = document();
    for entry in shorter["frames"].as_array_mut().unwrap() {
        entry["transform_matrix"].as_array_mut().unwrap().pop();
    }
    let whole = describe(&files(&document())).unwrap();
    assert_eq!(describe(&files(&shorter)).unwrap().cameras, whole.cameras);
    let mut files = files(&document());
    files.retain(|name, _| !name.starts_with("depth1"));
    let text = describe(&files).unwrap_err().to_string();
    assert!(text.contains("no depth images") && text.contains("`depth1/1.npy`"), "{text}");
}

/// A small archive may name one large image for every frame.
#[test]
fn pixels_are_counted_before_they_are_decoded() {
    let mut document = document();
    document["w"] = json!(5000);
    document["h"] = json!(5000);
    let sample = tempfile::tempdir().unwrap();
    let path = sample.path().join("recording.zip");
    std::fs::write(&path, pack(&files(&document))).unwrap();
    let refused = raw::open(&path, &Limits::default()).unwrap_err();
    assert_eq!(refused.reason(), "RECORDING_TOO_MANY_PIXELS", "{refused}");
    // 2 cameras x 3 kinds of images x 4 frames x 25 million pixels, and room for half of it.
    assert!(refused.to_string().contains("600000000 pixels"), "{refused}");
    assert!(refused.to_string().contains("at most 3 of its 4 frames"), "{refused}");
    // No limit on pixels applies to a folder: its owner may read anything in it.
    raw::open(folder(&files(&document)).path(), &Limits::default()).unwrap();
}

fn with(mut change: impl FnMut(usize, &mut Value)) -> Value {
    let mut document = document();
    let frames = document["frames"].as_array_mut().unwrap();
    frames.iter_mut().enumerate().for_each(|(i, frame)| change(i, frame));
    document
}

#[test]
fn times_align_cameras() {
    let document = with(|i, frame| {
        let (camera, number) = (i / FRAMES, i % FRAMES);
        frame["camera_label"] = json!(["left", "right"][camera]);
        frame["time"] = json!(100.0 + number as f64 / 20.0 + camera as f64 * 0.01);
        // Frame 2 of the right camera is missing in the list.
        if i == FRAMES + 2 {
            frame["time"] = json!(500.0);
        }
    });
    let text = describe(&files(&document)).unwrap_err().to_string();
    assert!(text.contains("`fps` is 25") && text.contains("20.00 in a second"), "{text}");
    let mut document = document;
    document["fps"] = Value::Null;
    let recording = describe(&files(&document)).unwrap();
    assert!((recording.fps - 20.0).abs() < 1e-6);
    assert_eq!(recording.frame_count, FRAMES);
    assert_eq!(recording.cameras[1].name, "right");
    let times = &recording.cameras[1].times_s;
    assert!((times[0] - 100.01).abs() < 1e-9 && times[2].is_nan() && !times[3].is_nan());
}

/// nerfstudio's scenes with motion have times from 0 to 1, which are no seconds.
#[test]
fn times_from_0_to_1_need_and_take_the_frame_rate() {
    let mut document = with(|i, frame| {
        frame["time"] = json!((i % FRAMES) as f64 / (FRAMES - 1) as f64);
    });
    let recording = describe(&files(&document)).unwrap();
    assert!((recording.fps - 25.0).abs() < 1e-6 && recording.frame_count == FRAMES);
    let times = &recording.cameras[0].times_s;
    assert!((times[3] - 3.0 / 25.0).abs() < 1e-9, "{times:?}");
    let lines: Vec<String> = recording.sources.lines().collect();
    assert!(lines.iter().any(|line| line.contains("`fps` counts")), "{lines:?}");
    document["fps"] = Value::Null;
    let text = describe(&files(&document)).unwrap_err().to_string();
    assert!(text.contains("from 0 to 1") && text.contains("add `fps`"), "{text}");
    // With numbers of frames the times add nothing.
    let mut numbered = with(|i, frame| {
        frame["time"] = json!((i % FRAMES) as f64 / (FRAMES - 1) as f64);
        frame["frame_index"] = json!(i % FRAMES);
    });
    numbered["fps"] = json!(30.0);
    let recording = describe(&files(&numbered)).unwrap();
    assert!(recording.fps == 30.0 && recording.cameras[0].times_s.is_empty());
}

#[test]
fn paths_may_have_the_separators_of_windows() {
    let windows = with(|_, frame| {
        for key in ["file_path", "depth_file_path", "mask_path"] {
            let path = frame[key].as_str().unwrap().trim_start_matches("./").replace('/', "\\");
            frame[key] = json!(path);
        }
    });
    let folder = folder(&files(&windows));
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    assert_eq!(recording.cameras.len(), 2);
    let mut frames = recording.source.frames(1).unwrap();
    assert_eq!(frames.color(2).unwrap().unwrap().get(3, 2), Some(color_at(1, 2, 3, 2)));
    let outside = with(|_, frame| frame["file_path"] = json!("cam\\..\\..\\0.png"));
    assert_eq!(refused(&outside), "INVALID_DOCUMENT");
}

#[test]
fn a_lens_may_stand_in_each_frame() {
    let mut document = with(|_, frame| {
        for (key, value) in
            [("fl_x", 10.0), ("fl_y", 11.0), ("cx", 4.0), ("cy", 3.0), ("w", 8.0), ("h", 6.0)]
        {
            frame[key] = json!(value);
        }
    });
    let whole = describe(&files(&document)).unwrap().cameras;
    for key in ["fl_x", "fl_y", "cx", "cy", "w", "h"] {
        document.as_object_mut().unwrap().remove(key);
    }
    assert_eq!(describe(&files(&document)).unwrap().cameras, whole);
}

#[test]
fn a_unit_of_depth_is_no_number_of_units_in_a_metre() {
    let mut document = document();
    document["depth_unit_scale_factor"] = json!(1000.0);
    let text = describe(&files(&document)).unwrap_err().to_string();
    assert!(
        text.contains("`depth_unit_scale_factor` is 1000") && text.contains("give 0.001"),
        "{text}"
    );
}

#[test]
fn a_camera_may_move() {
    let document = with(|i, frame| {
        frame["transform_matrix"][2][3] = json!(3.0 + (i % FRAMES) as f64);
    });
    let recording = describe(&files(&document)).unwrap();
    let heights: Vec<f64> =
        recording.cameras[0].poses.iter().map(|pose| pose.translation[2]).collect();
    assert_eq!(heights, [3.0, 4.0, 5.0, 6.0]);
}

#[test]
fn scale_and_axes_are_undone() {
    let mut document = document();
    document["applied_scale"] = json!(0.5);
    document["up_axis"] = json!("+y");
    let recording = describe(&files(&document)).unwrap();
    assert_eq!(recording.cameras[0].poses[0].translation, [2.0, -6.0, 4.0]);
}

fn refused(document: &Value) -> &'static str {
    reason(describe(&files(document)))
}

#[test]
fn what_is_no_video_with_depth_is_refused() {
    let one_folder = with(|i, frame| frame["file_path"] = json!(format!("images/{i}.png")));
    assert_eq!(refused(&one_folder), "INVALID_DOCUMENT");
    let no_depth = with(|_, frame| frame["depth_file_path"] = Value::Null);
    assert_eq!(refused(&no_depth), "INVALID_CAMERA");
    let twice = with(|_, frame| frame["frame_index"] = json!(3));
    assert_eq!(refused(&twice), "INVALID_DOCUMENT");
    let absurd = with(|i, frame| frame["frame_index"] = json!(i * 1_000_000_000));
    assert_eq!(refused(&absurd), "CAPTURE_TOO_MANY");
    let mirrored = with(|_, frame| frame["transform_matrix"][0][0] = json!(-1.0));
    assert_eq!(refused(&mirrored), "MIRRORED_EXTRINSICS");
    let outside = with(|_, frame| frame["file_path"] = json!("cam/../../0.png"));
    assert_eq!(refused(&with(|_, f| f["depth_file_path"] = json!("../0.png"))), "INVALID_DOCUMENT");
    assert_eq!(refused(&outside), "INVALID_DOCUMENT");
    let lenses = with(|i, frame| frame["fl_x"] = json!(10.0 + i as f64));
    assert_eq!(refused(&lenses), "INVALID_CAMERA");
    let many = with(|i, frame| frame["camera_label"] = json!(i));
    assert_ne!(refused(&many), "CAPTURE_TOO_MANY");
    for (key, value, expected) in [
        ("camera_model", json!("EQUIRECTANGULAR"), "INVALID_CAMERA"),
        ("k4", json!(0.1), "INVALID_CAMERA"),
        ("fps", Value::Null, "INVALID_DOCUMENT"),
        ("w", json!(8.5), "INVALID_CAMERA"),
        ("w", json!(1e8), "CAPTURE_TOO_MANY"),
        ("fl_x", Value::Null, "INVALID_CAMERA"),
        ("fl_x", json!(-1.0), "INVALID_CAMERA"),
        ("applied_scale", json!(0.0), "INVALID_DOCUMENT"),
        ("up_axis", json!("up"), "INVALID_AXES"),
        ("frames", json!([]), "INVALID_DOCUMENT"),
    ] {
        let mut document = document();
        document[key] = value;
        assert_eq!(refused(&document), expected, "{key}");
    }
}

#[test]
fn fisheye_lenses_keep_their_model() {
    let mut document = document();
    document["camera_model"] = json!("OPENCV_FISHEYE");
    document["k4"] = json!(0.5);
    let recording = describe(&files(&document)).unwrap();
    assert_eq!(recording.cameras[0].distortion, Distortion::KannalaBrandt([0.1, 0.0, 0.0, 0.5]));
}

mod calibration;
mod forms;
mod rigs;
mod spellings;
mod tools;

use super::*;
use crate::{
    Limits, Opened, open,
    raw::{
        self, Region,
        testing::{
            FRAMES, HEIGHT, LOOKING_DOWN, WIDTH, archive, case, color_at, depth_mm_at, depth_npy,
            describe, folder, pickled, pixels, png_claiming, reason,
        },
    },
};

fn expect_whole(recording: &Recording) {
    assert_eq!((recording.frame_count, recording.train_frame_count), (FRAMES, 3));
    assert_eq!(recording.fps, 30.0);
    assert_eq!(recording.cameras.len(), 2);
    assert_eq!(recording.cameras[1].name, "right");
    assert_eq!(recording.source_to_world, [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
    assert_eq!(recording.environment, Environment::Z_UP);
    for camera in 0..2 {
        let mut frames = recording.source.frames(camera).unwrap();
        for frame in [3, 0, 2, 1] {
            let color = frames.color(frame).unwrap().unwrap();
            let depth = frames.depth(frame).unwrap().unwrap();
            for (c, r) in pixels() {
                assert_eq!(color.get(c, r), Some(color_at(camera, frame, c, r)));
                let metres = f32::from(depth_mm_at(camera, frame, c, r)) / 1000.0;
                assert_eq!(depth.get(c, r), Some(metres));
            }
            // Parts 0 and 3, the toy and the handkerchief; parts 1 and 2, the hand and the gripper.
            let object = frames.mask(frame, Region::Object).unwrap().unwrap();
            let hand = frames.mask(frame, Region::Manipulator).unwrap().unwrap();
            for (c, r) in pixels() {
                assert_eq!(object.get(c, r), Some(c == 0 || c == 3));
                assert_eq!(hand.get(c, r), Some(c == 1 || c == 2));
            }
        }
        assert!(frames.color(FRAMES).unwrap().is_none());
        let tracks = frames.tracks().unwrap().unwrap();
        assert_eq!(tracks.count, 2);
        // The file has row 2, column 6 for the first track of frame 1.
        assert_eq!(tracks.points[2], [6.0, 2.0]);
        assert_eq!(tracks.visible[2..4], [true, false]);
    }
}

#[test]
fn a_case_is_read_from_a_folder_and_from_an_archive() {
    let folder = folder(&case());
    expect_whole(&raw::open(folder.path(), &Limits::default()).unwrap());
    let (_guard, path) = archive(&case());
    expect_whole(&raw::open(&path, &Limits::default()).unwrap());
    let nested = case().into_iter().map(|(name, bytes)| (format!("toy/{name}"), bytes)).collect();
    let (_guard, path) = archive(&nested);
    let recording = raw::open(&path, &Limits::default()).unwrap();
    assert_eq!(recording.name, "toy");
    expect_whole(&recording);
}

#[test]
fn the_world_is_turned_to_z_up() {
    let recording = describe(&case()).unwrap();
    let camera = &recording.cameras[0];
    // The camera hangs 0.5 m above the ground; what it sees at 0.5 m lies on it.
    assert_eq!(camera.poses[0].translation, [0.1, -0.2, 0.5]);
    let point = camera.unproject([3.5, 2.5], 0.5, 0);
    assert!((0..3).all(|i| (point[i] - [0.1, -0.2, 0.0][i]).abs() < 1e-6), "{point:?}");
    let mesh = recording.mesh.unwrap();
    assert_eq!(mesh.name, "final_mesh.glb");
    assert_eq!(mesh.to_world.unwrap().rotation, recording.source_to_world);
}

#[test]
fn processed_data_is_preferred_where_it_is_there() {
    let mut files = case();
    let folder = folder(&files);
    assert!(matches!(open(folder.path(), &Limits::default()).unwrap(), Opened::Raw(_)));
    assert_eq!(reason(crate::read(folder.path(), &Limits::default())), "RAW_CAPTURE");
    files.insert("final_data.pkl".into(), b"N.".to_vec());
    let folder = super::super::testing::folder(&files);
    assert_eq!(reason(open(folder.path(), &Limits::default())), "WRONG_DTYPE");
    assert!(raw::open(folder.path(), &Limits::default()).is_ok());
}

#[test]
fn missing_frames_have_no_images() {
    let mut files = case();
    files.remove("color/0/2.png");
    files.remove("depth/0/1.npy");
    files.remove("mask/0/0/0.png");
    files.remove("cotracker/0.npz");
    files.retain(|name, _| !name.starts_with("mask/1/"));
    files.remove("mask/mask_info_1.json");
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    let mut frames = recording.source.frames(0).unwrap();
    assert!(frames.color(2).unwrap().is_none() && frames.color(1).unwrap().is_some());
    assert!(frames.depth(1).unwrap().is_none() && frames.depth(2).unwrap().is_some());
    // The handkerchief's mask is still there.
    assert!(frames.mask(0, Region::Object).unwrap().is_some());
    assert!(frames.tracks().unwrap().is_none());
    let mut second = recording.source.frames(1).unwrap();
    assert!(second.mask(0, Region::Object).unwrap().is_none());
    assert_eq!(reason(recording.source.frames(2).map(|_| ())), "NO_SUCH_CAMERA");
}

#[test]
fn depth_of_a_lower_resolution_is_brought_onto_the_grid() {
    let mut files = case();
    let data: Vec<u8> = (1_u16..=12).flat_map(u16::to_le_bytes).collect();
    files.insert("depth/0/0.npy".into(), crate::npy::write("<u2", &[3, 4], &data));
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    let depth = recording.source.frames(0).unwrap().depth(0).unwrap().unwrap();
    assert_eq!((depth.width, depth.height), (WIDTH, HEIGHT));
    for (c, r) in pixels() {
        let nearest = (r / 2 * 4 + c / 2 + 1) as f32;
        assert!((depth.get(c, r).unwrap() - nearest / 1000.0).abs() < 1e-7);
    }
}

#[test]
fn many_readers_work_side_by_side() {
    let (_guard, path) = archive(&case());
    let recording = raw::open(&path, &Limits::default()).unwrap();
    std::thread::scope(|scope| {
        for thread in 0..8 {
            let recording = &recording;
            scope.spawn(move || {
                let camera = thread % 2;
                let mut frames = recording.source.frames(camera).unwrap();
                for frame in 0..FRAMES {
                    let color = frames.color(frame).unwrap().unwrap();
                    assert_eq!(color.get(3, 2), Some(color_at(camera, frame, 3, 2)));
                }
            });
        }
    });
}

/// Outcome of reading the tiny case with changed metadata.
fn with_metadata(from: &str, to: &str) -> &'static str {
    let mut files = case();
    let text = String::from_utf8(files["metadata.json"].clone()).unwrap();
    assert!(text.contains(from));
    files.insert("metadata.json".into(), text.replace(from, to).into_bytes());
    reason(describe(&files))
}

#[test]
fn impossible_descriptions_are_refused() {
    assert_eq!(with_metadata("\"frame_num\": 4", "\"frame_num\": 1000000000"), "CAPTURE_TOO_MANY");
    assert_eq!(with_metadata("\"frame_num\": 4", "\"frame_num\": -4"), "INVALID_DOCUMENT");
    assert_eq!(with_metadata("\"frame_num\": 4", "\"frame_num\": 0"), "LENGTH_MISMATCH");
    assert_eq!(with_metadata("\"fps\": 30.0", "\"fps\": 0.0"), "LENGTH_MISMATCH");
    assert_eq!(with_metadata("[8, 6]", "[100000, 100000]"), "CAPTURE_TOO_MANY");
    assert_eq!(with_metadata("[8, 6]", "[0, 6]"), "INVALID_CAMERA");
    assert_eq!(with_metadata("[10.0, 0.0, 3.5]", "[10.0, 0.2, 3.5]"), "INVALID_CAMERA");
    assert_eq!(with_metadata("[10.0, 0.0, 3.5]", "[-10.0, 0.0, 3.5]"), "INVALID_CAMERA");
    assert_eq!(with_metadata("[10.0, 0.0, 3.5]", "[NaN, 0.0, 3.5]"), "INVALID_DOCUMENT");
    assert_eq!(with_metadata("\"right\"]", "\"right\", \"third\"]"), "LENGTH_MISMATCH");
    let k = "[[10.0, 0.0, 3.5], [0.0, 11.0, 2.5], [0.0, 0.0, 1.0]]";
    let thousand = vec![k; 1000].join(", ");
    assert_eq!(with_metadata(&format!("{k}, {k}"), &thousand), "CAPTURE_TOO_MANY");
}

#[test]
fn impossible_poses_are_refused() {
    let with = |matrices: &[[[f64; 4]; 4]]| {
        let mut files = case();
        files.insert("calibrate.pkl".into(), pickled(matrices));
        describe(&files)
    };
    let change = |row: usize, column: usize, value: f64| {
        let mut m = LOOKING_DOWN;
        m[row][column] = value;
        with(&[LOOKING_DOWN, m])
    };
    assert_eq!(reason(change(0, 0, -1.0)), "MIRRORED_EXTRINSICS");
    assert_eq!(reason(change(0, 0, f64::NAN)), "INVALID_CAMERA");
    assert_eq!(reason(change(0, 3, f64::INFINITY)), "INVALID_CAMERA");
    assert_eq!(reason(change(0, 3, 1e9)), "INVALID_CAMERA");
    assert_eq!(reason(change(0, 0, 2.0)), "INVALID_CAMERA");
    assert_eq!(reason(change(3, 0, 0.5)), "INVALID_CAMERA");
    assert_eq!(reason(with(&[LOOKING_DOWN])), "LENGTH_MISMATCH");
    assert_eq!(reason(with(&[LOOKING_DOWN; 1000])), "CAPTURE_TOO_MANY");
    // Calibrations written with few digits become exact rotations.
    let rotation = change(0, 0, 0.999).unwrap().cameras[1].poses[0].rotation;
    assert!((rotation[0][0] - 1.0).abs() < 1e-12);
    let mut files = case();
    files.insert("calibrate.pkl".into(), b"\x80\x03cos\nsystem\n.".to_vec());
    assert_eq!(reason(describe(&files)), "PICKLE_GLOBAL_REFUSED");
}

#[test]
fn damaged_frames_are_refused_and_do_not_disturb_others() {
    let mut files = case();
    let color = files["color/0/0.png"].clone();
    files.insert("color/0/0.png".into(), color[..color.len() - 20].to_vec());
    files.insert("color/0/1.png".into(), png_claiming(100_000, 100_000));
    files.insert("color/0/2.png".into(), b"GIF89a".to_vec());
    let absurd = b"{'descr': '<u2', 'fortran_order': False, 'shape': (1000000, 1000000), }\n";
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend((absurd.len() as u16).to_le_bytes());
    npy.extend(absurd);
    files.insert("depth/0/0.npy".into(), npy);
    let cut = depth_npy(0, 1);
    files.insert("depth/0/1.npy".into(), cut[..cut.len() - 1].to_vec());
    let wrong = crate::npy::write("<u2", &[WIDTH, HEIGHT], &[0; WIDTH * HEIGHT * 2]);
    files.insert("depth/0/2.npy".into(), wrong);
    files.insert("mask/0/0/0.png".into(), png_claiming(9, 6));
    files.insert("cotracker/0.npz".into(), b"PK\x05\x06".to_vec());
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    let mut frames = recording.source.frames(0).unwrap();
    assert_eq!(reason(frames.color(0)), "FILE_DAMAGED");
    assert_eq!(reason(frames.color(1)), "WRONG_IMAGE_SIZE");
    assert_eq!(reason(frames.color(2)), "FILE_DAMAGED");
    assert_eq!(reason(frames.depth(0)), "HEADER_CLAIMS_TOO_MUCH");
    assert_eq!(reason(frames.depth(1)), "HEADER_CLAIMS_TOO_MUCH");
    assert_eq!(reason(frames.depth(2)), "WRONG_IMAGE_SIZE");
    assert_eq!(reason(frames.mask(0, Region::Object)), "WRONG_IMAGE_SIZE");
    assert_eq!(reason(frames.tracks()), "ARCHIVE_DAMAGED");
    assert!(frames.color(3).unwrap().is_some());
    assert!(recording.source.frames(1).unwrap().tracks().unwrap().is_some());
}

#[test]
fn a_zip_bomb_among_the_frames_is_refused() {
    let mut files = case();
    files.insert("color/0/0.png".into(), vec![0; 40 << 20]);
    let (_guard, path) = archive(&files);
    let recording = raw::open(&path, &Limits::default()).unwrap();
    let mut frames = recording.source.frames(0).unwrap();
    assert_eq!(reason(frames.color(0)), "ARCHIVE_BOMB");
    let folder = folder(&files);
    let recording = raw::open(folder.path(), &Limits::default()).unwrap();
    assert_eq!(reason(recording.source.frames(0).unwrap().color(0)), "CAPTURE_TOO_LARGE");
}

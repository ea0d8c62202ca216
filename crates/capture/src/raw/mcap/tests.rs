//! Recordings written by the `mcap` crate, their messages by an encoder of this test.

mod bags;
mod drivers;
mod encode;
mod hostile;
mod made;
mod robots;

use std::{borrow::Cow, collections::BTreeMap, io::Cursor};

use self::encode::{Encoding, Info, compressed_depth, repack};
use super::*;
use crate::raw::{
    self, Distortion, Intrinsics, Region,
    testing::{
        FRAMES, HEIGHT, WIDTH, color_at, color_png, depth_mm_at, mask_png, pixels, png_file, reason,
    },
};

/// Deviations that a test wants.
#[derive(Clone, Default)]
pub(super) struct Wishes {
    encoding: Encoding,
    chunked: bool,
    /// Frame of the depth images, if not that of colour.
    depth_frame: Option<&'static str>,
    without_tf: bool,
    without_info: bool,
    /// Quaternion of camera 1.
    rotation: Option<[f64; 4]>,
    model: Option<(&'static str, Vec<f64>)>,
    moving: bool,
    float_depth: bool,
    depth_png: bool,
    masks: bool,
    extra_color: bool,
    settings: BTreeMap<String, String>,
    mesh: bool,
}

/// Half a turn about x: a camera that looks down at a world with z up.
const LOOKING_DOWN: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// Frame `frame` of a camera that is 5 ms late, and whose frame 2 was lost, if it is the second.
fn stamp(camera: usize, frame: usize) -> Option<i64> {
    (camera == 0 || frame != 2)
        .then(|| 1_700_000_000_000_000_000 + frame as i64 * 33_333_333 + camera as i64 * 5_000_000)
}

pub(super) fn file(wishes: &Wishes) -> Vec<u8> {
    let options = ::mcap::WriteOptions::new().compression(None).use_chunks(wishes.chunked);
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let e = wishes.encoding;
    let mut channels: BTreeMap<(String, &str), u16> = BTreeMap::new();
    let mut put = |topic: String, kind: &'static str, ns: i64, data: Vec<u8>| {
        let id = *channels.entry((topic.clone(), kind)).or_insert_with(|| {
            let schema = writer.add_schema(&e.schema(kind), e.schema_encoding(), b"").unwrap();
            writer.add_channel(schema, &topic, e.name(), &BTreeMap::new()).unwrap()
        });
        let header = ::mcap::records::MessageHeader {
            channel_id: id,
            sequence: 0,
            log_time: ns as u64 + 7,
            publish_time: ns as u64,
        };
        writer.write_to_known_channel(&header, &data).unwrap();
    };
    let start = stamp(0, 0).unwrap();
    for camera in 0..2 {
        let frame_id = format!("cam{camera}_optical");
        let rotation = wishes.rotation.filter(|_| camera == 1).unwrap_or(LOOKING_DOWN);
        if !wishes.without_tf {
            let mount = format!("mount{camera}");
            let fixed = e.transforms(&[
                (0, "world", &mount, [0.1 * camera as f64, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]),
                (0, &mount, &frame_id, [0.0, 0.2, 0.5], rotation),
            ]);
            let moving: Vec<Vec<u8>> = [0, 100_000_000]
                .iter()
                .map(|dt| {
                    let at = [0.1 * camera as f64, 0.0, *dt as f64 * 1e-8];
                    let q = [0.0, 0.0, 0.0, 1.0];
                    e.transforms(&[(start + dt, "world", &mount, at, q)])
                })
                .collect();
            if wishes.moving {
                let only = e.transforms(&[(0, &mount, &frame_id, [0.0, 0.2, 0.5], rotation)]);
                put("/tf_static".into(), "TFMessage", start, only);
                for message in moving {
                    put("/tf".into(), "TFMessage", start, message);
                }
            } else {
                put("/tf_static".into(), "TFMessage", start, fixed);
            }
        }
        for frame in 0..FRAMES {
            let Some(ns) = stamp(camera, frame) else { continue };
            if !wishes.without_info {
                let (model, d) = wishes.model.clone().unwrap_or(("plumb_bob", vec![0.0; 5]));
                let info = Info { frame_id: &frame_id, width: WIDTH, height: HEIGHT, model, d };
                put(format!("/cam{camera}/color/camera_info"), "CameraInfo", ns, e.info(ns, &info));
            }
            let color = color_png(camera, frame);
            let color = e.compressed(ns, &frame_id, "png", &color);
            put(
                format!("/cam{camera}/color/image_raw/compressed"),
                "CompressedImage",
                ns,
                color.clone(),
            );
            if wishes.extra_color {
                put(
                    format!("/cam{camera}/other/image_raw/compressed"),
                    "CompressedImage",
                    ns,
                    color,
                );
            }
            let depth_frame = wishes.depth_frame.unwrap_or(&frame_id);
            // Depth comes a millisecond after its colour.
            let late = ns + 1_000_000;
            if wishes.depth_png {
                let png = compressed_depth(camera, frame);
                let message = e.compressed(late, depth_frame, "16UC1; compressedDepth png", &png);
                put(
                    format!("/cam{camera}/depth/image_raw/compressedDepth"),
                    "CompressedImage",
                    late,
                    message,
                );
            } else {
                let (encoding, size) = if wishes.float_depth { ("32FC1", 4) } else { ("16UC1", 2) };
                let data: Vec<u8> = pixels()
                    .flat_map(|(c, r)| {
                        let mm = depth_mm_at(camera, frame, c, r);
                        if wishes.float_depth {
                            (f32::from(mm) / 1000.0).to_le_bytes().to_vec()
                        } else {
                            mm.to_le_bytes().to_vec()
                        }
                    })
                    .collect();
                let message =
                    e.image(late, depth_frame, [WIDTH, HEIGHT], encoding, WIDTH * size, &data);
                put(
                    format!("/cam{camera}/aligned_depth_to_color/image_raw"),
                    "Image",
                    late,
                    message,
                );
            }
            if wishes.masks {
                for (part, columns) in [("object", 0..2), ("manipulator", 5..6)] {
                    let png = mask_png(columns);
                    let message = e.compressed(ns, &frame_id, "png", &png);
                    put(
                        format!("/cam{camera}/mask/{part}/compressed"),
                        "CompressedImage",
                        ns,
                        message,
                    );
                }
            }
        }
    }
    if !wishes.settings.is_empty() {
        let metadata = wishes.settings.clone();
        writer
            .write_metadata(&::mcap::records::Metadata { name: "bendtwin".into(), metadata })
            .unwrap();
    }
    if wishes.mesh {
        let attachment = ::mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: "toy.obj".into(),
            media_type: "model/obj".into(),
            data: Cow::Borrowed(b"v 0 0 0"),
        };
        writer.attach(&attachment).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// Opens bytes as a file that lasts as long as the returned guard.
pub(super) fn opened(bytes: &[u8]) -> (tempfile::TempDir, Result<Recording, Error>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    std::fs::write(&path, bytes).unwrap();
    let recording = raw::open(&path, &Limits::default());
    (folder, recording)
}

pub(super) fn outcome(wishes: &Wishes) -> &'static str {
    reason(opened(&file(wishes)).1)
}

fn expect_whole(bytes: &[u8]) {
    let (_guard, recording) = opened(bytes);
    let recording = recording.unwrap();
    assert_eq!((recording.name.as_str(), recording.frame_count), ("run", FRAMES));
    assert!((recording.fps - 30.0).abs() < 1e-3, "{}", recording.fps);
    assert_eq!(recording.cameras.len(), 2);
    for (index, camera) in recording.cameras.iter().enumerate() {
        assert_eq!(camera.name, format!("cam{index}"));
        assert_eq!((camera.width, camera.height), (WIDTH, HEIGHT));
        assert_eq!(camera.intrinsics, Intrinsics { fx: 10.0, fy: 11.0, cx: 3.5, cy: 2.5 });
        assert_eq!(camera.distortion, Distortion::None);
        // 0.5 m above the ground, looking down.
        let point = camera.unproject([3.5, 2.5], 0.5, 0);
        let expected = [0.1 * index as f32, 0.2, 0.0];
        assert!((0..3).all(|i| (point[i] - expected[i]).abs() < 1e-6), "{point:?}");
        let mut frames = recording.source.frames(index).unwrap();
        for frame in 0..FRAMES {
            let color = frames.color(frame).unwrap();
            let depth = frames.depth(frame).unwrap();
            let Some(ns) = stamp(index, frame) else {
                assert!(color.is_none() && depth.is_none() && camera.times_s[frame].is_nan());
                continue;
            };
            let seconds = (ns - stamp(0, 0).unwrap()) as f64 * 1e-9;
            assert!((camera.times_s[frame] - seconds).abs() < 1e-9);
            let (color, depth) = (color.unwrap(), depth.unwrap());
            for (c, r) in pixels() {
                assert_eq!(color.get(c, r), Some(color_at(index, frame, c, r)));
                let metres = f32::from(depth_mm_at(index, frame, c, r)) / 1000.0;
                assert!((depth.get(c, r).unwrap() - metres).abs() < 1e-6);
            }
        }
        assert!(frames.mask(0, Region::Object).unwrap().is_none());
        assert!(frames.tracks().unwrap().is_none());
    }
}

#[test]
fn every_encoding_gives_the_same_recording() {
    for encoding in [Encoding::Ros2, Encoding::Ros1, Encoding::Protobuf] {
        for chunked in [false, true] {
            expect_whole(&file(&Wishes { encoding, chunked, ..Wishes::default() }));
        }
    }
}

#[test]
fn every_form_of_depth_gives_the_same_recording() {
    expect_whole(&file(&Wishes { float_depth: true, ..Wishes::default() }));
    expect_whole(&file(&Wishes { depth_png: true, ..Wishes::default() }));
}

#[test]
fn compressed_chunks_are_unpacked() {
    let bytes = file(&Wishes { chunked: true, ..Wishes::default() });
    for compression in ["zstd", "lz4"] {
        expect_whole(&repack(&bytes, compression));
    }
    assert_eq!(reason(opened(&repack(&bytes, "brotli")).1), "FILE_DAMAGED");
}

#[test]
fn what_other_programs_write_is_read() {
    // Written by the `mcap` and `mcap-ros2-support` packages of Python.
    for bytes in [
        &include_bytes!("../../../testdata/ros2-zstd.mcap")[..],
        &include_bytes!("../../../testdata/ros2-lz4.mcap")[..],
    ] {
        let (_guard, recording) = opened(bytes);
        let recording = recording.unwrap();
        assert_eq!((recording.frame_count, recording.cameras.len()), (3, 1));
        let camera = &recording.cameras[0];
        assert_eq!(camera.distortion, Distortion::KannalaBrandt([0.1, 0.01, 0.0, 0.0]));
        assert_eq!(camera.poses[0].translation, [1.0, 2.0, 3.0]);
        let mut frames = recording.source.frames(0).unwrap();
        assert_eq!(frames.color(1).unwrap().unwrap().get(3, 2), Some([10, 3, 2]));
        let depth = frames.depth(2).unwrap().unwrap();
        assert!((depth.get(3, 2).unwrap() - 0.702).abs() < 1e-6);
    }
}

#[test]
fn a_camera_moves_as_its_transforms_say() {
    let (_guard, recording) = opened(&file(&Wishes { moving: true, ..Wishes::default() }));
    let recording = recording.unwrap();
    let heights: Vec<f64> = recording.cameras[0].poses.iter().map(|p| p.translation[2]).collect();
    // A metre in a tenth of a second, from half a metre on.
    for (frame, height) in heights.iter().enumerate() {
        let expected = 0.5 + (frame as f64 * 0.33333333).min(1.0);
        assert!((height - expected).abs() < 1e-6, "{heights:?}");
    }
}

#[test]
fn masks_settings_and_meshes_have_their_names() {
    let settings = [("ground_height_m", "0.02"), ("train_frame_count", "2"), ("up_axis", "+z")];
    let settings = settings.map(|(k, v)| (k.to_owned(), v.to_owned())).into();
    let wishes = Wishes { masks: true, mesh: true, settings, ..Wishes::default() };
    let (_guard, recording) = opened(&file(&wishes));
    let recording = recording.unwrap();
    assert_eq!(recording.train_frame_count, 2);
    assert_eq!(recording.environment.ground.unwrap().offset_m, 0.02);
    assert_eq!(recording.mesh.as_ref().unwrap().name, "toy.obj");
    let mut frames = recording.source.frames(1).unwrap();
    let object = frames.mask(1, Region::Object).unwrap().unwrap();
    let hand = frames.mask(1, Region::Manipulator).unwrap().unwrap();
    for (c, r) in pixels() {
        assert_eq!((object.get(c, r), hand.get(c, r)), (Some(c < 2), Some(c == 5)));
    }
}

#[test]
fn distortion_models_have_their_names() {
    let of = |model: &'static str, d: &[f64]| {
        let wishes = Wishes { model: Some((model, d.to_vec())), ..Wishes::default() };
        opened(&file(&wishes)).1.map(|recording| recording.cameras[0].distortion)
    };
    let five = [0.1, 0.2, 0.3, 0.4, 0.5];
    let all = Distortion::BrownConrady([0.1, 0.2, 0.3, 0.4, 0.5, 0.0, 0.0, 0.0]);
    assert_eq!(of("plumb_bob", &five).unwrap(), all);
    let eight = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
    assert_eq!(of("rational_polynomial", &eight).unwrap(), Distortion::BrownConrady(eight));
    assert_eq!(
        of("equidistant", &five[..4]).unwrap(),
        Distortion::KannalaBrandt([0.1, 0.2, 0.3, 0.4])
    );
    assert_eq!(of("", &[]).unwrap(), Distortion::None);
    assert_eq!(reason(of("thin_prism", &five)), "INVALID_CAMERA");
    assert_eq!(reason(of("plumb_bob", &eight[..7])), "INVALID_CAMERA");
    assert_eq!(reason(of("plumb_bob", &[f64::NAN; 5])), "INVALID_CAMERA");
}

#[test]
fn gray_pixels_of_a_raw_image_become_colour() {
    let layout = messages::Layout { width: 2, height: 2, step: 3, big_endian: false };
    let data = [1, 2, 99, 3, 4];
    let image = messages::ImageData { encoding: "mono8".into(), layout: Some(layout), data: &data };
    let color = images::color("i", &image, [2, 2]).unwrap();
    assert_eq!(color.pixels, [[1; 3], [2; 3], [3; 3], [4; 3]]);
    let bgr = messages::Layout { width: 1, height: 1, step: 3, big_endian: false };
    let image =
        messages::ImageData { encoding: "bgr8".into(), layout: Some(bgr), data: &[1, 2, 3] };
    assert_eq!(images::color("i", &image, [1, 1]).unwrap().pixels, [[3, 2, 1]]);
}

#[test]
fn inverse_depth_is_turned_back() {
    // What `compressed_depth_image_transport` makes of 0.5 m and 2 m with a = 100, b = 10.
    let quantised = [210_u16, 60, 0];
    let bytes: Vec<u8> = quantised.iter().flat_map(|n| n.to_be_bytes()).collect();
    let mut data = 0_u32.to_le_bytes().to_vec();
    data.extend(100.0_f32.to_le_bytes());
    data.extend(10.0_f32.to_le_bytes());
    data.extend(png_file(3, 1, png::ColorType::Grayscale, true, &bytes));
    let encoding = "32FC1; compressedDepth png".to_owned();
    let image = messages::ImageData { encoding, layout: None, data: &data };
    assert_eq!(images::depth("d", &image, [3, 1], None).unwrap().pixels, [0.5, 2.0, 0.0]);
}

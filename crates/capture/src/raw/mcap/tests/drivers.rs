//! Recordings as drivers publish them: which topics are taken as what, in which encodings, on which
//! clocks, and what is said about the rest.

use super::{
    super::transforms::plain,
    made::{
        Message, PERIOD, ROS, START, camera, colors, depths, file, files, healthy, images, info,
        message, optical, stamp, transform, with_settings, without,
    },
    opened,
};
use crate::raw::{
    Recording,
    testing::{FRAMES, HEIGHT, WIDTH, color_at, color_png, depth_mm_at, pixels, png_file, reason},
};

fn read(messages: &[Message]) -> (tempfile::TempDir, Recording) {
    let (guard, recording) = opened(&file(messages));
    (guard, recording.unwrap())
}

fn fault(messages: &[Message]) -> (&'static str, String) {
    let result = opened(&file(messages)).1;
    let text = result.as_ref().unwrap_err().to_string();
    (reason(result), text)
}

/// Checks that colour and depth of every camera are those of the tiny recordings.
fn expect_images(recording: &Recording) {
    assert_eq!(recording.frame_count, FRAMES);
    for camera in 0..recording.cameras.len() {
        expect_depth(recording, camera, camera);
        let mut frames = recording.source.frames(camera).unwrap();
        for frame in 0..FRAMES {
            let color = frames.color(frame).unwrap().unwrap();
            for (c, r) in pixels() {
                assert_eq!(color.get(c, r), Some(color_at(camera, frame, c, r)));
            }
        }
    }
}

fn expect_depth(recording: &Recording, camera: usize, scene: usize) {
    let mut frames = recording.source.frames(camera).unwrap();
    for frame in 0..FRAMES {
        let depth = frames.depth(frame).unwrap().unwrap();
        for (c, r) in pixels() {
            let metres = f32::from(depth_mm_at(scene, frame, c, r)) / 1000.0;
            let found = depth.get(c, r).unwrap();
            assert!((found - metres).abs() < 1e-4, "{c} {r}: {found} {metres}");
        }
    }
}

fn left_out(recording: &Recording, topic: &str) -> String {
    let all = &recording.sources.left_out;
    let found = all.iter().find(|left| left.from == topic);
    found.unwrap_or_else(|| panic!("{topic} is not named: {all:#?}")).because.clone()
}

fn taken(recording: &Recording, part: &str) -> Vec<String> {
    let all = recording.sources.taken.iter().filter(|t| t.part == part);
    all.map(|t| format!("{} ({})", t.from, t.form)).collect()
}

#[test]
fn a_recording_says_what_was_taken() {
    let (_guard, recording) = read(&healthy());
    expect_images(&recording);
    assert_eq!(
        taken(&recording, "colour"),
        ["/cam0/color/image_raw (rgb8)", "/cam1/color/image_raw (rgb8)"]
    );
    let depth = &taken(&recording, "depth")[1];
    assert_eq!(depth, "/cam1/aligned_depth_to_color/image_raw (16UC1, 1 is 0.001 m)");
    assert_eq!(taken(&recording, "pose")[0], "world > cam0_optical (fixed)");
    assert_eq!(taken(&recording, "lens")[0], "/cam0/color/camera_info (K, no distortion)");
    assert!(recording.sources.left_out.is_empty() && recording.notes.is_empty());
}

#[test]
fn confidence_disparity_and_infrared_are_no_depth() {
    let floats = |topic, value: f32| {
        images(topic, &optical(0), "32FC1", move |_, _, _| value.to_le_bytes().to_vec())
    };
    let gray = |topic, encoding| images(topic, &optical(0), encoding, |_, _, _| vec![1, 1]);
    for (more, topic) in [
        (floats("/cam0/a/confidence_map", 100.0), "/cam0/a/confidence_map"),
        (floats("/cam0/disparity/image", 12.0), "/cam0/disparity/image"),
        (gray("/cam0/Ir/image_raw", "mono16"), "/cam0/Ir/image_raw"),
        (gray("/cam0/amplitude", "16UC1"), "/cam0/amplitude"),
        (gray("/cam0/a/raw", "mono16"), "/cam0/a/raw"),
        (floats("/cam0/aaa", 50.0), "/cam0/aaa"),
        (depths(0, "/cam0/aaa/depth/image", &optical(0)), "/cam0/aaa/depth/image"),
    ] {
        let (_guard, recording) = read(&[more, healthy()].concat());
        assert_eq!(recording.cameras.len(), 2, "{topic}");
        expect_images(&recording);
        assert!(!left_out(&recording, topic).is_empty());
    }
    // Alone, they are no depth either, and are named.
    let only = without(healthy(), "/cam1");
    let only = [without(only, "depth"), floats("/cam0/confidence/map", 100.0)].concat();
    let (code, text) = fault(&only);
    assert_eq!(code, "DEPTH_NOT_ALIGNED");
    assert!(text.contains("/cam0/confidence/map") && text.contains("confidence map"), "{text}");
}

#[test]
fn pictures_of_depth_and_infrared_are_no_cameras() {
    let picture =
        |topic: &str, frame_id: &str| images(topic, frame_id, "rgb8", |_, _, _| vec![1, 2, 3]);
    let more = [
        picture("/cam0/depth/image_color", "cam0_depth"),
        picture("/cam0/overlay/image", &optical(0)),
        images("/cam0/infra1/image_rect_raw", "cam0_infra", "mono8", |_, _, _| vec![9]),
        // Other cameras: one without depth, and the right eye of a camera with depth.
        picture("/webcam/image_raw", "webcam"),
        picture("/cam1/right/image_raw", "cam1_right"),
        vec![message("/cam0/points", "sensor_msgs/msg/PointCloud2", START, vec![0; 30])],
        vec![message("/v/h264", "foxglove_msgs/msg/CompressedVideo", START, vec![0; 30])],
    ]
    .concat();
    let (_guard, recording) = read(&[more.clone(), healthy()].concat());
    assert_eq!(recording.cameras.len(), 2);
    expect_images(&recording);
    for (topic, word) in [
        ("/cam0/depth/image_color", "picture of depth"),
        ("/cam0/overlay/image", "picture for people"),
        ("/cam0/infra1/image_rect_raw", "infrared"),
        ("/webcam/image_raw", "no depth is in its frame `webcam`"),
        ("/cam1/right/image_raw", "no depth is in its frame `cam1_right`"),
        ("/cam0/points", "point cloud"),
        ("/v/h264", "video"),
    ] {
        assert!(left_out(&recording, topic).contains(word), "{topic}");
    }
    let (code, text) = fault(&without(more, "cam"));
    assert_eq!(code, "TOPICS_UNCLEAR");
    assert!(text.contains("/v/h264") && text.contains("republish"), "{text}");
}

#[test]
fn a_camera_whose_own_depth_is_in_another_frame_is_refused() {
    let own = [without(camera(1, "/cam1"), "depth"), depths(1, "/cam1/depth/image_raw", "cam1_ir")];
    let (code, text) = fault(&[camera(0, "/cam0"), own.concat()].concat());
    assert_eq!(code, "DEPTH_NOT_ALIGNED");
    assert!(text.contains("/cam1/depth/image_raw in cam1_ir"), "{text}");
    // With any names of the cameras.
    let right = [without(camera(1, "/right"), "depth"), depths(1, "/right/depth/image", "ir")];
    let (code, _) = fault(&[camera(0, "/left"), right.concat()].concat());
    assert_eq!(code, "DEPTH_NOT_ALIGNED");
    // A gray image in the frame of depth is no substitute for colour.
    let own = [without(camera(1, "/cam1"), "depth"), depths(1, "/cam1/depth/image_raw", "cam1_ir")];
    let gray = images("/cam1/gray/image_raw", "cam1_ir", "mono8", |_, _, _| vec![1]);
    assert_eq!(fault(&[own.concat(), gray].concat()).0, "DEPTH_NOT_ALIGNED");
}

#[test]
fn colour_in_the_frame_of_depth_will_do() {
    let azure = [
        without(camera(0, "/k"), "depth"),
        depths(1, "/k/depth/image_raw", "k_depth"),
        colors(1, "/k/rgb_to_depth/image_raw", "k_depth"),
        vec![
            info("/k/depth/camera_info", "k_depth", [WIDTH, HEIGHT]),
            transform("/tf_static", "world", "k_depth", [0.0; 3]),
        ],
    ];
    let (_guard, recording) = read(&azure.concat());
    assert_eq!(taken(&recording, "colour"), ["/k/rgb_to_depth/image_raw (rgb8)"]);
    assert!(left_out(&recording, "/k/color/image_raw").contains("no depth is in its frame"));
}

#[test]
fn of_the_views_of_one_device_one_is_taken() {
    let only = without(healthy(), "/cam1");
    let rect = |topic: &str| colors(7, topic, &optical(0));
    let zed = [
        without(only, "/color/image_raw"),
        colors(0, "/cam0/rgb/image_rect_color", &optical(0)),
        rect("/cam0/left/image_rect_color"),
        images("/cam0/left_gray/image_rect_gray", &optical(0), "mono8", |_, _, _| vec![3]),
    ]
    .concat();
    // P of this calibration is 0, as its images are not rectified: so take that of `image_raw`.
    let (code, text) = fault(&zed);
    assert_eq!(code, "INVALID_CAMERA", "{text}");
    let zed: Vec<Message> = zed
        .into_iter()
        .map(|m| Message { topic: m.topic.replace("image_rect_color", "image"), ..m })
        .collect();
    let (_guard, recording) = read(&zed);
    assert_eq!(taken(&recording, "colour"), ["/cam0/rgb/image (rgb8)"]);
    expect_images(&recording);
    for topic in ["/cam0/left/image", "/cam0/left_gray/image_rect_gray"] {
        assert!(left_out(&recording, topic).contains("`/cam0/rgb/image` of the same frame"));
    }
}

#[test]
fn cameras_with_one_frame_id_are_named() {
    let named = |messages: Vec<Message>| {
        let (code, text) = fault(&messages);
        assert_eq!(code, "TOPICS_UNCLEAR");
        assert!(text.contains("frame_id") && text.contains("mcap filter"), "{text}");
    };
    named([camera(0, "/a/camera"), camera(0, "/b/camera")].concat());
    named([camera(0, "/left"), camera(0, "/right")].concat());
}

#[test]
fn colour_that_was_mapped_onto_depth_is_no_second_camera() {
    let azure = [
        camera(0, "/k"),
        depths(5, "/k/depth/image_raw", "k_depth"),
        colors(5, "/k/rgb_to_depth/image_raw", "k_depth"),
        vec![
            info("/k/depth/camera_info", "k_depth", [WIDTH, HEIGHT]),
            transform("/tf_static", "world", "k_depth", [0.0; 3]),
        ],
    ];
    let (_guard, recording) = read(&azure.concat());
    assert_eq!(recording.cameras.len(), 1);
    expect_images(&recording);
    assert!(left_out(&recording, "/k/rgb_to_depth/image_raw").contains("same device"));
    assert!(left_out(&recording, "/k/depth/image_raw").contains("k_depth"));
}

#[test]
fn colour_comes_in_the_encodings_of_drivers() {
    let with = |color: Vec<Message>| {
        let all = [without(camera(0, "/cam0"), "/color/image_raw"), color].concat();
        let (_guard, recording) = read(&all);
        let mut frames = recording.source.frames(0).unwrap();
        frames.color(1).unwrap().unwrap()
    };
    let topic = "/cam0/color/image_raw";
    for format in ["bayer_rggb8; jpeg compressed bgr8", "yuv422_yuy2; png compressed bgr8", "png"] {
        let topic = "/cam0/color/image_raw/compressed";
        let color = with(files(topic, &optical(0), format, |frame| color_png(0, frame)));
        assert_eq!(color.get(3, 2), Some(color_at(0, 1, 3, 2)), "{format}");
    }
    for (encoding, pixel) in [
        ("yuv422_yuy2", [235, 128].to_vec()),
        ("yuv422", [128, 235].to_vec()),
        ("bayer_grbg8", [255].to_vec()),
        ("bayer_rggb16", [0, 255].to_vec()),
        ("mono8", [255].to_vec()),
        ("rgba16", [255; 8].to_vec()),
    ] {
        let color = with(images(topic, &optical(0), encoding, |_, _, _| pixel.clone()));
        assert_eq!(color.get(3, 2), Some([255; 3]), "{encoding}");
    }
    let bayer = |_| {
        let data: Vec<u8> = pixels().map(|(c, r)| if (c + r) % 2 == 0 { 90 } else { 40 }).collect();
        png_file(WIDTH, HEIGHT, png::ColorType::Grayscale, false, &data)
    };
    let color = with(files(topic, &optical(0), "bayer_grbg8; png compressed bayer_grbg8", bayer));
    assert_eq!(color.get(3, 2), Some([40, 90, 40]));
    let unread = images(topic, &optical(0), "yuv444", |_, _, _| vec![0; 3]);
    let all = [without(camera(0, "/cam0"), "/color/image_raw"), unread].concat();
    let (code, text) = fault(&all);
    assert_eq!(code, "TOPICS_UNCLEAR");
    assert!(text.contains(topic) && text.contains("`yuv444`"), "{text}");
}

/// Numbers in the groups of three bits of RVL.
fn rvl(numbers: &[u16]) -> Vec<u8> {
    let mut groups: Vec<u32> = Vec::new();
    let mut put = |mut n: u32| {
        while n > 7 {
            groups.push(8 | (n & 7));
            n >>= 3;
        }
        groups.push(n);
    };
    let (mut rest, mut last) = (numbers, 0_i32);
    while !rest.is_empty() {
        let zeros = rest.iter().take_while(|n| **n == 0).count();
        let others = rest[zeros..].iter().take_while(|n| **n != 0).count();
        put(zeros as u32);
        put(others as u32);
        for n in &rest[zeros..zeros + others] {
            let difference = i32::from(*n) - last;
            put(((difference << 1) ^ (difference >> 31)) as u32);
            last = i32::from(*n);
        }
        rest = &rest[zeros + others..];
    }
    let words = groups.chunks(8).map(|eight| {
        (0..8).fold(0_u32, |word, i| (word << 4) | eight.get(i).copied().unwrap_or(0))
    });
    words.flat_map(u32::to_le_bytes).collect()
}

#[test]
fn compressed_depth_comes_as_png_and_rvl_of_integers_and_floats() {
    // Floats are stored as a / z + b.
    let (a, b) = (1000.0_f32, -100.0_f32);
    for (format, is_float, is_rvl) in [
        ("16UC1; compressedDepth png", false, false),
        ("16UC1; compressedDepth RVL", false, true),
        ("32FC1; compressedDepth png", true, false),
        ("32FC1; compressedDepth rvl", true, true),
    ] {
        let depth = |frame: usize| {
            let numbers: Vec<u16> = pixels()
                .map(|(c, r)| match depth_mm_at(0, frame, c, r) {
                    mm if is_float && mm > 0 => (a / (f32::from(mm) / 1000.0) + b).round() as u16,
                    mm => mm,
                })
                .collect();
            let mut bytes = vec![0; 4];
            bytes.extend(a.to_le_bytes());
            bytes.extend(b.to_le_bytes());
            if is_rvl {
                bytes.extend((WIDTH as u32).to_le_bytes());
                bytes.extend((HEIGHT as u32).to_le_bytes());
                bytes.extend(rvl(&numbers));
            } else {
                let data: Vec<u8> = numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
                bytes.extend(png_file(WIDTH, HEIGHT, png::ColorType::Grayscale, true, &data));
            }
            bytes
        };
        let topic = "/cam0/aligned_depth_to_color/image_raw/compressedDepth";
        let depth = files(topic, &optical(0), format, depth);
        let (_guard, recording) = read(&[without(camera(0, "/cam0"), "depth"), depth].concat());
        let mut frames = recording.source.frames(0).unwrap();
        let depth = frames.depth(1).unwrap().unwrap();
        for (c, r) in pixels() {
            let metres = f32::from(depth_mm_at(0, 1, c, r)) / 1000.0;
            let near = if is_float { 2e-3 } else { 1e-6 };
            assert!((depth.get(c, r).unwrap() - metres).abs() < near, "{format} {c} {r}");
        }
    }
}

#[test]
fn a_lens_of_another_size_than_the_images_is_one_fault() {
    let color = |topic: &str, compressed: bool| {
        let all = without(without(camera(0, "/cam0"), "camera_info"), "/color/image_raw");
        let images = if compressed {
            files(topic, &optical(0), "png", |frame| color_png(0, frame))
        } else {
            colors(0, topic, &optical(0))
        };
        [all, images].concat()
    };
    for compressed in [false, true] {
        let mut all = color("/cam0/color/image_raw", compressed);
        all.push(info("/cam0/color/camera_info", &optical(0), [2 * WIDTH, 2 * HEIGHT]));
        let (code, text) = fault(&all);
        assert_eq!(code, "LENS_SIZE_MISMATCH");
        assert!(text.contains("8 x 6 pixels") && text.contains("16 x 12"), "{text}");
        // Another one in this frame has the right size.
        all.push(info("/cam0/depth/camera_info", &optical(0), [WIDTH, HEIGHT]));
        let (_guard, recording) = read(&all);
        assert_eq!(taken(&recording, "lens"), ["/cam0/depth/camera_info (K, no distortion)"]);
    }
}

#[test]
fn a_calibration_goes_before_the_driver_in_any_order() {
    let only = without(camera(0, "/cam0"), "/tf_static");
    let driver = [
        transform("/tf_static", "cam0_link", "cam0_color", [0.0, 0.0, 9.0]),
        transform("/tf_static", "cam0_color", "cam0_optical", [0.0, 0.0, 9.0]),
    ];
    let hand_eye = [transform("/tf_static", "world", "cam0_optical", [1.0, 2.0, 3.0])];
    for order in [[&driver[..], &hand_eye], [&hand_eye, &driver]] {
        let all = [only.clone(), order.concat()].concat();
        let (_guard, recording) = read(&all);
        assert_eq!(recording.cameras[0].poses[0].translation, [1.0, 2.0, 3.0]);
        assert_eq!(recording.notes[0].code, "PARENT_TAKEN");
        assert!(left_out(&recording, "transform cam0_color > cam0_optical").contains("world"));
    }
    let other = [transform("/tf_static", "base", "cam0_optical", [1.0, 2.0, 3.0])];
    let all = [only, driver.to_vec(), other.to_vec()].concat();
    let (code, text) = fault(&all);
    assert_eq!(code, "TRANSFORMS_UNCLEAR");
    assert!(text.contains("(base, cam0_color)") && text.contains("world_frame"), "{text}");
    let named = opened(&with_settings(&all, &[("world_frame", "/base")])).1.unwrap();
    assert_eq!(named.cameras[0].poses[0].translation, [1.0, 2.0, 3.0]);
    assert_eq!(plain("/base"), "base");
}

#[test]
fn streams_with_other_clocks_are_joined() {
    let only = without(camera(0, "/cam0"), "depth");
    let device = |frame: usize| 7_000_000_000 + frame as i64 * PERIOD;
    let depth = |frame: usize| {
        let data: Vec<u8> =
            pixels().flat_map(|(c, r)| depth_mm_at(0, frame, c, r).to_le_bytes()).collect();
        let size = [WIDTH, HEIGHT];
        let data = ROS.image(device(frame), &optical(0), size, "16UC1", 2 * WIDTH, &data);
        message("/cam0/depth/image_raw", "Image", stamp(frame) + 2_000_000, data)
    };
    let all = [only, (0..FRAMES).map(depth).collect()].concat();
    let (_guard, recording) = read(&all);
    expect_images(&recording);
    let note = &recording.notes[0];
    assert_eq!(note.code, "CLOCKS_JOINED");
    assert!(note.message.contains("/cam0/depth/image_raw"), "{}", note.message);
}

#[test]
fn the_unit_of_depth_may_be_declared() {
    let settings = [
        ("depth_unit_m", "0.0001"),
        ("depth_unit_m:/cam1/aligned_depth_to_color/image_raw", "0.01"),
    ];
    let (_guard, recording) = opened(&with_settings(&healthy(), &settings));
    let recording = recording.unwrap();
    for (camera, unit) in [(0, 0.0001), (1, 0.01)] {
        let depth = recording.source.frames(camera).unwrap().depth(0).unwrap().unwrap();
        let expected = f32::from(depth_mm_at(camera, 0, 2, 2)) * unit;
        assert!((depth.get(2, 2).unwrap() - expected).abs() < 1e-6 * expected);
    }
    assert!(taken(&recording, "depth")[0].ends_with("(16UC1, 1 is 0.0001 m, as declared)"));
    let unknown = opened(&with_settings(&healthy(), &[("depth_scale", "0.0001")])).1;
    let text = unknown.unwrap_err().to_string();
    assert!(text.contains("`depth_scale`") && text.contains("depth_unit_m"), "{text}");
}

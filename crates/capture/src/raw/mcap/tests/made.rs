//! A recording as a list of messages of ROS 2, easy to change.

use std::{borrow::Cow, collections::BTreeMap, io::Cursor};

use super::encode::{Encoding, Info};
use crate::raw::testing::{FRAMES, HEIGHT, WIDTH, color_at, depth_mm_at, pixels};

pub(super) const ROS: Encoding = Encoding::Ros2;
pub(super) const START: i64 = 1_700_000_000_000_000_000;
pub(super) const PERIOD: i64 = 33_333_333;
const TURNED: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// A message with the time of its recording [ns].
#[derive(Clone, Debug)]
pub(super) struct Message {
    pub(super) topic: String,
    pub(super) kind: &'static str,
    pub(super) ns: i64,
    pub(super) data: Vec<u8>,
}

pub(super) fn message(
    topic: impl Into<String>,
    kind: &'static str,
    ns: i64,
    data: Vec<u8>,
) -> Message {
    Message { topic: topic.into(), kind, ns, data }
}

pub(super) fn stamp(frame: usize) -> i64 {
    START + frame as i64 * PERIOD
}

/// An image of a camera's size for each frame.
pub(super) fn images(
    topic: &str,
    frame_id: &str,
    encoding: &str,
    pixel: impl Fn(usize, usize, usize) -> Vec<u8>,
) -> Vec<Message> {
    let image = |frame: usize| {
        let data: Vec<u8> = pixels().flat_map(|(c, r)| pixel(frame, c, r)).collect();
        let ns = stamp(frame);
        let step = data.len() / HEIGHT;
        message(topic, "Image", ns, ROS.image(ns, frame_id, [WIDTH, HEIGHT], encoding, step, &data))
    };
    (0..FRAMES).map(image).collect()
}

/// A file for each frame.
pub(super) fn files(
    topic: &str,
    frame_id: &str,
    format: &str,
    file: impl Fn(usize) -> Vec<u8>,
) -> Vec<Message> {
    let image = |frame: usize| {
        let ns = stamp(frame);
        message(topic, "CompressedImage", ns, ROS.compressed(ns, frame_id, format, &file(frame)))
    };
    (0..FRAMES).map(image).collect()
}

pub(super) fn colors(camera: usize, topic: &str, frame_id: &str) -> Vec<Message> {
    images(topic, frame_id, "rgb8", |frame, c, r| color_at(camera, frame, c, r).to_vec())
}

pub(super) fn depths(camera: usize, topic: &str, frame_id: &str) -> Vec<Message> {
    images(topic, frame_id, "16UC1", |frame, c, r| {
        depth_mm_at(camera, frame, c, r).to_le_bytes().to_vec()
    })
}

pub(super) fn info(topic: &str, frame_id: &str, [width, height]: [usize; 2]) -> Message {
    let info = Info { frame_id, width, height, model: "plumb_bob", d: vec![0.0; 5] };
    message(topic, "CameraInfo", START, ROS.info(START, &info))
}

pub(super) fn transform(topic: &str, parent: &str, child: &str, at: [f64; 3]) -> Message {
    message(topic, "TFMessage", START, ROS.transforms(&[(START, parent, child, at, TURNED)]))
}

/// Frame of a camera.
pub(super) fn optical(camera: usize) -> String {
    format!("cam{camera}_optical")
}

/// A camera whose topics are `{name}/color/image_raw` and so on, half a metre above the world.
pub(super) fn camera(number: usize, name: &str) -> Vec<Message> {
    let frame_id = optical(number);
    let mut all = vec![
        info(&format!("{name}/color/camera_info"), &frame_id, [WIDTH, HEIGHT]),
        transform("/tf_static", "world", &frame_id, [0.1 * number as f64, 0.2, 0.5]),
    ];
    all.extend(colors(number, &format!("{name}/color/image_raw"), &frame_id));
    all.extend(depths(number, &format!("{name}/aligned_depth_to_color/image_raw"), &frame_id));
    all
}

/// Two cameras.
pub(super) fn healthy() -> Vec<Message> {
    [camera(0, "/cam0"), camera(1, "/cam1")].concat()
}

/// Messages on all topics but those whose names contain a word.
pub(super) fn without(all: Vec<Message>, word: &str) -> Vec<Message> {
    all.into_iter().filter(|m| !m.topic.contains(word)).collect()
}

/// A file of these messages.
pub(super) fn file(messages: &[Message]) -> Vec<u8> {
    with_settings(messages, &[])
}

/// A file of these messages with a metadata record.
pub(super) fn with_settings(messages: &[Message], settings: &[(&str, &str)]) -> Vec<u8> {
    with_extras(messages, settings, &[])
}

/// A file of these messages with a metadata record and attachments.
pub(super) fn with_extras(
    messages: &[Message],
    settings: &[(&str, &str)],
    attachments: &[(&str, &[u8])],
) -> Vec<u8> {
    let options = ::mcap::WriteOptions::new().compression(None);
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let mut channels: BTreeMap<(&str, &str), u16> = BTreeMap::new();
    for Message { topic, kind, ns, data } in messages {
        let id = *channels.entry((topic, kind)).or_insert_with(|| {
            let schema = if kind.contains('/') { (*kind).to_owned() } else { ROS.schema(kind) };
            let schema = writer.add_schema(&schema, ROS.schema_encoding(), b"").unwrap();
            writer.add_channel(schema, topic, ROS.name(), &BTreeMap::new()).unwrap()
        });
        let header = ::mcap::records::MessageHeader {
            channel_id: id,
            sequence: 0,
            log_time: *ns as u64,
            publish_time: *ns as u64,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    if !settings.is_empty() {
        let metadata = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        let record = ::mcap::records::Metadata { name: "bendtwin".into(), metadata };
        writer.write_metadata(&record).unwrap();
    }
    for (name, data) in attachments {
        let attachment = ::mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: (*name).to_owned(),
            media_type: String::new(),
            data: Cow::Borrowed(data),
        };
        writer.attach(&attachment).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

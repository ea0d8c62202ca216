//! The messages that make up a recording, from whichever encoding.

use super::{
    protobuf::{Message, Value},
    ros::Ros,
};

/// Content of a topic, by the name of its schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    CompressedImage,
    Image,
    Calibration,
    Transform,
    Transforms,
    Joints,
}

/// Serialisation of its messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wire {
    Ros1,
    Ros2,
    Protobuf,
}

/// Kind and wire of a channel; `None` for what does not concern a recording.
pub(super) fn kind_of(schema: &str, encoding: &str) -> Option<(Kind, Wire)> {
    let wire = match encoding {
        "ros1" => Wire::Ros1,
        "cdr" => Wire::Ros2,
        "protobuf" => Wire::Protobuf,
        _ => return None,
    };
    let kind = match schema.replace("/msg/", "/").as_str() {
        "sensor_msgs/CompressedImage" | "foxglove.CompressedImage" => Kind::CompressedImage,
        "sensor_msgs/Image" | "foxglove.RawImage" => Kind::Image,
        "sensor_msgs/CameraInfo" | "foxglove.CameraCalibration" => Kind::Calibration,
        "tf2_msgs/TFMessage" | "tf/tfMessage" | "foxglove.FrameTransforms" => Kind::Transforms,
        "foxglove.FrameTransform" => Kind::Transform,
        "sensor_msgs/JointState" if wire != Wire::Protobuf => Kind::Joints,
        _ => return None,
    };
    Some((kind, wire))
}

/// What the messages of a channel are that might be images but are not read; `None` for others.
pub(super) fn unread(schema: &str, encoding: &str) -> Option<String> {
    let name: String = schema.chars().take(80).collect();
    let lower = schema.to_lowercase();
    let has = |word: &str| lower.contains(word);
    if has("pointcloud") {
        return Some("it is a point cloud: points are made from depth images".to_owned());
    }
    let is_video = has("video") || has("packet") || has("h264") || has("theora");
    if is_video {
        return Some(format!(
            "it is video (`{name}`): republish it as images (`ros2 run image_transport republish`) and record these"
        ));
    }
    has("image").then(|| {
        let encoding: String = encoding.chars().take(20).collect();
        format!("messages `{name}` in `{encoding}` are not read")
    })
}

/// Header of an image, before its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ImageHead {
    pub(super) stamp_ns: i64,
    pub(super) frame_id: String,
    /// Encoding of pixels (`rgb8`, `16UC1`), or of a compressed image (`jpeg`, `16UC1;
    /// compressedDepth`).
    pub(super) encoding: String,
    /// Columns and rows of an image that is not compressed.
    pub(super) size: Option<[usize; 2]>,
}

/// An image with its pixels as sent.
#[derive(Debug)]
pub(super) struct ImageData<'a> {
    pub(super) encoding: String,
    pub(super) layout: Option<Layout>,
    pub(super) data: &'a [u8],
}

/// Memory layout of an uncompressed image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Bytes from row to row.
    pub(super) step: usize,
    pub(super) big_endian: bool,
}

/// A calibration as ROS writes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Calibration {
    pub(super) frame_id: String,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) model: String,
    /// Distortion.
    pub(super) d: Vec<f64>,
    /// Intrinsics 3 x 3.
    pub(super) k: Vec<f64>,
    /// Projection 3 x 4 of the rectified image.
    pub(super) p: Vec<f64>,
}

/// Pose of a frame in its parent.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Transform {
    pub(super) stamp_ns: i64,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) translation: [f64; 3],
    /// x, y, z, w.
    pub(super) rotation: [f64; 4],
}

/// Positions of a robot's joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Joints {
    pub(super) stamp_ns: i64,
    pub(super) names: Vec<String>,
    /// Positions of the joints in `names` [rad or m].
    pub(super) positions: Vec<f64>,
}

/// Coefficients beyond these belong to no known model.
const MAX_COEFFICIENTS: usize = 32;
/// Transforms of one message.
const MAX_TRANSFORMS: usize = 10_000;
/// Joints of one message.
const MAX_JOINTS: usize = 1000;

fn ros(wire: Wire, bytes: &[u8]) -> Option<Ros<'_>> {
    if wire == Wire::Ros1 { Some(Ros::one(bytes)) } else { Ros::two(bytes) }
}

/// The head of an image, from its first bytes or, in protobuf, all of them.
pub(super) fn image_head(kind: Kind, wire: Wire, bytes: &[u8]) -> Option<ImageHead> {
    if wire == Wire::Protobuf {
        let mut head = ImageHead::default();
        let (frame_id, encoding) = if kind == Kind::Image { (7, 4) } else { (4, 3) };
        let mut size = [0; 2];
        for (field, value) in Message(bytes) {
            match field {
                1 => head.stamp_ns = value.stamp_ns()?,
                f if f == frame_id => head.frame_id = value.text()?,
                f if f == encoding => head.encoding = value.text()?,
                2 | 3 if kind == Kind::Image => {
                    size[usize::from(field == 3)] = usize::try_from(value.number()?).ok()?;
                }
                _ => {}
            }
        }
        head.size = (kind == Kind::Image).then_some(size);
        return Some(head);
    }
    let mut ros = ros(wire, bytes)?;
    let header = ros.header()?;
    let size = if kind == Kind::Image {
        let (height, width) = (ros.u32()? as usize, ros.u32()? as usize);
        Some([width, height])
    } else {
        None
    };
    let encoding = ros.text()?;
    Some(ImageHead { stamp_ns: header.stamp_ns, frame_id: header.frame_id, encoding, size })
}

/// A whole image.
pub(super) fn image(kind: Kind, wire: Wire, bytes: &[u8]) -> Option<ImageData<'_>> {
    if wire == Wire::Protobuf {
        return protobuf_image(kind, bytes);
    }
    let mut ros = ros(wire, bytes)?;
    ros.header()?;
    if kind == Kind::CompressedImage {
        return Some(ImageData { encoding: ros.text()?, layout: None, data: ros.data()? });
    }
    let (height, width) = (ros.u32()? as usize, ros.u32()? as usize);
    let encoding = ros.text()?;
    let big_endian = ros.u8()? != 0;
    let step = ros.u32()? as usize;
    let layout = Some(Layout { width, height, step, big_endian });
    Some(ImageData { encoding, layout, data: ros.data()? })
}

fn protobuf_image(kind: Kind, bytes: &[u8]) -> Option<ImageData<'_>> {
    let mut encoding = String::new();
    let mut data = None;
    let mut layout = Layout { width: 0, height: 0, step: 0, big_endian: false };
    let number = |value: Value<'_>| usize::try_from(value.number()?).ok();
    for (field, value) in Message(bytes) {
        match (kind == Kind::Image, field) {
            (true, 2) => layout.width = number(value)?,
            (true, 3) => layout.height = number(value)?,
            (true, 4) | (false, 3) => encoding = value.text()?,
            (true, 5) => layout.step = number(value)?,
            (true, 6) | (false, 2) => data = value.bytes(),
            _ => {}
        }
    }
    Some(ImageData { encoding, layout: (kind == Kind::Image).then_some(layout), data: data? })
}

/// A calibration.
pub(super) fn calibration(wire: Wire, bytes: &[u8]) -> Option<Calibration> {
    if wire == Wire::Protobuf {
        let mut c = Calibration::default();
        for (field, value) in Message(bytes) {
            match field {
                2 => c.width = usize::try_from(value.number()?).ok()?,
                3 => c.height = usize::try_from(value.number()?).ok()?,
                4 => c.model = value.text()?,
                5 => value.doubles(&mut c.d),
                6 => value.doubles(&mut c.k),
                8 => value.doubles(&mut c.p),
                9 => c.frame_id = value.text()?,
                _ => {}
            }
        }
        let sound = c.k.len() == 9 && matches!(c.p.len(), 0 | 12) && c.d.len() <= MAX_COEFFICIENTS;
        return sound.then_some(c);
    }
    let mut ros = ros(wire, bytes)?;
    let frame_id = ros.header()?.frame_id;
    let (height, width) = (ros.u32()? as usize, ros.u32()? as usize);
    let model = ros.text()?;
    let d = ros.doubles(MAX_COEFFICIENTS)?;
    let k = ros.f64s::<9>()?.to_vec();
    ros.f64s::<9>()?;
    let p = ros.f64s::<12>()?.to_vec();
    Some(Calibration { frame_id, width, height, model, d, k, p })
}

/// Transforms: one, or as many as a message has.
pub(super) fn transforms(kind: Kind, wire: Wire, bytes: &[u8]) -> Option<Vec<Transform>> {
    if wire == Wire::Protobuf {
        if kind == Kind::Transform {
            return protobuf_transform(bytes).map(|t| vec![t]);
        }
        let all = Message(bytes).filter(|(field, _)| *field == 1).take(MAX_TRANSFORMS);
        return all.map(|(_, value)| protobuf_transform(value.bytes()?)).collect();
    }
    let mut ros = ros(wire, bytes)?;
    let count = ros.u32()? as usize;
    if count > MAX_TRANSFORMS {
        return None;
    }
    let mut all = Vec::new();
    for _ in 0..count {
        let header = ros.header()?;
        all.push(Transform {
            stamp_ns: header.stamp_ns,
            parent: header.frame_id,
            child: ros.text()?,
            translation: ros.f64s()?,
            rotation: ros.f64s()?,
        });
    }
    Some(all)
}

/// Positions of joints.
pub(super) fn joints(wire: Wire, bytes: &[u8]) -> Option<Joints> {
    let mut ros = ros(wire, bytes)?;
    let stamp_ns = ros.header()?.stamp_ns;
    let count = ros.u32()? as usize;
    if count > MAX_JOINTS {
        return None;
    }
    let names = (0..count).map(|_| ros.text()).collect::<Option<Vec<_>>>()?;
    let positions = ros.doubles(MAX_JOINTS)?;
    Some(Joints { stamp_ns, names, positions })
}

fn protobuf_transform(bytes: &[u8]) -> Option<Transform> {
    let mut t = Transform::default();
    for (field, value) in Message(bytes) {
        match field {
            1 => t.stamp_ns = value.stamp_ns()?,
            2 => t.parent = value.text()?,
            3 => t.child = value.text()?,
            4 => t.translation = value.vector()?,
            5 => t.rotation = value.vector()?,
            _ => {}
        }
    }
    Some(t)
}

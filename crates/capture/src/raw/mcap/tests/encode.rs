//! Writes messages as ROS 1, ROS 2 and Foxglove do, and compresses the chunks of a file.

use std::io::Write;

use crate::raw::testing::{HEIGHT, WIDTH, depth_mm_at, pixels, png_file};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::raw) enum Encoding {
    #[default]
    Ros2,
    Ros1,
    Protobuf,
}

/// Stamp, parent, child, translation and quaternion of a frame.
type Transform<'a> = (i64, &'a str, &'a str, [f64; 3], [f64; 4]);

/// Content of a calibration.
pub(super) struct Info<'a> {
    pub(super) frame_id: &'a str,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) model: &'a str,
    pub(super) d: Vec<f64>,
}

const K: [f64; 9] = [10.0, 0.0, 3.5, 0.0, 11.0, 2.5, 0.0, 0.0, 1.0];

impl Encoding {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ros2 => "cdr",
            Self::Ros1 => "ros1",
            Self::Protobuf => "protobuf",
        }
    }

    pub(super) fn schema_encoding(self) -> &'static str {
        match self {
            Self::Ros2 => "ros2msg",
            Self::Ros1 => "ros1msg",
            Self::Protobuf => "protobuf",
        }
    }

    pub(super) fn schema(self, kind: &str) -> String {
        let package = if kind == "TFMessage" { "tf2_msgs" } else { "sensor_msgs" };
        match self {
            Self::Ros2 => format!("{package}/msg/{kind}"),
            Self::Ros1 => format!("{package}/{kind}"),
            Self::Protobuf => match kind {
                "TFMessage" => "foxglove.FrameTransforms".into(),
                "CameraInfo" => "foxglove.CameraCalibration".into(),
                "Image" => "foxglove.RawImage".into(),
                other => format!("foxglove.{other}"),
            },
        }
    }

    fn ros(self) -> Ros {
        match self {
            Self::Ros2 => Ros { bytes: vec![0, 1, 0, 0], cdr: true },
            _ => Ros { bytes: Vec::new(), cdr: false },
        }
    }

    pub(super) fn compressed(self, ns: i64, frame_id: &str, format: &str, data: &[u8]) -> Vec<u8> {
        if self == Self::Protobuf {
            // The pixels before the rest: fields come in any order.
            return Proto::default()
                .bytes(2, data)
                .stamp(ns)
                .bytes(3, format.as_bytes())
                .bytes(4, frame_id.as_bytes())
                .0;
        }
        let mut m = self.ros();
        m.header(ns, frame_id);
        m.text(format);
        m.data(data);
        m.bytes
    }

    pub(super) fn image(
        self,
        ns: i64,
        frame_id: &str,
        [width, height]: [usize; 2],
        encoding: &str,
        step: usize,
        data: &[u8],
    ) -> Vec<u8> {
        if self == Self::Protobuf {
            return Proto::default()
                .stamp(ns)
                .fixed32(2, width as u32)
                .fixed32(3, height as u32)
                .bytes(4, encoding.as_bytes())
                .fixed32(5, step as u32)
                .bytes(6, data)
                .bytes(7, frame_id.as_bytes())
                .0;
        }
        let mut m = self.ros();
        m.header(ns, frame_id);
        m.u32(height as u32);
        m.u32(width as u32);
        m.text(encoding);
        m.bytes.push(0);
        m.u32(step as u32);
        m.data(data);
        m.bytes
    }

    pub(super) fn info(self, ns: i64, info: &Info<'_>) -> Vec<u8> {
        if self == Self::Protobuf {
            let packed = |values: &[f64]| -> Vec<u8> {
                values.iter().flat_map(|x| x.to_le_bytes()).collect()
            };
            return Proto::default()
                .stamp(ns)
                .fixed32(2, info.width as u32)
                .fixed32(3, info.height as u32)
                .bytes(4, info.model.as_bytes())
                .bytes(5, &packed(&info.d))
                .bytes(6, &packed(&K))
                .bytes(8, &packed(&[0.0; 12]))
                .bytes(9, info.frame_id.as_bytes())
                .0;
        }
        let mut m = self.ros();
        m.header(ns, info.frame_id);
        m.u32(info.height as u32);
        m.u32(info.width as u32);
        m.text(info.model);
        m.u32(info.d.len() as u32);
        m.f64s(&info.d);
        m.f64s(&K);
        m.f64s(&[0.0; 9]);
        m.f64s(&[0.0; 12]);
        // Binning and region of interest.
        m.bytes.extend([0; 24]);
        m.bytes
    }

    /// Positions of joints, without velocities and efforts.
    pub(super) fn joints(self, ns: i64, joints: &[(&str, f64)]) -> Vec<u8> {
        let mut m = self.ros();
        m.header(ns, "");
        m.u32(joints.len() as u32);
        joints.iter().for_each(|(name, _)| m.text(name));
        m.u32(joints.len() as u32);
        joints.iter().for_each(|(_, position)| m.f64s(&[*position]));
        m.u32(0);
        m.u32(0);
        m.bytes
    }

    pub(super) fn transforms(self, all: &[Transform<'_>]) -> Vec<u8> {
        if self == Self::Protobuf {
            let mut message = Proto::default();
            for (ns, parent, child, translation, rotation) in all {
                let one = Proto::default()
                    .stamp(*ns)
                    .bytes(2, parent.as_bytes())
                    .bytes(3, child.as_bytes())
                    .bytes(4, &Proto::vector(translation))
                    .bytes(5, &Proto::vector(rotation));
                message = message.bytes(1, &one.0);
            }
            return message.0;
        }
        let mut m = self.ros();
        m.u32(all.len() as u32);
        for (ns, parent, child, translation, rotation) in all {
            m.header(*ns, parent);
            m.text(child);
            m.f64s(translation);
            m.f64s(rotation);
        }
        m.bytes
    }
}

struct Ros {
    bytes: Vec<u8>,
    cdr: bool,
}

impl Ros {
    fn align(&mut self, size: usize) {
        // Alignment counts from after the four bytes of the encoding.
        while self.cdr && !(self.bytes.len() - 4).is_multiple_of(size) {
            self.bytes.push(0);
        }
    }

    fn u32(&mut self, n: u32) {
        self.align(4);
        self.bytes.extend(n.to_le_bytes());
    }

    fn f64s(&mut self, values: &[f64]) {
        for value in values {
            self.align(8);
            self.bytes.extend(value.to_le_bytes());
        }
    }

    fn text(&mut self, text: &str) {
        if self.cdr {
            self.data(format!("{text}\0").as_bytes());
        } else {
            self.data(text.as_bytes());
        }
    }

    fn data(&mut self, data: &[u8]) {
        self.u32(data.len() as u32);
        self.bytes.extend(data);
    }

    fn header(&mut self, ns: i64, frame_id: &str) {
        if !self.cdr {
            self.u32(42);
        }
        self.u32((ns / 1_000_000_000) as u32);
        self.u32((ns % 1_000_000_000) as u32);
        self.text(frame_id);
    }
}

#[derive(Default)]
struct Proto(Vec<u8>);

impl Proto {
    fn varint(mut self, mut n: u64) -> Self {
        while n >= 0x80 {
            self.0.push(n as u8 | 0x80);
            n >>= 7;
        }
        self.0.push(n as u8);
        self
    }

    fn bytes(self, field: u64, bytes: &[u8]) -> Self {
        let mut this = self.varint(field << 3 | 2).varint(bytes.len() as u64);
        this.0.extend(bytes);
        this
    }

    fn fixed32(self, field: u64, n: u32) -> Self {
        let mut this = self.varint(field << 3 | 5);
        this.0.extend(n.to_le_bytes());
        this
    }

    fn stamp(self, ns: i64) -> Self {
        let stamp = Self::default()
            .varint(1 << 3)
            .varint((ns / 1_000_000_000) as u64)
            .varint(2 << 3)
            .varint((ns % 1_000_000_000) as u64);
        self.bytes(1, &stamp.0)
    }

    fn vector(values: &[f64]) -> Vec<u8> {
        let mut message = Self::default();
        for (index, value) in values.iter().enumerate() {
            message = message.varint((index as u64 + 1) << 3 | 1);
            message.0.extend(value.to_le_bytes());
        }
        message.0
    }
}

/// Depth as `compressed_depth_image_transport` sends it.
pub(super) fn compressed_depth(camera: usize, frame: usize) -> Vec<u8> {
    let data: Vec<u8> =
        pixels().flat_map(|(c, r)| depth_mm_at(camera, frame, c, r).to_be_bytes()).collect();
    let mut bytes = vec![0; 12];
    bytes.extend(png_file(WIDTH, HEIGHT, png::ColorType::Grayscale, true, &data));
    bytes
}

/// The file with its chunks compressed.
pub(super) fn repack(file: &[u8], compression: &str) -> Vec<u8> {
    let mut out = file[..8].to_vec();
    let mut at = 8;
    while at + 9 < file.len() {
        let opcode = file[at];
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap()) as usize;
        let body = &file[at + 9..at + 9 + length];
        at += 9 + length;
        let body = if opcode == 6 { repacked(body, compression) } else { body.to_vec() };
        out.push(opcode);
        out.extend((body.len() as u64).to_le_bytes());
        out.extend(body);
        if opcode == 2 {
            break;
        }
    }
    out.extend(&file[..8]);
    out
}

fn repacked(body: &[u8], compression: &str) -> Vec<u8> {
    // Times, size and checksum; then an empty name and the size again.
    let records = &body[28 + 4 + 8..];
    let packed = match compression {
        "zstd" => {
            let level = ruzstd::encoding::CompressionLevel::Fastest;
            ruzstd::encoding::compress_to_vec(records, level)
        }
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(records).unwrap();
            encoder.finish().unwrap()
        }
        _ => records.to_vec(),
    };
    let mut out = body[..28].to_vec();
    out.extend((compression.len() as u32).to_le_bytes());
    out.extend(compression.as_bytes());
    out.extend((packed.len() as u64).to_le_bytes());
    out.extend(packed);
    out
}

//! Recordings of robots as MCAP: what drivers, calibrations and recorders do to them.

use bendtwin_capture::raw::Pose;

use crate::{
    Broken,
    Expected::{Found, Noticed, Refused, Sound},
    Make, Sample, broken,
    footage::{self, Footage},
};

/// Start of the recording [ns].
const START: i64 = 1_700_000_000_000_000_000;

/// All recordings of this kind.
pub fn all() -> Vec<Broken> {
    let robot = |name, expected, change| broken(name, expected, Make::Robot(change));
    vec![
        robot("a healthy recording of ROS 2", Sound("TRACKS_MISSING"), |_| {}),
        robot(
            "maps of confidence and infrared images beside depth",
            Sound("TRACKS_MISSING"),
            |r| {
                for camera in 0..3 {
                    let confidence = |m: &Message| {
                        let data = vec![100.0_f32; SIZE[0] * SIZE[1]];
                        let data = data.iter().flat_map(|x| x.to_le_bytes()).collect();
                        m.image(&format!("/cam{camera}/a/confidence_map"), "32FC1", data)
                    };
                    let infrared = |m: &Message| {
                        let data = vec![7; 2 * SIZE[0] * SIZE[1]];
                        m.image(&format!("/cam{camera}/Ir/image_raw"), "mono16", data)
                    };
                    let depth: Vec<Message> =
                        r.messages.iter().filter(|m| m.is(camera, "depth")).cloned().collect();
                    r.messages.extend(depth.iter().map(confidence));
                    r.messages.extend(depth.iter().map(infrared));
                }
            },
        ),
        robot("colour as YUYV", Sound("TRACKS_MISSING"), |r| {
            for message in r.messages.iter_mut().filter(|m| m.topic.ends_with("/color/image_raw")) {
                // The luma of each pixel without its colour.
                let luma = |p: &[u8; 3]| (p.iter().map(|x| u32::from(*x)).sum::<u32>() / 3) as u8;
                let rgb = message.data.as_chunks().0;
                let data = rgb.iter().flat_map(|p| [luma(p), 128]).collect();
                *message = message.image(&message.topic.clone(), "yuv422_yuy2", data);
            }
        }),
        robot("a driver and a calibration that place one frame", Sound("PARENT_TAKEN"), |r| {
            for camera in 0..3 {
                r.transforms.insert(0, transform("link", &optical(camera), Pose::IDENTITY));
            }
        }),
        robot("two calibrations of one frame", Refused("TRANSFORMS_UNCLEAR"), |r| {
            r.transforms.insert(0, transform("other", &optical(1), Pose::IDENTITY));
            r.transforms.insert(0, transform("world", "other", Pose::IDENTITY));
            r.transforms.insert(0, transform("another", &optical(1), Pose::IDENTITY));
            r.transforms.insert(0, transform("world", "another", Pose::IDENTITY));
            r.transforms
                .retain(|t| (t.parent.as_str(), t.child.as_str()) != ("world", "cam1_optical"));
        }),
        robot("depth by the clock of its device", Noticed("CLOCKS_JOINED"), |r| {
            for message in r.messages.iter_mut().filter(|m| m.topic.contains("depth")) {
                message.stamp_ns -= START - 5_000_000_000;
            }
        }),
        robot("one frame for all cameras", Refused("TOPICS_UNCLEAR"), |r| {
            r.messages.iter_mut().for_each(|m| m.frame_id = optical(0));
        }),
        robot("colour in an encoding that is not read", Refused("TOPICS_UNCLEAR"), |r| {
            for message in r.messages.iter_mut().filter(|m| m.topic.ends_with("/color/image_raw")) {
                message.encoding = "yuv444".to_owned();
            }
        }),
        robot("a lens of twice the images' size", Refused("LENS_SIZE_MISMATCH"), |r| {
            r.lens_size = SIZE.map(|n| 2 * n);
        }),
        robot("depth in the frame of the infrared cameras", Refused("DEPTH_NOT_ALIGNED"), |r| {
            for message in r.messages.iter_mut().filter(|m| m.topic.contains("depth")) {
                message.frame_id = "infrared".to_owned();
            }
        }),
        robot("depth of a robot in tenths of a millimetre", Found("DEPTH_UNITS"), |r| {
            tenths(r);
        }),
        robot("depth in a unit that is declared", Sound("TRACKS_MISSING"), |r| {
            tenths(r);
            r.settings.push(("depth_unit_m", "0.0001".to_owned()));
        }),
        robot("a metadata key that nobody knows", Refused("INVALID_DOCUMENT"), |r| {
            r.settings.push(("depth_scale", "0.0001".to_owned()));
        }),
        robot("a tilted sensor", Refused("INVALID_CAMERA"), |r| r.distortion[13] = 0.1),
        robot("a lens of fourteen coefficients", Sound("TRACKS_MISSING"), |r| {
            r.distortion =
                [1e-4, -1e-4, 0.0, 0.0, 1e-5, 1e-5, -1e-5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        }),
    ]
}

const SIZE: [usize; 2] = [160, 120];

fn optical(camera: usize) -> String {
    format!("cam{camera}_optical")
}

/// Depth in tenths of a millimetre.
fn tenths(robot: &mut Robot) {
    for message in robot.messages.iter_mut().filter(|m| m.topic.contains("depth")) {
        for number in message.data.as_chunks_mut().0 {
            *number = u16::from_le_bytes(*number).saturating_mul(10).to_le_bytes();
        }
    }
}

/// A recording as messages, easy to change.
#[derive(Debug)]
pub struct Robot {
    messages: Vec<Message>,
    transforms: Vec<Transform>,
    intrinsics: Vec<[f64; 4]>,
    distortion: [f64; 14],
    lens_size: [usize; 2],
    settings: Vec<(&'static str, String)>,
}

/// An image.
#[derive(Clone, Debug)]
struct Message {
    topic: String,
    frame_id: String,
    encoding: String,
    stamp_ns: i64,
    log_ns: i64,
    data: Vec<u8>,
}

impl Message {
    /// `true` for messages of a camera whose topic has a word.
    fn is(&self, camera: usize, word: &str) -> bool {
        self.topic.starts_with(&format!("/cam{camera}/")) && self.topic.contains(word)
    }

    /// Another image at the same time.
    fn image(&self, topic: &str, encoding: &str, data: Vec<u8>) -> Self {
        Self { topic: topic.to_owned(), encoding: encoding.to_owned(), data, ..self.clone() }
    }
}

/// The pose of a frame in another.
#[derive(Clone, Debug)]
struct Transform {
    parent: String,
    child: String,
    pose: Pose,
}

fn transform(parent: &str, child: &str, pose: Pose) -> Transform {
    Transform { parent: parent.to_owned(), child: child.to_owned(), pose }
}

impl Robot {
    /// The healthy recording.
    fn healthy() -> Self {
        let Footage { about, reels } = footage::healthy();
        let mut robot = Self {
            messages: Vec::new(),
            transforms: Vec::new(),
            intrinsics: Vec::new(),
            distortion: [0.0; 14],
            lens_size: SIZE,
            settings: Vec::new(),
        };
        if let Some(ground) = about.environment.ground {
            robot.settings.push(("ground_height_m", ground.offset_m.to_string()));
        }
        for (camera, (about, reel)) in about.cameras.iter().zip(reels).enumerate() {
            robot.transforms.push(transform("world", &optical(camera), about.poses[0]));
            let i = about.intrinsics;
            robot.intrinsics.push([i.fx, i.fy, i.cx, i.cy]);
            for frame in 0..footage::FRAMES {
                let ns = START + frame as i64 * 33_333_333;
                let mut put = |topic: &str, encoding: &str, data: Option<Vec<u8>>| {
                    let Some(data) = data else { return };
                    robot.messages.push(Message {
                        topic: format!("/cam{camera}/{topic}"),
                        frame_id: optical(camera),
                        encoding: encoding.to_owned(),
                        stamp_ns: ns,
                        log_ns: ns + 2_000_000,
                        data,
                    });
                };
                let color = reel.color[frame].as_ref();
                put("color/image_raw", "rgb8", color.map(|c| c.pixels.as_flattened().to_vec()));
                let mm = |m: &f32| ((1e3 * m).round() as u16).to_le_bytes();
                let depth = reel.depth[frame].as_ref();
                let depth = depth.map(|d| d.pixels.iter().flat_map(mm).collect());
                put("aligned_depth_to_color/image_raw", "16UC1", depth);
                for (topic, masks) in
                    [("mask/object", &reel.object), ("mask/manipulator", &reel.hand)]
                {
                    let mask = masks[frame].as_ref();
                    let mask = mask.map(|m| m.pixels.iter().map(|b| 255 * u8::from(*b)).collect());
                    put(topic, "mono8", mask);
                }
            }
        }
        robot
    }

    /// The file, in the encoding of ROS 2 without chunks.
    fn file(&self) -> Vec<u8> {
        let mut file = File { bytes: MAGIC.to_vec(), channels: Vec::new() };
        file.record(1, &[text("ros2"), text("")].concat());
        for (id, schema) in (1_u16..).zip(SCHEMAS) {
            file.record(
                3,
                &[id.to_le_bytes().to_vec(), text(schema), text("ros2msg"), text("")].concat(),
            );
        }
        let mut all = Cdr::default();
        all.u32(self.transforms.len() as u32);
        for Transform { parent, child, pose } in &self.transforms {
            all.header(START, parent);
            all.text(child);
            all.f64s(&pose.translation);
            all.f64s(&quaternion(&pose.rotation));
        }
        file.message("/tf_static", 3, START, &all.0);
        for (camera, [fx, fy, cx, cy]) in self.intrinsics.iter().enumerate() {
            let mut info = Cdr::default();
            let frame_id = self.messages.iter().find(|m| m.is(camera, "color"));
            info.header(START, frame_id.map_or("", |m| &m.frame_id));
            info.u32(self.lens_size[1] as u32);
            info.u32(self.lens_size[0] as u32);
            info.text("rational_polynomial");
            info.u32(self.distortion.len() as u32);
            info.f64s(&self.distortion);
            info.f64s(&[*fx, 0.0, *cx, 0.0, *fy, *cy, 0.0, 0.0, 1.0]);
            info.f64s(&[0.0; 21]);
            info.0.extend([0; 24]);
            file.message(&format!("/cam{camera}/color/camera_info"), 2, START, &info.0);
        }
        let mut messages: Vec<&Message> = self.messages.iter().collect();
        messages.sort_by_key(|m| m.log_ns);
        for message in messages {
            let mut image = Cdr::default();
            image.header(message.stamp_ns, &message.frame_id);
            image.u32(SIZE[1] as u32);
            image.u32(SIZE[0] as u32);
            image.text(&message.encoding);
            image.0.push(0);
            image.u32((message.data.len() / SIZE[1]) as u32);
            image.u32(message.data.len() as u32);
            image.0.extend(&message.data);
            file.message(&message.topic, 1, message.log_ns, &image.0);
        }
        if !self.settings.is_empty() {
            let mut pairs = Vec::new();
            for (key, value) in &self.settings {
                pairs.extend([text(key), text(value)].concat());
            }
            let length = (pairs.len() as u32).to_le_bytes().to_vec();
            file.record(12, &[text("bendtwin"), length, pairs].concat());
        }
        file.record(15, &[0; 4]);
        file.record(2, &[0; 20]);
        file.bytes.extend(MAGIC);
        file.bytes
    }
}

/// A changed recording in a file.
pub(crate) fn stored(change: fn(&mut Robot)) -> Sample {
    let mut robot = Robot::healthy();
    change(&mut robot);
    let folder = tempfile::tempdir().expect("there is room for it");
    let path = folder.path().join("recording.mcap");
    std::fs::write(&path, robot.file()).expect("there is room for it");
    Sample::Stored(folder, path)
}

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Schemas of messages, numbered from 1.
const SCHEMAS: [&str; 3] =
    ["sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo", "tf2_msgs/msg/TFMessage"];

/// A file of MCAP.
struct File {
    bytes: Vec<u8>,
    /// Topics; the place is the number of the channel.
    channels: Vec<String>,
}

impl File {
    fn record(&mut self, opcode: u8, content: &[u8]) {
        self.bytes.push(opcode);
        self.bytes.extend((content.len() as u64).to_le_bytes());
        self.bytes.extend(content);
    }

    fn message(&mut self, topic: &str, schema: u16, ns: i64, data: &[u8]) {
        let known = self.channels.iter().position(|t| t == topic);
        let id = known.unwrap_or(self.channels.len()) as u16;
        if known.is_none() {
            self.channels.push(topic.to_owned());
            let ids = [id.to_le_bytes(), schema.to_le_bytes()].concat();
            self.record(4, &[ids, text(topic), text("cdr"), vec![0; 4]].concat());
        }
        let times = [ns.to_le_bytes(), ns.to_le_bytes()].concat();
        self.record(5, &[id.to_le_bytes().to_vec(), vec![0; 4], times, data.to_vec()].concat());
    }
}

/// A text of MCAP.
fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// A message of ROS 2.
struct Cdr(Vec<u8>);

impl Default for Cdr {
    fn default() -> Self {
        Self(vec![0, 1, 0, 0])
    }
}

impl Cdr {
    fn align(&mut self, size: usize) {
        while !(self.0.len() - 4).is_multiple_of(size) {
            self.0.push(0);
        }
    }

    fn u32(&mut self, n: u32) {
        self.align(4);
        self.0.extend(n.to_le_bytes());
    }

    fn f64s(&mut self, values: &[f64]) {
        for value in values {
            self.align(8);
            self.0.extend(value.to_le_bytes());
        }
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    fn header(&mut self, ns: i64, frame_id: &str) {
        self.u32((ns / 1_000_000_000) as u32);
        self.u32((ns % 1_000_000_000) as u32);
        self.text(frame_id);
    }
}

/// The quaternion x, y, z, w of a rotation.
fn quaternion(r: &[[f64; 3]; 3]) -> [f64; 4] {
    // The largest of the four is found from the diagonal, the others from sums beside it.
    let squares = [
        1.0 + r[0][0] - r[1][1] - r[2][2],
        1.0 - r[0][0] + r[1][1] - r[2][2],
        1.0 - r[0][0] - r[1][1] + r[2][2],
        1.0 + r[0][0] + r[1][1] + r[2][2],
    ];
    let sums = [
        [0.0, r[0][1] + r[1][0], r[0][2] + r[2][0], r[2][1] - r[1][2]],
        [r[0][1] + r[1][0], 0.0, r[1][2] + r[2][1], r[0][2] - r[2][0]],
        [r[0][2] + r[2][0], r[1][2] + r[2][1], 0.0, r[1][0] - r[0][1]],
        [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1], 0.0],
    ];
    let largest = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(3);
    let twice = squares[largest].sqrt();
    std::array::from_fn(
        |i| if i == largest { twice / 2.0 } else { sums[largest][i] / (2.0 * twice) },
    )
}

//! Images of ROS 2 in MCAP files: encodings whose data has any length, and messages and files that
//! were compressed by themselves.

use rand::RngExt as _;

use crate::{
    Fault, Rng, damage,
    recordings::{CHANNEL, Record, SCHEMA, file, pack, valid_records},
    samples,
};

/// Faults of messages.
pub const FAULTS: &[Fault] = &[
    Fault { what: "messages that were compressed one by one", make: packed },
    Fault { what: "messages that unpack a thousandfold", make: bombs },
    Fault { what: "a recording that was compressed as a whole", make: whole },
    Fault { what: "a recording that unpacks a thousandfold", make: whole_bomb },
    Fault { what: "images of any encoding and length", make: image },
];

const MESSAGE: u8 = 5;
/// Bytes of a message before its content.
const HEAD: usize = 22;
/// Bytes of an image of the sample up to its encoding or size: four of CDR, the stamp, `optical`.
const HEADER: usize = 24;
/// Number of the schema of images that become compressed ones.
const COMPRESSED: u16 = 99;

/// Formats of compressed depth, then encodings of raw colour.
const KINDS: [&str; 15] = [
    "16UC1; compressedDepth RVL",
    "32FC1; compressedDepth RVL",
    "16UC1; compressedDepth png",
    "32FC1; compressedDepth",
    "png",
    "rgb8",
    "bgra16",
    "mono16",
    "yuv422",
    "yuv422_yuy2",
    "nv12",
    "nv21",
    "bayer_rggb8",
    "bayer_gbrg16",
    "yuv444",
];
/// Number of the formats of depth among them.
const DEPTHS: usize = 5;

/// The valid recording with other images: the first byte says of which kind; of colour the second one
/// is the length of a row; the rest are the pixels.
pub fn of_bytes(data: &[u8]) -> Option<Vec<u8>> {
    let (&kind, data) = data.split_first()?;
    let kind = usize::from(kind) % KINDS.len();
    if kind < DEPTHS {
        let content = |header: &[u8]| {
            let mut message = header.to_vec();
            text(&mut message, KINDS[kind]);
            bytes(&mut message, data);
            message
        };
        return Some(replaced(b"/depth/image_raw", true, content));
    }
    let (&step, data) = data.split_first()?;
    let content = |header: &[u8]| {
        let mut message = header.to_vec();
        message.extend(6_u32.to_le_bytes());
        message.extend(8_u32.to_le_bytes());
        text(&mut message, KINDS[kind]);
        message.push(step & 1);
        align(&mut message);
        message.extend(u32::from(step).to_le_bytes());
        bytes(&mut message, data);
        message
    };
    Some(replaced(b"/color/image_raw", false, content))
}

/// Bytes for [`of_bytes`] of every kind, which are whole images.
pub fn valid() -> Vec<Vec<u8>> {
    let depth = |kind: usize| {
        let mut data = vec![kind as u8];
        if kind < 4 {
            data.extend([0; 4]);
            data.extend(1000_f32.to_le_bytes());
            data.extend((-100_f32).to_le_bytes());
        }
        if kind < 2 {
            data.extend([8, 0, 0, 0, 6, 0, 0, 0]);
            // 48 pixels: none and 48 others in groups of three bits, then as many differences of 0
            // but for the first, which is 500.
            let groups = [0, 8, 6, 8, 13, 15, 1];
            let groups: Vec<u32> = groups.into_iter().chain([0; 47]).collect();
            for eight in groups.chunks(8) {
                let word = (0..8).fold(0_u32, |w, i| (w << 4) | eight.get(i).unwrap_or(&0));
                data.extend(word.to_le_bytes());
            }
        } else {
            data.extend(samples::depth_png());
        }
        data
    };
    let color = |kind: usize| [&[kind as u8, 64][..], &[90; 64 * 9]].concat();
    (0..KINDS.len()).map(|kind| if kind < DEPTHS { depth(kind) } else { color(kind) }).collect()
}

/// The valid recording with other content of a topic's messages, as compressed images or as before;
/// `content` gets the header of a message.
fn replaced(topic: &[u8], compressed: bool, content: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut all = valid_records();
    let mut channel = None;
    for (opcode, record) in &mut all {
        if *opcode == CHANNEL && record.windows(topic.len()).any(|w| w == topic) {
            channel = Some([record[0], record[1]]);
            if compressed {
                record[2..4].copy_from_slice(&COMPRESSED.to_le_bytes());
            }
        } else if *opcode == MESSAGE && channel == Some([record[0], record[1]]) {
            let header = record.get(HEAD..HEAD + HEADER).unwrap_or_default();
            *record = [&record[..HEAD], &content(header)].concat();
        }
    }
    let mut schema = COMPRESSED.to_le_bytes().to_vec();
    for part in ["sensor_msgs/msg/CompressedImage", "ros2msg", ""] {
        bytes(&mut schema, part.as_bytes());
    }
    all.insert(0, (SCHEMA, schema));
    file(&all)
}

fn align(message: &mut Vec<u8>) {
    while !message.len().is_multiple_of(4) {
        message.push(0);
    }
}

fn text(message: &mut Vec<u8>, text: &str) {
    bytes(message, format!("{text}\0").as_bytes());
    align(message);
}

fn bytes(message: &mut Vec<u8>, bytes: &[u8]) {
    message.extend((bytes.len() as u32).to_le_bytes());
    message.extend(bytes);
}

/// The records of the valid recording with the contents of all messages changed.
fn changed(mut change: impl FnMut(&[u8]) -> Vec<u8>) -> Vec<Record> {
    let mut all = valid_records();
    for (opcode, record) in &mut all {
        if *opcode == MESSAGE {
            *record = [&record[..HEAD], &change(&record[HEAD..])].concat();
        }
    }
    all
}

fn packed(rng: &mut Rng) -> Vec<u8> {
    let damaged = rng.random_range(0..4);
    file(&changed(|content| {
        let packed = pack("zstd", content);
        if rng.random_range(0..4) < damaged { damage::any(rng, &packed) } else { packed }
    }))
}

/// A frame of Zstandard with this many blocks of 128 KiB of zeros, each of which takes four bytes;
/// it may announce another size.
fn zeros(blocks: u32, announced: u32) -> Vec<u8> {
    let mut frame = b"\x28\xb5\x2f\xfd\xa0".to_vec();
    frame.extend(announced.to_le_bytes());
    for block in 0..blocks {
        let head = (128 << 10 << 3) | (1 << 1) | u32::from(block + 1 == blocks);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

fn bombs(rng: &mut Rng) -> Vec<u8> {
    let blocks = rng.random_range(1..1000);
    let announced = [blocks << 17, 100, 0, u32::MAX][rng.random_range(0..4)];
    file(&changed(|_| zeros(blocks, announced)))
}

fn whole(rng: &mut Rng) -> Vec<u8> {
    let packed = pack("zstd", &file(&valid_records()));
    if rng.random() { damage::any(rng, &packed) } else { packed }
}

fn whole_bomb(rng: &mut Rng) -> Vec<u8> {
    let [sample, _] = samples::mcap();
    let start = pack("zstd", &sample[..rng.random_range(8..sample.len())]);
    let blocks = rng.random_range(1..4000);
    let many = rng.random_range(1..20);
    [start, zeros(blocks, blocks << 17).repeat(many)].concat()
}

fn image(rng: &mut Rng) -> Vec<u8> {
    let valid = valid();
    let valid = &valid[rng.random_range(0..valid.len())];
    let data = if rng.random() { damage::any(rng, valid) } else { valid.clone() };
    of_bytes(&data).unwrap_or_default()
}

//! Files of Gaussians, `.ply` and `.spz`, with wrong counts, lengths and numbers, and bombs.

use std::io::Write as _;

use flate2::{Compression, write::GzEncoder};
use rand::RngExt as _;

use crate::{Fault, Rng, damage};

/// Faults of files of Gaussians.
pub const FAULTS: &[Fault] = &[
    Fault {
        what: "Gaussians with damage",
        make: |rng| {
            let files = [ply(), spz(2, 3, &body(2)), spz_4(3, 1, 12)];
            let file = &files[rng.random_range(0..files.len())];
            damage::any(rng, file)
        },
    },
    Fault { what: "an SPZ with damage in what is compressed", make: damaged },
    Fault { what: "a PLY of Gaussians with other words", make: reworded },
    Fault { what: "a PLY of Gaussians with a number that is not finite", make: number },
    Fault { what: "an SPZ that claims counts", make: claimed },
    Fault { what: "an SPZ of nothing but zeros", make: bomb },
];

/// Numbers of a Gaussian in a PLY.
const PROPERTIES: [&str; 17] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "f_rest_1", "f_rest_2", "opacity",
    "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
];
/// Gaussians of a valid file.
const COUNT: usize = 3;

/// Three Gaussians as PLY.
pub fn ply() -> Vec<u8> {
    let mut out =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {COUNT}\n").into_bytes();
    for name in PROPERTIES {
        out.extend(format!("property float {name}\n").bytes());
    }
    out.extend(b"end_header\n");
    for g in 0..COUNT {
        let g = g as f32;
        let values = [
            0.1 * g,
            0.2,
            -0.3,
            1.0,
            -1.0,
            0.5 * g,
            0.1,
            0.1,
            0.1,
            2.0 - g,
            -4.0,
            -5.0,
            -6.0,
            1.0,
            0.0,
            0.5,
            0.0,
        ];
        values.iter().for_each(|x: &f32| out.extend(x.to_le_bytes()));
    }
    out
}

/// An SPZ of a version with `count` Gaussians in its header and this body.
pub fn spz(version: u32, count: u32, body: &[u8]) -> Vec<u8> {
    packed(&unpacked(version, count, 0, body))
}

/// The same with harmonics up to a degree, before it is compressed.
fn unpacked(version: u32, count: u32, degree: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for word in [0x5053_474e, version, count] {
        bytes.extend(word.to_le_bytes());
    }
    // 12 bits behind the point.
    bytes.extend([degree, 12, 0, 0]);
    bytes.extend(body);
    bytes
}

/// Three Gaussians as they lie in an SPZ of a version: positions, opacities, colours, scales,
/// rotations.
pub fn body(version: u32) -> Vec<u8> {
    let rotation = if version == 2 { 3 } else { 4 };
    let counts = [(9, 16_u8), (1, 200), (3, 130), (3, 90), (rotation, 120)];
    counts.iter().flat_map(|(bytes, value)| vec![*value; bytes * COUNT]).collect()
}

/// An SPZ of version 4 with `count` Gaussians in its header, which are there if they are [`COUNT`], and
/// harmonics up to a degree.
pub fn spz_4(count: u32, degree: u8, fractional_bits: u8) -> Vec<u8> {
    let body = body(4);
    let mut rest = body.as_slice();
    let mut streams: Vec<(usize, Vec<u8>)> = Vec::new();
    let harmonics = vec![128; 3 * (usize::from(degree % 5 + 1).pow(2) - 1) * COUNT];
    let lengths = [9, 1, 3, 3, 4].map(|bytes| bytes * COUNT);
    let mut add = |bytes: &[u8]| {
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        streams.push((bytes.len(), ruzstd::encoding::compress_to_vec(bytes, level)));
    };
    for length in lengths {
        let (stream, after) = rest.split_at(length);
        rest = after;
        add(stream);
    }
    if !harmonics.is_empty() {
        add(&harmonics);
    }
    let mut bytes = b"NGSP".to_vec();
    bytes.extend(4_u32.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    // An extension that names the axes: right, down, forward.
    let axes = [0xADBE_0003_u32, 4, 6].map(u32::to_le_bytes).concat();
    bytes.extend([degree, fractional_bits, 2, streams.len() as u8]);
    bytes.extend((32 + axes.len() as u32).to_le_bytes());
    bytes.extend([0; 12]);
    bytes.extend(axes);
    for (length, packed) in &streams {
        bytes.extend((packed.len() as u64).to_le_bytes());
        bytes.extend((*length as u64).to_le_bytes());
    }
    bytes.extend(streams.into_iter().flat_map(|(_, packed)| packed));
    bytes
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    // Writing to memory does not fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

fn damaged(rng: &mut Rng) -> Vec<u8> {
    let version = rng.random_range(2..=3);
    let mut bytes = unpacked(version, COUNT as u32, 1, &body(version));
    bytes.extend([128; 9 * COUNT]);
    packed(&damage::any(rng, &bytes))
}

fn reworded(rng: &mut Rng) -> Vec<u8> {
    let from =
        ["vertex 3", "float rot_0", "float x", "binary_little_endian", "property", "element"];
    let to = [
        "vertex 4000000",
        "vertex 18446744073709551615",
        "vertex -1",
        "list uchar int x",
        "double scale_0",
        "uchar rot_0",
        "ascii",
        "binary_big_endian",
        "element face 4000000000\nproperty",
        "",
    ];
    damage::reword(rng, &ply(), &from, &to)
}

fn number(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = ply();
    let numbers = COUNT * PROPERTIES.len();
    let at = bytes.len() - 4 * rng.random_range(1..=numbers);
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e-45, 89.0];
    let value = values[rng.random_range(0..values.len())];
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    bytes
}

fn claimed(rng: &mut Rng) -> Vec<u8> {
    let counts = [0, 4, 3_999_999, 4_000_001, 0x8000_0000, u32::MAX];
    let count = counts[rng.random_range(0..counts.len())];
    match rng.random_range(2..=4) {
        4 => spz_4(count, rng.random_range(0..6), rng.random_range(0..30)),
        version => spz(version, count, &body(version)),
    }
}

/// Bytes that unpack to a thousand times as many.
fn bomb(rng: &mut Rng) -> Vec<u8> {
    let count = rng.random_range(100_000..500_000);
    spz(rng.random_range(1..=4), count, &vec![0; 40 * count as usize])
}

//! Arrays of numpy: headers that claim missing data, and numbers that are not finite.

use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, samples};

/// Faults of arrays.
pub const FAULTS: &[Fault] = &[
    Fault { what: "an array with damage", make: |rng| damage::any(rng, &valid()) },
    Fault { what: "damage in a header of an array", make: damaged_header },
    Fault { what: "an array of a huge shape", make: huge },
    Fault { what: "an array of many dimensions", make: dimensions },
    Fault {
        what: "an array of another type",
        make: |rng| array(pick(rng, TYPES), "(4, 6, 3)", 288),
    },
    Fault { what: "an array of numbers that are none", make: not_finite },
    Fault { what: "a header without an end", make: endless },
    Fault { what: "a header of a wrong length", make: wrong_length },
    Fault { what: "an array without points", make: |rng| array("<f4", pick(rng, EMPTY), 0) },
];

/// Captures with such arrays.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "points with a faulty array", make: |rng| put(rng, "object_points.npy") },
    Fault { what: "controls with a faulty array", make: |rng| put(rng, "control_points.npy") },
    Fault { what: "edges with a faulty array", make: |rng| put(rng, "edges.npy") },
    Fault { what: "edges that lead nowhere", make: wrong_edges },
    Fault { what: "depth with a faulty array", make: depth },
    Fault { what: "tracks with a faulty array", make: tracks },
];

const TYPES: &[&str] = &[
    ">f4",
    "<f2",
    "<f16",
    "|O",
    "<c16",
    "<U8",
    "|V12",
    "<M8[ns]",
    "<i8",
    "|b1",
    "",
    "f",
    "<f99999",
    "<f18446744073709551615",
];
const EMPTY: &[&str] = &["(0, 6, 3)", "(4, 0, 3)", "(4, 6, 0)", "()", "(0,)"];
const HUGE: &[&str] = &[
    "(1000000000, 6, 3)",
    "(4, 4294967296, 3)",
    "(4, 6148914691236517206, 3)",
    "(18446744073709551615, 6, 3)",
    "(9223372036854775808, 2)",
    "(18446744073709551616, 1)",
    "(-1, 6, 3)",
    "(0, 18446744073709551615, 3)",
    "(4294967296, 4294967296, 0)",
];

/// An .npy file with this header and `bytes` zero bytes.
pub fn array(descr: &str, shape: &str, bytes: usize) -> Vec<u8> {
    with_data(descr, shape, &vec![0; bytes])
}

/// An .npy file with this header and these bytes.
pub fn with_data(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    file(&header, data)
}

fn file(header: &str, data: &[u8]) -> Vec<u8> {
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.as_bytes());
    out.extend(data);
    out
}

/// The points of a valid capture.
pub fn valid() -> Vec<u8> {
    samples::observation().remove("object_points.npy").expect("the capture has points")
}

fn pick<'a>(rng: &mut Rng, of: &[&'a str]) -> &'a str {
    of[rng.random_range(0..of.len())]
}

fn damaged_header(rng: &mut Rng) -> Vec<u8> {
    let bytes = valid();
    let (header, data) = bytes.split_at(bytes.len().min(128));
    [damage::any(rng, header), data.to_vec()].concat()
}

fn huge(rng: &mut Rng) -> Vec<u8> {
    array("<f4", pick(rng, HUGE), 288)
}

fn dimensions(rng: &mut Rng) -> Vec<u8> {
    let each = ["1, ", "2, ", "65536, "][rng.random_range(0..3)];
    array("<f4", &format!("({})", each.repeat(rng.random_range(5..2000))), 288)
}

fn not_finite(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = valid();
    let start = bytes.len() - 4 * 6 * 3 * 4;
    for number in bytes[start..].as_chunks_mut::<4>().0 {
        let any = [f32::NAN, f32::INFINITY, f32::MIN, f32::MAX, 1e-45, -0.0];
        if rng.random_range(0..4) == 0 {
            *number = any[rng.random_range(0..any.len())].to_le_bytes();
        }
    }
    bytes
}

fn endless(rng: &mut Rng) -> Vec<u8> {
    let part = ["{", "'", "(", "{'descr': '", "{'shape': (1,", "[", "\\"][rng.random_range(0..7)];
    file(&part.repeat(rng.random_range(1..9000) / part.len() + 1), &[])
}

fn wrong_length(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = valid();
    // Version 2 has a length of four bytes.
    bytes[6] = rng.random_range(0..5);
    bytes[8..10].copy_from_slice(&rng.random::<u16>().to_le_bytes());
    bytes
}

fn any(rng: &mut Rng) -> Vec<u8> {
    (FAULTS[rng.random_range(0..FAULTS.len())].make)(rng)
}

fn put(rng: &mut Rng, name: &str) -> Vec<u8> {
    let bytes = any(rng);
    archives::with(samples::observation(), name, bytes)
}

fn wrong_edges(rng: &mut Rng) -> Vec<u8> {
    let header = "{'descr': '<i8', 'fortran_order': False, 'shape': (1, 2), }\n";
    let ends = [-1, 6, i64::MAX, i64::MIN, 1 << 32];
    let data: Vec<u8> =
        [0, ends[rng.random_range(0..5)]].iter().flat_map(|n| n.to_le_bytes()).collect();
    archives::with(samples::observation(), "edges.npy", file(header, &data))
}

fn depth(rng: &mut Rng) -> Vec<u8> {
    let bytes = any(rng);
    archives::with(samples::raw_case(), "depth/0/1.npy", bytes)
}

fn tracks(rng: &mut Rng) -> Vec<u8> {
    let bytes = any(rng);
    archives::with(samples::raw_bundle(), "cameras/0/tracks.npy", bytes)
}

//! Twin files: safetensors whose header lies about places, types and shapes, and twins that
//! contradict themselves.

use bendtwin_core::Twin;
use rand::RngExt as _;
use serde_json::{Value, json};

use crate::{Fault, Rng, damage, samples};

/// Faults of twin files.
pub const FAULTS: &[Fault] = &[
    Fault { what: "a twin with damage", make: |rng| damaged(rng, damage::any) },
    Fault { what: "a twin that is cut off", make: |rng| damaged(rng, damage::cut) },
    Fault { what: "a twin with damage in its header", make: damaged_header },
    Fault { what: "a twin with a header of a wrong length", make: wrong_length },
    Fault { what: "a twin with other places of tensors", make: places },
    Fault { what: "a twin of other shapes", make: shapes },
    Fault { what: "a twin of another type", make: types },
    Fault { what: "a twin that lacks a tensor", make: lacking },
    Fault { what: "a twin of numbers that are none", make: not_finite },
    Fault { what: "a twin of indices that lead nowhere", make: indices },
    Fault { what: "a twin with other metadata", make: metadata },
    Fault { what: "a twin of nested brackets", make: brackets },
];

fn damaged(rng: &mut Rng, damage: fn(&mut Rng, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let bytes = valid(rng);
    damage(rng, &bytes)
}

fn valid(rng: &mut Rng) -> Vec<u8> {
    encoded(&if rng.random() { samples::twin() } else { samples::cable() })
}

/// A twin as its file.
pub fn encoded(twin: &Twin) -> Vec<u8> {
    twin.encode().expect("the sample is sound")
}

fn parts(bytes: &[u8]) -> (Value, Vec<u8>) {
    let length = bytes[..8].iter().rev().fold(0, |n, b| n << 8 | usize::from(*b));
    let header = serde_json::from_slice(&bytes[8..8 + length]).expect("the sample is whole");
    (header, bytes[8 + length..].to_vec())
}

fn join(header: &[u8], data: &[u8]) -> Vec<u8> {
    [&(header.len() as u64).to_le_bytes(), header, data].concat()
}

/// The header of a valid twin is changed.
fn changed(rng: &mut Rng, change: impl FnOnce(&mut Rng, &mut Value)) -> Vec<u8> {
    let (mut header, data) = parts(&valid(rng));
    change(rng, &mut header);
    join(header.to_string().as_bytes(), &data)
}

/// The entry of a tensor by chance.
fn tensor<'h>(rng: &mut Rng, header: &'h mut Value) -> &'h mut Value {
    let name = tensor_name(rng, header);
    &mut header[name]
}

fn tensor_name(rng: &mut Rng, header: &Value) -> String {
    let names: Vec<&String> = header
        .as_object()
        .into_iter()
        .flatten()
        .map(|(n, _)| n)
        .filter(|n| *n != "__metadata__")
        .collect();
    names[rng.random_range(0..names.len())].clone()
}

fn damaged_header(rng: &mut Rng) -> Vec<u8> {
    let (header, data) = parts(&valid(rng));
    join(&damage::any(rng, header.to_string().as_bytes()), &data)
}

fn wrong_length(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = valid(rng);
    let lengths = [0, 1, 7, bytes.len() as u64, 100_000_000, 100_000_001, 1 << 40, u64::MAX];
    let length = lengths[rng.random_range(0..lengths.len())];
    bytes[..8].copy_from_slice(&length.to_le_bytes());
    bytes
}

fn places(rng: &mut Rng) -> Vec<u8> {
    changed(rng, |rng, header| {
        let any = [0, 1, 12, 1 << 20, 1 << 40, u64::MAX - 1, u64::MAX];
        let offsets = [any[rng.random_range(0..7)], any[rng.random_range(0..7)]];
        tensor(rng, header)["data_offsets"] = json!(offsets);
    })
}

fn shapes(rng: &mut Rng) -> Vec<u8> {
    changed(rng, |rng, header| {
        let any = [
            json!([]),
            json!([0]),
            json!([u64::MAX]),
            json!([u64::MAX, u64::MAX]),
            json!([1_u64 << 32, 1_u64 << 32]),
            json!([3, 3, 3]),
            json!([-1]),
            json!(vec![1; 1000]),
        ];
        tensor(rng, header)["shape"] = any[rng.random_range(0..any.len())].clone();
    })
}

fn types(rng: &mut Rng) -> Vec<u8> {
    changed(rng, |rng, header| {
        let any = ["F16", "F64", "I64", "BOOL", "U8", "F4", "X", ""];
        tensor(rng, header)["dtype"] = json!(any[rng.random_range(0..any.len())]);
    })
}

fn lacking(rng: &mut Rng) -> Vec<u8> {
    changed(rng, |rng, header| {
        let name = tensor_name(rng, header);
        if let Some(entries) = header.as_object_mut() {
            entries.remove(&name);
        }
    })
}

/// Any number becomes one that no twin has.
fn numbers(rng: &mut Rng, any: &[[u8; 4]]) -> Vec<u8> {
    let (header, mut data) = parts(&valid(rng));
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..data.len() / 4) * 4;
        data[at..at + 4].copy_from_slice(&any[rng.random_range(0..any.len())]);
    }
    join(header.to_string().as_bytes(), &data)
}

fn not_finite(rng: &mut Rng) -> Vec<u8> {
    let any = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0, 1e-45];
    numbers(rng, &any.map(f32::to_le_bytes))
}

fn indices(rng: &mut Rng) -> Vec<u8> {
    numbers(rng, &[3, 4, 9, 1000, u32::MAX - 1, u32::MAX].map(u32::to_le_bytes))
}

fn metadata(rng: &mut Rng) -> Vec<u8> {
    changed(rng, |rng, header| {
        let entry = &mut header["__metadata__"]["bendtwin.twin"];
        let text = entry.as_str().unwrap_or_default().to_owned();
        let new = if rng.random() {
            crate::documents::numbers(rng, text.as_bytes())
        } else {
            damage::any(rng, text.as_bytes())
        };
        *entry = json!(String::from_utf8_lossy(&new));
    })
}

fn brackets(rng: &mut Rng) -> Vec<u8> {
    let text = crate::documents::brackets(rng, b"");
    if rng.random() {
        return join(&text, &[0; 64]);
    }
    changed(rng, |_, header| {
        header["__metadata__"]["bendtwin.twin"] = json!(String::from_utf8_lossy(&text));
    })
}

//! Damage to bytes of any format: cut off, flipped, overwritten, moved.

use rand::RngExt as _;

use crate::Rng;

/// Numbers at which parsers break: signs, limits, off by one.
const NUMBERS: [u64; 14] = [
    0,
    1,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0xFFFF,
    0x7FFF_FFFF,
    0x8000_0000,
    0xFFFF_FFFF,
    0x1_0000_0000,
    0x7FFF_FFFF_FFFF_FFFF,
    0x8000_0000_0000_0000,
    u64::MAX,
];

/// The bytes up to some place.
pub fn cut(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    bytes[..place(rng, bytes)].to_vec()
}

/// Up to eight bits are flipped.
pub fn flip(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..rng.random_range(1..=8) {
        let at = place(rng, bytes);
        if let Some(byte) = out.get_mut(at) {
            *byte ^= 1 << rng.random_range(0..8);
        }
    }
    out
}

/// A number of one, two, four or eight bytes, in either order, over the bytes at some place.
pub fn overwrite(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let number = NUMBERS[rng.random_range(0..NUMBERS.len())];
    let size = 1_usize << rng.random_range(0..4);
    let at = place(rng, bytes);
    let mut new = number.to_le_bytes()[..size].to_vec();
    if rng.random() {
        new.reverse();
    }
    out.iter_mut().skip(at).zip(new).for_each(|(old, new)| *old = new);
    out
}

/// A run of bytes is removed, repeated, or changes places with another.
pub fn shuffle(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let (a, b) = (place(rng, bytes), place(rng, bytes));
    let (from, to) = (a.min(b), a.max(b).min(a.min(b) + 64));
    match rng.random_range(0..3) {
        0 => drop(out.drain(from..to)),
        1 => out = [&bytes[..to], &bytes[from..]].concat(),
        _ => out[from..to].reverse(),
    }
    out
}

/// Any of these kinds of damage.
pub fn any(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    match rng.random_range(0..4) {
        0 => cut(rng, bytes),
        1 => flip(rng, bytes),
        2 => overwrite(rng, bytes),
        _ => shuffle(rng, bytes),
    }
}

/// Replaces one of the words in `from` by one of those in `to`; a text without such words is
/// unchanged.
pub fn reword(rng: &mut Rng, text: &[u8], from: &[&str], to: &[&str]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let present: Vec<&&str> = from.iter().filter(|word| text.contains(**word)).collect();
    let Some(word) = present.get(rng.random_range(0..present.len().max(1))) else {
        return text.into_owned().into_bytes();
    };
    text.replacen(**word, to[rng.random_range(0..to.len())], 1).into_bytes()
}

fn place(rng: &mut Rng, bytes: &[u8]) -> usize {
    if bytes.is_empty() { 0 } else { rng.random_range(0..bytes.len()) }
}

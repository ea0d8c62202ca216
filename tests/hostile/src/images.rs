//! Images: headers that claim pixels which are not there, and chunks that do not fit together.

use png::{BitDepth, ColorType, Compression, Encoder};
use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, samples};

/// Faults of PNG images.
pub const PNG: &[Fault] = &[
    Fault { what: "a PNG with damage", make: |rng| damage::any(rng, &samples::png()) },
    Fault { what: "a PNG of 60000 x 60000", make: |rng| claiming(rng, 60_000, 60_000) },
    Fault { what: "a PNG of the size of a planet", make: |rng| claiming(rng, u32::MAX, u32::MAX) },
    Fault { what: "a PNG that claims no rows", make: |rng| claiming(rng, 16, 0) },
    Fault { what: "a PNG whose pixels do not end", make: excess },
    Fault { what: "a PNG whose pixels unpack a thousandfold", make: bomb },
    Fault { what: "a PNG of another kind of pixel", make: other_kind },
    Fault { what: "a PNG with a chunk of another length", make: wrong_chunk },
    Fault { what: "a PNG with text without end", make: text },
    Fault { what: "a PNG without its end", make: |rng| chopped(rng, &samples::png()) },
];

/// Faults of JPEG images.
pub const JPEG: &[Fault] = &[
    Fault { what: "a JPEG with damage", make: |rng| damage::any(rng, &samples::jpeg()) },
    Fault { what: "a JPEG of 65535 x 65535", make: |rng| sized(rng, 65_535, 65_535) },
    Fault { what: "a JPEG without rows", make: |rng| sized(rng, 0, 16) },
    Fault { what: "a JPEG without its end", make: |rng| chopped(rng, &samples::jpeg()) },
    Fault { what: "a JPEG with a segment of another length", make: wrong_segment },
    Fault { what: "a JPEG of many scans", make: scans },
];

/// Captures with such images.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "colour in a faulty PNG", make: |rng| put(rng, PNG, "color") },
    Fault { what: "colour in a faulty JPEG", make: |rng| put(rng, JPEG, "color") },
    Fault { what: "depth in a faulty PNG", make: |rng| put(rng, PNG, "depth") },
    Fault { what: "a mask in a faulty PNG", make: |rng| put(rng, PNG, "object") },
    Fault { what: "frames that are one large image each", make: large },
];

/// A PNG of one value.
pub fn plain(width: u32, height: u32, color: ColorType, depth: BitDepth) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(Compression::High);
    if color == ColorType::Indexed {
        encoder.set_palette(vec![1, 2, 3]);
    }
    let row = (width as usize * color.samples() * depth as usize).div_ceil(8);
    let mut writer = encoder.write_header().expect("the header is written");
    writer.write_image_data(&vec![0; row * height as usize]).expect("the pixels are written");
    writer.finish().expect("the end is written");
    out
}

fn claiming(rng: &mut Rng, width: u32, height: u32) -> Vec<u8> {
    let mut bytes = if rng.random() { samples::png() } else { samples::depth_png() };
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    sealed(bytes)
}

/// Makes the checksum of the header right.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let crc = crc32fast::hash(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    bytes
}

/// The pixels of a larger image under the header of a small one.
fn excess(rng: &mut Rng) -> Vec<u8> {
    let side = rng.random_range(20..2000);
    let mut bytes = plain(side, side, ColorType::Rgb, BitDepth::Eight);
    bytes[16..20].copy_from_slice(&16_u32.to_be_bytes());
    bytes[20..24].copy_from_slice(&12_u32.to_be_bytes());
    sealed(bytes)
}

fn bomb(rng: &mut Rng) -> Vec<u8> {
    let side = rng.random_range(1000..4000);
    plain(side, side, ColorType::Grayscale, BitDepth::Eight)
}

fn other_kind(rng: &mut Rng) -> Vec<u8> {
    let kinds = [
        (ColorType::Grayscale, BitDepth::One),
        (ColorType::Grayscale, BitDepth::Sixteen),
        (ColorType::GrayscaleAlpha, BitDepth::Eight),
        (ColorType::Indexed, BitDepth::Two),
        (ColorType::Rgba, BitDepth::Sixteen),
        (ColorType::Rgb, BitDepth::Sixteen),
    ];
    let (color, depth) = kinds[rng.random_range(0..kinds.len())];
    let mut bytes = plain(16, 12, color, depth);
    if rng.random() {
        // Kinds that there are not, and rows in seven passes.
        bytes[24] = rng.random_range(0..20);
        bytes[28] = rng.random_range(0..3);
    }
    sealed(bytes)
}

fn wrong_chunk(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = samples::png();
    let length = [0, 1, 0x7FFF_FFFF, u32::MAX, 100_000][rng.random_range(0..5)];
    let at = bytes.windows(4).position(|w| w == b"IDAT").unwrap_or(33);
    bytes[at - 4..at].copy_from_slice(&length.to_be_bytes());
    bytes
}

/// Compressed text before the pixels, which unpacks a thousandfold.
fn text(rng: &mut Rng) -> Vec<u8> {
    let zeros = plain(4000, rng.random_range(1000..4000), ColorType::Grayscale, BitDepth::Eight);
    let start = zeros.windows(4).position(|w| w == b"IDAT").unwrap_or(37) + 4;
    let length = u32::from_be_bytes(zeros[start - 8..start - 4].try_into().unwrap_or_default());
    let content = [b"k\0\0".as_slice(), &zeros[start..start + length as usize]].concat();
    let bytes = samples::png();
    let chunk = chunk(b"zTXt", &content);
    [&bytes[..33], &chunk.repeat(rng.random_range(1..4)), &bytes[33..]].concat()
}

fn chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let body = [kind.as_slice(), content].concat();
    let crc = crc32fast::hash(&body);
    [&(content.len() as u32).to_be_bytes(), body.as_slice(), &crc.to_be_bytes()].concat()
}

fn chopped(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    bytes[..bytes.len() - rng.random_range(1..bytes.len() / 2)].to_vec()
}

/// The place of a segment's length.
fn segment(bytes: &[u8], marker: u8) -> Option<usize> {
    bytes.windows(2).position(|w| w == [0xFF, marker]).map(|at| at + 2)
}

fn sized(_rng: &mut Rng, height: u16, width: u16) -> Vec<u8> {
    let mut bytes = samples::jpeg();
    if let Some(at) = segment(&bytes, 0xC0) {
        bytes[at + 3..at + 5].copy_from_slice(&height.to_be_bytes());
        bytes[at + 5..at + 7].copy_from_slice(&width.to_be_bytes());
    }
    bytes
}

fn wrong_segment(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = samples::jpeg();
    let marker = [0xC0, 0xC4, 0xDB, 0xDA, 0xE0][rng.random_range(0..5)];
    if let Some(at) = segment(&bytes, marker) {
        let length = [0, 1, 2, 3, 0xFFFF][rng.random_range(0..5)];
        bytes[at..at + 2].copy_from_slice(&u16::to_be_bytes(length));
    }
    bytes
}

/// A progressive image that repeats its scan.
fn scans(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = samples::jpeg();
    if let Some(at) = segment(&bytes, 0xC0) {
        bytes[at - 1] = 0xC2;
    }
    let Some(at) = segment(&bytes, 0xDA) else { return bytes };
    let (before, scan) = bytes.split_at(at - 2);
    let end = scan.len() - 2;
    [before, &scan[..end].repeat(rng.random_range(2..200)), &scan[end..]].concat()
}

fn put(rng: &mut Rng, faults: &[Fault], kind: &str) -> Vec<u8> {
    let image = (faults[rng.random_range(0..faults.len())].make)(rng);
    archives::with(samples::raw_bundle(), &format!("cameras/0/{kind}/000001.png"), image)
}

/// Every frame is an image that is large for its bytes.
fn large(rng: &mut Rng) -> Vec<u8> {
    let side = rng.random_range(1500..2500);
    let image = plain(side, side, ColorType::Rgb, BitDepth::Eight);
    let mut files = samples::raw_bundle();
    for (name, bytes) in &mut files {
        if name.contains("/color/") {
            bytes.clone_from(&image);
        } else if name == "capture.json" {
            let text = String::from_utf8_lossy(bytes);
            let [width, height] = samples::SIZE;
            let size = |w: u32, h: u32| format!("{w},\n          {h}\n");
            let [old, new] = [size(width as u32, height as u32), size(side, side)];
            *bytes = text.replace(&old, &new).into_bytes();
        }
    }
    archives::pack(&files)
}

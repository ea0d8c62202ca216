//! The `.spz` of Niantic, versions 2 and 3, from the description in its public repository: a gzip
//! stream of a header of 16 bytes, then all positions, opacities, colours, scales, rotations and
//! harmonics.

use std::io::Read;

use bendtwin_splat::Gaussians;
use flate2::read::GzDecoder;

use super::{Error, HARMONIC, Loaded, check_count};

const MAGIC: u32 = 0x5053_474e;
const HEADER: usize = 16;
/// Bytes of a Gaussian without harmonics, and of its rotation, by version.
const ROTATION_BYTES: [(u32, usize); 2] = [(2, 3), (3, 4)];
/// Spread of the stored colours, in units of a harmonic's coefficient.
const COLOR_SPREAD: f32 = 0.15;

pub(super) fn read(content: &[u8]) -> Result<Loaded, Error> {
    let mut stream = GzDecoder::new(content);
    let mut take = |count: usize| {
        // Grows as bytes come: a header that claims too much takes no memory.
        let mut bytes = Vec::new();
        let found = stream.by_ref().take(count as u64).read_to_end(&mut bytes);
        found.map_err(|e| Error::Damaged(e.to_string()))?;
        if bytes.len() == count {
            Ok(bytes)
        } else {
            Err(Error::Damaged(format!("it ends {} bytes early", count - bytes.len())))
        }
    };
    let header = take(HEADER)?;
    let word = |at: usize| {
        header.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes)
    };
    let (magic, version) = (word(0), word(4));
    if magic != MAGIC {
        return Err(Error::Format);
    }
    let rotation = ROTATION_BYTES.into_iter().find(|(v, _)| *v == version);
    let (_, rotation_bytes) =
        rotation.ok_or_else(|| Error::Unsupported(format!(".spz version {version}")))?;
    let count = check_count(word(8).into())?;
    let (degree, fractional_bits) = (usize::from(header[12]), i32::from(header[13]));
    if degree > 4 || fractional_bits > 23 {
        let text = format!("degree {degree} and {fractional_bits} fractional bits in its header");
        return Err(Error::Damaged(text));
    }
    let positions = take(9 * count)?;
    let opacities = take(count)?;
    let colors = take(3 * count)?;
    let scales = take(3 * count)?;
    let rotations = take(rotation_bytes * count)?;

    let unit = (-fractional_bits as f32).exp2();
    let position = |b: &[u8]| {
        // 24 bits with a sign.
        unit * (i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8) as f32
    };
    let color = |b: u8| 0.5 + HARMONIC * (f32::from(b) / 255.0 - 0.5) / COLOR_SPREAD;
    let three = |bytes: &[u8], value: &dyn Fn(u8) -> f32| {
        bytes.chunks_exact(3).map(|b| [value(b[0]), value(b[1]), value(b[2])]).collect()
    };
    let means = positions.chunks_exact(9);
    let turned = |[x, y, z, w]: [f32; 4]| [x, -y, -z, w];
    let quaternions = rotations.chunks_exact(rotation_bytes);
    let gaussians = Gaussians {
        // Stored with y up; `.ply` files of the same splats have y down and z forward.
        means_m: means.map(|b| [position(b), -position(&b[3..]), -position(&b[6..])]).collect(),
        scales_m: three(&scales, &|b| (f32::from(b) / 16.0 - 10.0).exp()),
        rotations: quaternions.map(|b| turned(quaternion(b))).collect(),
        opacities: opacities.iter().map(|b| f32::from(*b) / 255.0).collect(),
        colors: three(&colors, &color),
    };
    Ok(Loaded { gaussians, left_out_harmonics: (degree + 1).pow(2) - 1 })
}

/// Quaternion x, y, z, w of 3 bytes (x, y, z) or 4 (the smallest three, and the index of the other).
fn quaternion(bytes: &[u8]) -> [f32; 4] {
    let mut q = [0.0; 4];
    let largest = if let [a, b, c, d] = *bytes {
        let mut bits = u32::from_le_bytes([a, b, c, d]);
        let largest = (bits >> 30) as usize;
        for i in (0..4).rev().filter(|i| *i != largest) {
            let size = std::f32::consts::FRAC_1_SQRT_2 * (bits & 511) as f32 / 511.0;
            q[i] = if bits & 512 == 0 { size } else { -size };
            bits >>= 10;
        }
        largest
    } else {
        for (q, b) in q.iter_mut().zip(bytes) {
            *q = f32::from(*b) / 127.5 - 1.0;
        }
        3
    };
    let rest: f32 = q.iter().map(|v| v * v).sum();
    q[largest] = (1.0 - rest).max(0.0).sqrt();
    // Rounded components may be longer than 1 together.
    let length = q.iter().map(|v| v * v).sum::<f32>().sqrt();
    q.map(|v| v / length)
}

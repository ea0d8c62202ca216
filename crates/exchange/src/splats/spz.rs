//! The `.spz` of Niantic, versions 2 to 4, from the description in its public repository: a header,
//! then all positions, opacities, colours, scales, rotations and harmonics. In versions 2 and 3 all
//! of it is one stream of gzip; in version 4 each of them is a stream of Zstandard behind a table
//! ([`streams`]).

mod streams;

use std::io::Read;

use bendtwin_splat::Gaussians;
use flate2::read::GzDecoder;

use super::{Error, HARMONIC, Loaded, check_count};

pub(super) const MAGIC: &[u8] = b"NGSP";
const HEADER: usize = 16;
/// Versions in one stream of gzip, with the bytes of a Gaussian's rotation.
const ROTATION_BYTES: [(u32, usize); 2] = [(2, 3), (3, 4)];
/// Spread of the stored colours, in units of a harmonic's coefficient.
const COLOR_SPREAD: f32 = 0.15;

/// Stored numbers of all Gaussians.
struct Packed {
    /// Bits behind the point of a position.
    fractional_bits: i32,
    /// Degree of the harmonics, which are left out.
    degree: usize,
    /// Directions of the file's axes, against right, down and forward.
    axes: [f32; 3],
    positions: Vec<u8>,
    opacities: Vec<u8>,
    colors: Vec<u8>,
    scales: Vec<u8>,
    rotations: Vec<u8>,
    rotation_bytes: usize,
}

/// Axes where nothing else is said: right, up and back.
const USUAL_AXES: [f32; 3] = [1.0, -1.0, -1.0];

/// Reads a file of any version.
pub(super) fn read(content: &[u8]) -> Result<Loaded, Error> {
    let packed =
        if content.starts_with(MAGIC) { streams::read(content)? } else { of_gzip(content)? };
    Ok(packed.loaded())
}

fn of_gzip(content: &[u8]) -> Result<Packed, Error> {
    let mut stream = GzDecoder::new(content);
    let mut take = |count: usize| take(&mut stream, count);
    let header = take(HEADER)?;
    if !header.starts_with(MAGIC) {
        return Err(Error::Format);
    }
    let version = word(&header, 4);
    let rotation = ROTATION_BYTES.into_iter().find(|(v, _)| *v == version);
    let (_, rotation_bytes) =
        rotation.ok_or_else(|| Error::Unsupported(format!(".spz version {version}")))?;
    let (count, degree, fractional_bits) = numbers(&header)?;
    Ok(Packed {
        fractional_bits,
        degree,
        axes: USUAL_AXES,
        positions: take(9 * count)?,
        opacities: take(count)?,
        colors: take(3 * count)?,
        scales: take(3 * count)?,
        rotations: take(rotation_bytes * count)?,
        rotation_bytes,
    })
}

/// The next `count` bytes of a stream, and no fewer.
fn take(stream: &mut impl Read, count: usize) -> Result<Vec<u8>, Error> {
    // Grows as bytes come: a header that claims too much takes no memory.
    let mut bytes = Vec::new();
    let found = stream.by_ref().take(count as u64).read_to_end(&mut bytes);
    found.map_err(|e| Error::Damaged(e.to_string()))?;
    if bytes.len() == count {
        Ok(bytes)
    } else {
        Err(Error::Damaged(format!("it ends {} bytes early", count - bytes.len())))
    }
}

/// A number of four bytes.
fn word(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes)
}

/// Number of Gaussians, degree of their harmonics, and bits behind the point of a position, which
/// lie at the same places in the headers of all versions.
fn numbers(header: &[u8]) -> Result<(usize, usize, i32), Error> {
    let count = check_count(word(header, 8).into())?;
    let byte = |at: usize| header.get(at).copied().unwrap_or_default();
    let (degree, fractional_bits) = (usize::from(byte(12)), i32::from(byte(13)));
    if degree > 4 || fractional_bits > 23 {
        let text = format!("degree {degree} and {fractional_bits} fractional bits in its header");
        return Err(Error::Damaged(text));
    }
    Ok((count, degree, fractional_bits))
}

impl Packed {
    fn loaded(&self) -> Loaded {
        let [a, b, c] = self.axes;
        let unit = (-self.fractional_bits as f32).exp2();
        let position = |b: &[u8]| {
            // 24 bits with a sign.
            unit * (i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8) as f32
        };
        let color = |b: u8| 0.5 + HARMONIC * (f32::from(b) / 255.0 - 0.5) / COLOR_SPREAD;
        let three = |bytes: &[u8], value: &dyn Fn(u8) -> f32| {
            bytes.chunks_exact(3).map(|b| [value(b[0]), value(b[1]), value(b[2])]).collect()
        };
        let means = self.positions.chunks_exact(9);
        // A mirrored axis turns the other two the other way round.
        let turned = |[x, y, z, w]: [f32; 4]| [b * c * x, a * c * y, a * b * z, w];
        let quaternions = self.rotations.chunks_exact(self.rotation_bytes);
        let gaussians = Gaussians {
            // `.ply` files of the same splats have x right, y down and z forward.
            means_m: means
                .map(|p| [a * position(p), b * position(&p[3..]), c * position(&p[6..])])
                .collect(),
            scales_m: three(&self.scales, &|b| (f32::from(b) / 16.0 - 10.0).exp()),
            rotations: quaternions.map(|q| turned(quaternion(q))).collect(),
            opacities: self.opacities.iter().map(|b| f32::from(*b) / 255.0).collect(),
            colors: three(&self.colors, &color),
        };
        Loaded { gaussians, left_out_harmonics: (self.degree + 1).pow(2) - 1 }
    }
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

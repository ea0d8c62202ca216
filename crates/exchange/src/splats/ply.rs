//! The `.ply` of Gaussian splatting: a vertex for each Gaussian with `x y z`, colours as
//! coefficients of spherical harmonics (`f_dc_0..2`, `f_rest_*`), `opacity` before the logistic
//! function, logarithms of standard deviations (`scale_0..2`), and a quaternion `rot_0..3`, w first.

use std::{collections::HashMap, io::Write};

use bendtwin_splat::Gaussians;

use super::{Error, HARMONIC, Loaded, check_count};

/// Largest header [bytes].
const MOST_HEADER: usize = 1 << 16;
/// Properties in the order in which they are written.
const WRITTEN: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
    "rot_0", "rot_1", "rot_2", "rot_3",
];
/// Smallest distance of an opacity from 0 and 1, whose logits are infinite.
const OPACITY_MARGIN: f32 = 1e-6;
/// Smallest standard deviation [units of the file]; a smaller one would round to zero.
const LEAST_SCALE: f32 = 1e-30;

/// Properties of a vertex, and where its bytes begin.
struct Layout {
    count: usize,
    /// Bytes of a vertex.
    stride: usize,
    /// Offsets of properties that are 32-bit floats.
    floats: HashMap<String, usize>,
    rest: usize,
}

pub(super) fn read(content: &[u8]) -> Result<Loaded, Error> {
    let (header, body) = split(content)?;
    let layout = Layout::of(header)?;
    let needed = layout.count.checked_mul(layout.stride);
    let Some(vertices) = needed.and_then(|n| body.get(..n)) else {
        let (count, bytes) = (layout.count, body.len());
        return Err(Error::Damaged(format!(
            "{count} Gaussians are announced, {bytes} bytes are there"
        )));
    };
    let mut offsets = [0; WRITTEN.len()];
    for (offset, name) in offsets.iter_mut().zip(WRITTEN) {
        *offset = *layout
            .floats
            .get(name)
            .ok_or_else(|| Error::Unsupported(format!("no 32-bit property `{name}`")))?;
    }
    let mut gaussians = Gaussians::default();
    for vertex in vertices.chunks_exact(layout.stride.max(1)) {
        let value = |i: usize| {
            let bytes = vertex.get(offsets[i]..offsets[i] + 4).and_then(|b| b.try_into().ok());
            bytes.map_or(f32::NAN, f32::from_le_bytes)
        };
        gaussians.means_m.push([0, 1, 2].map(value));
        gaussians.colors.push([3, 4, 5].map(|i| 0.5 + HARMONIC * value(i)));
        gaussians.opacities.push(1.0 / (1.0 + (-value(6)).exp()));
        gaussians.scales_m.push(
            [7, 8, 9]
                .map(|i| value(i).exp())
                .map(|s| if s < LEAST_SCALE { LEAST_SCALE } else { s }),
        );
        gaussians.rotations.push(unit([11, 12, 13, 10].map(value)));
    }
    Ok(Loaded { gaussians, left_out_harmonics: layout.rest / 3 })
}

/// Quaternion of length 1, or unchanged if it has no direction.
fn unit(q: [f32; 4]) -> [f32; 4] {
    let length = q.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length > 0.0 { q.map(|v| v / length) } else { q }
}

/// Lines of the header, and the bytes behind it.
fn split(content: &[u8]) -> Result<(&str, &[u8]), Error> {
    const END: &[u8] = b"end_header";
    let head = &content[..content.len().min(MOST_HEADER)];
    let end = head.windows(END.len()).position(|w| w == END);
    let end = end.ok_or_else(|| Error::Damaged("its header has no end".into()))?;
    let after = end + END.len();
    let line = content[after..].iter().take(2).position(|b| *b == b'\n');
    let line = line.ok_or_else(|| Error::Damaged("its header has no end".into()))?;
    let header = std::str::from_utf8(&content[..end]);
    let header = header.map_err(|_| Error::Damaged("its header is no text".into()))?;
    Ok((header, &content[after + line + 1..]))
}

impl Layout {
    fn of(header: &str) -> Result<Self, Error> {
        let mut layout = Self { count: 0, stride: 0, floats: HashMap::new(), rest: 0 };
        let mut element = None;
        for line in header.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["format", "binary_little_endian", _] => {}
                ["format", other, ..] => {
                    return Err(Error::Unsupported(format!("the format {other}")));
                }
                ["element", name, count] => {
                    let is_first = element.is_none();
                    element = Some(name);
                    if name == "vertex" && !is_first {
                        return Err(Error::Unsupported("vertices behind other elements".into()));
                    }
                    if name == "vertex" {
                        let count =
                            count.parse().map_err(|_| Error::Damaged(format!("`{line}`")))?;
                        layout.count = check_count(count)?;
                    }
                }
                ["property", ..] if element != Some("vertex") => {}
                ["property", kind, name] => layout.property(kind, name)?,
                ["property", "list", ..] => {
                    return Err(Error::Unsupported("lists in vertices".into()));
                }
                _ => {}
            }
        }
        Ok(layout)
    }

    fn property(&mut self, kind: &str, name: &str) -> Result<(), Error> {
        let size = match kind {
            "char" | "uchar" | "int8" | "uint8" => 1,
            "short" | "ushort" | "int16" | "uint16" => 2,
            "int" | "uint" | "int32" | "uint32" | "float" | "float32" => 4,
            "double" | "float64" => 8,
            other => return Err(Error::Unsupported(format!("a property of type {other}"))),
        };
        if matches!(kind, "float" | "float32") {
            self.floats.insert(name.to_owned(), self.stride);
            self.rest += usize::from(name.starts_with("f_rest_"));
        }
        self.stride += size;
        Ok(())
    }
}

/// Writes Gaussians as a `.ply` of Gaussian splatting.
///
/// # Errors
/// If writing fails.
pub fn write_ply(gaussians: &Gaussians, out: &mut impl Write) -> std::io::Result<()> {
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment bendtwin: metres, z up\nelement vertex {}\n",
        gaussians.len()
    );
    for name in WRITTEN {
        header += &format!("property float {name}\n");
    }
    out.write_all((header + "end_header\n").as_bytes())?;
    for g in 0..gaussians.len() {
        let [x, y, z, w] = gaussians.rotations[g];
        let opacity = gaussians.opacities[g].clamp(OPACITY_MARGIN, 1.0 - OPACITY_MARGIN);
        let [red, green, blue] = gaussians.colors[g].map(|c| (c - 0.5) / HARMONIC);
        let [mx, my, mz] = gaussians.means_m[g];
        let [sx, sy, sz] = gaussians.scales_m[g].map(f32::ln);
        let logit = (opacity / (1.0 - opacity)).ln();
        let values = [mx, my, mz, red, green, blue, logit, sx, sy, sz, w, x, y, z];
        out.write_all(bytemuck::bytes_of(&values))?;
    }
    Ok(())
}

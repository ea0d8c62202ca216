//! Binary glTF 2.0: points and springs, or a coloured surface; motion as morph targets.
//!
//! Every frame but the first is a morph target, whose weight an animation raises to 1 at the frame's
//! time and lowers again, linearly: between frames positions are mixed linearly too. That is exact
//! for any points; a skin with joints would be smaller for many points on few nodes, but could not
//! carry points beside three nodes, nor more than four weights. glTF has y up: a node above turns the
//! twin's z to it.

use std::io::Write;

use bendtwin_core::{Point, geometry::bounds};
use serde_json::{Value, json};

use crate::{Error, Format, Scene};

/// Most frames of a file: weights are as many as the square of it.
pub(crate) const MAX_FRAMES: usize = 2000;

/// Rotation that turns z up into y up, as a quaternion x, y, z, w.
const Z_TO_Y: [f64; 4] =
    [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Points that move together as one mesh of the file.
struct Part {
    name: &'static str,
    count: usize,
    is_controls: bool,
}

/// Writes the file.
pub(crate) fn write(scene: &Scene<'_>, out: &mut impl Write) -> Result<(), Error> {
    let mut parts = vec![Part { name: "twin", count: scene.point_count(), is_controls: false }];
    // Without control positions of every frame there is nothing to show of them.
    let controls = scene.controls_at(0).len();
    if controls > 0 {
        parts.push(Part { name: "controls", count: controls, is_controls: true });
    }
    let document = Document::of(scene, &parts);
    let mut json = document.json(scene, &parts).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let bytes = 12 + 8 + json.len() as u64 + 8 + document.length;
    let limit = u64::from(u32::MAX);
    let length =
        u32::try_from(bytes).map_err(|_| Error::TooLarge { format: Format::Glb, bytes, limit })?;

    out.write_all(b"glTF")?;
    for word in [2, length, json.len() as u32] {
        out.write_all(&word.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    out.write_all(&(document.length as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    write_data(scene, &parts, out)
}

/// Points of a part in a frame [m].
fn points<'a>(scene: &Scene<'a>, part: &Part, frame: usize) -> std::borrow::Cow<'a, [Point]> {
    if part.is_controls { scene.controls_at(frame).into() } else { scene.points_at(frame) }
}

/// Displacements of a part in a frame from the first one [m]; in frame 0, its positions.
fn target(scene: &Scene<'_>, part: &Part, frame: usize) -> Vec<Point> {
    let now = points(scene, part, frame);
    if frame == 0 {
        return now.into_owned();
    }
    let first = points(scene, part, 0);
    now.iter().zip(&*first).map(|(p, q)| std::array::from_fn(|a| p[a] - q[a])).collect()
}

/// The data, in the order of the accessors.
fn write_data(scene: &Scene<'_>, parts: &[Part], out: &mut impl Write) -> Result<(), Error> {
    let frames = scene.frame_count();
    if frames > 1 {
        for time in scene.times_s().iter() {
            out.write_all(&(*time as f32).to_le_bytes())?;
        }
        for frame in 0..frames {
            let weights: Vec<f32> = (1..frames).map(|f| f32::from(u8::from(f == frame))).collect();
            out.write_all(bytemuck::cast_slice(&weights))?;
        }
    }
    out.write_all(bytemuck::cast_slice(scene.lines()))?;
    out.write_all(bytemuck::cast_slice(scene.triangles()))?;
    for color in scene.colors() {
        out.write_all(bytemuck::cast_slice(&linear(*color)))?;
    }
    for part in parts {
        for frame in 0..frames {
            out.write_all(bytemuck::cast_slice(&target(scene, part, frame)))?;
        }
    }
    Ok(())
}

/// A colour of the format: linear in light, as fractions of 65535, and opaque.
fn linear(color: [u8; 3]) -> [u16; 4] {
    let [r, g, b] = crate::scene::linear(color).map(|x| (x * 65535.0).round() as u16);
    [r, g, b, u16::MAX]
}

/// Accessors with their views, gathered in the order of the data.
#[derive(Default)]
struct Document {
    accessors: Vec<Value>,
    views: Vec<Value>,
    /// Bytes of data.
    length: u64,
    /// Accessors of times and weights, if there is a motion.
    sampler: Option<[usize; 2]>,
    /// Accessors of the indices of lines and triangles.
    lines: Option<usize>,
    triangles: Option<usize>,
    /// Accessor of the colours of the twin's points.
    colors: Option<usize>,
    /// The first accessor of each part's positions.
    positions: Vec<usize>,
}

impl Document {
    fn of(scene: &Scene<'_>, parts: &[Part]) -> Self {
        let mut this = Self::default();
        let frames = scene.frame_count();
        if frames > 1 {
            let times = scene.times_s();
            let ends = [times[0] as f32, times[frames - 1] as f32];
            let about = json!({"min": [ends[0]], "max": [ends[1]]});
            let times = this.add(FLOAT, frames, "SCALAR", 4, &about);
            let weights = this.add(FLOAT, frames * (frames - 1), "SCALAR", 4, &json!({}));
            this.sampler = Some([times, weights]);
        }
        let mut indices = |count: usize| {
            let none = json!({});
            (count > 0).then(|| this.add(UNSIGNED_INT, count, "SCALAR", 4, &none))
        };
        let (lines, triangles) =
            (indices(2 * scene.lines().len()), indices(3 * scene.triangles().len()));
        (this.lines, this.triangles) = (lines, triangles);
        let colors = scene.colors().len();
        let normalized = json!({"normalized": true});
        this.colors =
            (colors > 0).then(|| this.add(UNSIGNED_SHORT, colors, "VEC4", 8, &normalized));
        for part in parts {
            this.positions.push(this.accessors.len());
            for frame in 0..frames {
                // The format requires the bounds of the stored values.
                let [low, high] = bounds(&target(scene, part, frame)).unwrap_or_default();
                this.add(FLOAT, part.count, "VEC3", 12, &json!({"min": low, "max": high}));
            }
        }
        this
    }

    /// Adds an accessor with a separate view; returns its index.
    fn add(&mut self, kind: u32, count: usize, shape: &str, size: u64, about: &Value) -> usize {
        let bytes = count as u64 * size;
        let mut accessor = json!({
            "bufferView": self.views.len(), "componentType": kind, "count": count, "type": shape,
        });
        if let (Some(into), Some(about)) = (accessor.as_object_mut(), about.as_object()) {
            into.extend(about.clone());
        }
        self.accessors.push(accessor);
        self.views.push(json!({"buffer": 0, "byteOffset": self.length, "byteLength": bytes}));
        self.length += bytes;
        self.accessors.len() - 1
    }

    fn json(&self, scene: &Scene<'_>, parts: &[Part]) -> Value {
        let frames = scene.frame_count();
        let meshes: Vec<Value> =
            parts.iter().zip(&self.positions).map(|(p, &at)| self.mesh(p, at, frames)).collect();
        let children: Vec<usize> = (1..=parts.len()).collect();
        let mut nodes =
            vec![json!({"name": scene.name(), "rotation": Z_TO_Y, "children": children})];
        let of = |(mesh, part): (usize, &Part)| json!({"name": part.name, "mesh": mesh});
        nodes.extend(parts.iter().enumerate().map(of));
        // Soft objects do not shine.
        let material = json!({
            "name": "surface",
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.9},
        });
        let mut document = json!({
            "asset": {"version": "2.0", "generator": bendtwin_core::BUILD},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": [material],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.length}],
        });
        if let Some([times, weights]) = self.sampler {
            let channel = |part: usize| json!({"sampler": 0, "target": {"node": part + 1, "path": "weights"}});
            let channels: Vec<Value> = (0..parts.len()).map(channel).collect();
            let sampler = json!({"input": times, "output": weights, "interpolation": "LINEAR"});
            document["animations"] =
                json!([{"name": "motion", "samplers": [sampler], "channels": channels}]);
        }
        document
    }

    /// A mesh of points, with lines or triangles on them; `at` is its first accessor.
    fn mesh(&self, part: &Part, at: usize, frames: usize) -> Value {
        let targets: Vec<Value> = (1..frames).map(|f| json!({"POSITION": at + f})).collect();
        let primitive = |mode: u32, indices: Option<usize>| {
            let mut primitive = json!({"attributes": {"POSITION": at}, "mode": mode});
            if let Some(colors) = self.colors.filter(|_| !part.is_controls) {
                primitive["attributes"]["COLOR_0"] = json!(colors);
            }
            if mode == TRIANGLES {
                primitive["material"] = json!(0);
            }
            if let Some(indices) = indices {
                primitive["indices"] = json!(indices);
            }
            if !targets.is_empty() {
                primitive["targets"] = json!(targets);
            }
            primitive
        };
        let primitives = match (part.is_controls, self.triangles, self.lines) {
            (false, Some(triangles), _) => vec![primitive(TRIANGLES, Some(triangles))],
            (false, None, Some(lines)) => {
                vec![primitive(POINTS, None), primitive(LINES, Some(lines))]
            }
            _ => vec![primitive(POINTS, None)],
        };
        let mut mesh = json!({"name": part.name, "primitives": primitives});
        if !targets.is_empty() {
            mesh["weights"] = json!(vec![0; targets.len()]);
        }
        mesh
    }
}

#[cfg(test)]
mod tests;

//! Light on surfaces: from the sky, and from above the viewer's left shoulder.

use bendtwin_core::{
    Point,
    geometry::{Vector, add, cross, dot, sub, unit, wide},
};
use bendtwin_image_metrics::linear;

use crate::camera::Camera;

/// Direction towards the lamp, in the axes of the picture.
const LAMP: Vector = [-0.42, 0.58, 0.70];
/// Light from everywhere, and from the lamp.
const AMBIENT: f64 = 0.45;
const DIRECT: f64 = 0.75;

/// Unit normals of vertices, the mean of their triangles by area, shape [V, 3].
pub(crate) fn normals(positions: &[Point], triangles: &[[u32; 3]]) -> Vec<Vector> {
    let mut normals = vec![[0.0; 3]; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| wide(positions[i as usize]));
        let area = cross(sub(b, a), sub(c, a));
        for i in triangle {
            normals[*i as usize] = add(normals[*i as usize], area);
        }
    }
    normals.into_iter().map(|normal| unit(normal).unwrap_or([0.0, 0.0, 1.0])).collect()
}

/// Light of a colour (sRGB) on a surface with a normal in the world, each channel from 0.
pub(crate) fn lit(color: [u8; 3], normal: Vector, camera: &Camera) -> [f64; 3] {
    facing(color, camera.turned(normal))
}

/// The same with a normal in the axes of the picture.
pub(crate) fn facing(color: [u8; 3], normal: Vector) -> [f64; 3] {
    let towards = unit(LAMP).map_or(0.0, |lamp| dot(lamp, normal).max(0.0));
    let light = AMBIENT + DIRECT * towards;
    color.map(|channel| light * linear(f64::from(channel) / 255.0))
}

//! Small pictures of objects for lists and for pages that are still loading: the surface of a twin, or points of a
//! recording, seen obliquely from above, in their colours on a transparent background, as PNG.

mod camera;

use bendtwin_core::{
    Point, Surface,
    geometry::{Vector, dot, unit, wide},
};

use self::camera::Camera;
use crate::{
    light::{encoded, linear, normals},
    mesh::PLAIN,
    raster::{Corner, NOTHING, Raster, SAMPLES},
};

/// Widths of pictures [pixels]; their height is three quarters of it.
pub const WIDTHS: std::ops::RangeInclusive<u32> = 16..=1024;

/// Points are about as large as their distance from each other.
const POINT_SHARE: f64 = 0.9;
/// Direction towards the lamp, above the viewer's left shoulder, in the axes of the picture.
const LAMP: Vector = [-0.42, 0.58, 0.70];
/// Light from everywhere, and from the lamp.
const AMBIENT: f64 = 0.45;
const DIRECT: f64 = 0.75;
/// Label of what is drawn.
const DRAWN: u8 = NOTHING + 1;

/// Picture of a surface whose nodes are at `nodes` [m], as PNG; `width` is brought within [`WIDTHS`].
pub fn of_surface(surface: &Surface, nodes: &[Point], width: u32) -> Vec<u8> {
    let positions = surface.positions(nodes);
    let triangles = surface.faces();
    let normals = normals(&positions, &triangles);
    let mut picture = Thumbnail::begin(&positions, width);
    let corners: Vec<Corner> = positions
        .iter()
        .enumerate()
        .map(|(i, point)| {
            let color = surface.colors.get(i).copied().unwrap_or(PLAIN);
            let light = facing(color, picture.camera.turned(wide(normals[i])));
            let ([x, y], nearness) = picture.camera.project(point);
            Corner { x: x as f32, y: y as f32, nearness: nearness as f32, weight: 1.0, light }
        })
        .collect();
    for triangle in &triangles {
        picture.raster.triangle(&triangle.map(|i| corners[i as usize]), DRAWN);
    }
    picture.png()
}

/// Picture of points [m], shape [P, 3], as PNG; `colors` has the colour of each, or is empty.
pub fn of_points(points: &[Point], colors: &[[u8; 3]], width: u32) -> Vec<u8> {
    let seen: Vec<usize> =
        (0..points.len()).filter(|i| points[*i].iter().all(|x| x.is_finite())).collect();
    let finite: Vec<Point> = seen.iter().map(|i| points[*i]).collect();
    let mut picture = Thumbnail::begin(&finite, width);
    let side = (picture.height * SAMPLES) as f64;
    let radius = POINT_SHARE * side / (finite.len() as f64).sqrt().max(4.0);
    for (i, point) in seen.into_iter().zip(&finite) {
        let color = colors.get(i).copied().unwrap_or(PLAIN);
        picture.ball(point, radius, color);
    }
    picture.png()
}

/// Light of a colour (sRGB) on a surface with a normal in the axes of the picture.
fn facing(color: [u8; 3], normal: Vector) -> [f32; 3] {
    let towards = unit(LAMP).map_or(0.0, |lamp| dot(lamp, normal).max(0.0));
    let light = (AMBIENT + DIRECT * towards) as f32;
    linear(color).map(|channel| light * channel)
}

/// A picture that is being drawn.
struct Thumbnail {
    raster: Raster,
    camera: Camera,
    /// Columns and rows [pixels].
    width: usize,
    height: usize,
}

impl Thumbnail {
    fn begin(points: &[Point], width: u32) -> Self {
        let width = width.clamp(*WIDTHS.start(), *WIDTHS.end()) as usize;
        let height = width * 3 / 4;
        let mut raster = Raster::default();
        raster.begin(width, 0, height);
        let camera = Camera::around(points, [width, height].map(|n| n * SAMPLES));
        Self { raster, camera, width, height }
    }

    /// Draws a ball of a radius [samples].
    fn ball(&mut self, point: &Point, radius: f64, color: [u8; 3]) {
        let ([x, y], nearness) = self.camera.project(point);
        let around = |at: f64| [(at - radius) as f32, (at + radius) as f32];
        let window = self.raster.between(around(x), around(y));
        self.raster.fill(window, DRAWN, |column, row| {
            let across = (column as f64 + 0.5 - x) / radius;
            let up = (y - row as f64 - 0.5) / radius;
            let towards = (1.0 - across * across - up * up).max(-1.0);
            (towards >= 0.0).then(|| {
                let towards = towards.sqrt();
                let light = facing(color, [across, up, towards]);
                ((nearness + radius * towards) as f32, light)
            })
        });
    }

    /// The picture as PNG with transparency.
    fn png(&self) -> Vec<u8> {
        let (width, height) = (self.width, self.height);
        let mut pixels = Vec::with_capacity(4 * width * height);
        for i in 0..width * height {
            pixels.extend(self.mean(i % width, i / width));
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        // Only a disk that is full or an impossible size fails, and here is neither.
        let written = encoder.write_header().and_then(|mut file| file.write_image_data(&pixels));
        debug_assert!(written.is_ok(), "{written:?}");
        bytes
    }

    /// Colour and opacity of a pixel: the mean of its samples.
    fn mean(&self, column: usize, row: usize) -> [u8; 4] {
        let samples = self.raster.pixel(column, row);
        let seen = samples.iter().filter(|sample| sample.label != NOTHING);
        let (mut sum, mut count) = ([0.0; 3], 0_usize);
        for sample in seen {
            count += 1;
            sum = [0, 1, 2].map(|k| sum[k] + sample.light[k]);
        }
        let [red, green, blue] = sum.map(|channel| encoded(channel / count.max(1) as f32));
        [red, green, blue, (255 * count / samples.len()) as u8]
    }
}

#[cfg(test)]
mod tests;

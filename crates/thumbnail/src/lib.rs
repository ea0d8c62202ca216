//! Small pictures of objects for lists and for pages that are still loading: the surface of a twin, or points of a
//! recording, seen obliquely from above, in their colours on a transparent background, as PNG.
//!
//! Pictures are the same on every machine: nothing is random and no GPU is used. They are drawn at twice the size
//! and averaged, so that edges are smooth.

mod camera;
mod raster;
mod shade;

use bendtwin_core::{Point, Surface};

use self::{
    camera::Camera,
    raster::{Pixel, Raster},
};

/// Widths of pictures [pixels]; their height is three quarters of it.
pub const WIDTHS: std::ops::RangeInclusive<u32> = 16..=1024;

/// Colour of what has none: a light blue grey.
const PLAIN: [u8; 3] = [142, 170, 191];
/// Points are about as large as their distance from each other.
const POINT_SHARE: f64 = 0.9;

/// Picture of a surface whose nodes are at `nodes` [m], as PNG; `width` is brought within [`WIDTHS`].
pub fn of_surface(surface: &Surface, nodes: &[Point], width: u32) -> Vec<u8> {
    let positions = surface.positions(nodes);
    let triangles = surface.faces();
    let normals = shade::normals(&positions, &triangles);
    let (mut raster, camera) = begin(&positions, width);
    let corners: Vec<Pixel> = positions
        .iter()
        .enumerate()
        .map(|(i, point)| {
            let color = surface.colors.get(i).copied().unwrap_or(PLAIN);
            camera.project(point).with_light(shade::lit(color, normals[i], &camera))
        })
        .collect();
    for triangle in &triangles {
        raster.triangle(triangle.map(|i| corners[i as usize]));
    }
    raster.png()
}

/// Picture of points [m], shape [P, 3], as PNG; `colors` has the colour of each, or is empty.
pub fn of_points(points: &[Point], colors: &[[u8; 3]], width: u32) -> Vec<u8> {
    let seen: Vec<usize> =
        (0..points.len()).filter(|i| points[*i].iter().all(|x| x.is_finite())).collect();
    let finite: Vec<Point> = seen.iter().map(|i| points[*i]).collect();
    let (mut raster, camera) = begin(&finite, width);
    let radius = POINT_SHARE * raster.side() / (finite.len() as f64).sqrt().max(4.0);
    for (i, point) in seen.into_iter().zip(&finite) {
        let color = colors.get(i).copied().unwrap_or(PLAIN);
        raster.ball(camera.project(point), radius, |normal| shade::facing(color, normal));
    }
    raster.png()
}

fn begin(points: &[Point], width: u32) -> (Raster, Camera) {
    let width = width.clamp(*WIDTHS.start(), *WIDTHS.end());
    let raster = Raster::new(width, width * 3 / 4);
    let camera = Camera::around(points, raster.size());
    (raster, camera)
}

#[cfg(test)]
mod tests;

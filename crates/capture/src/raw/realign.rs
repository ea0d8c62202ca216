//! Depth that was measured in another frame than colour, onto the grid of colour: the infrared pair of
//! a stereo camera, a time-of-flight sensor beside the colour sensor.
//!
//! Each measured pixel becomes a point in front of the depth camera, and is drawn where the colour camera
//! sees it, over the area that it covers there. The nearest of several counts. What the depth camera
//! did not see stays empty: nothing is invented behind an edge.

use std::sync::OnceLock;

use super::{DepthImage, Distortion, Image, Intrinsics, Pose, decode::Size};

/// Half of a source pixel's side, and a tenth more: on a slanted surface neighbours move apart.
const HALF: f64 = 0.6;

/// Most columns and rows of colour to each side of its centre that one pixel of depth may cover: depth
/// may be eight times coarser.
const MAX_COVER: i64 = 5;

/// Nearer than this to the colour camera nothing is drawn [m].
const NEAR_M: f64 = 1e-3;

/// Most pixels of depth whose rays are kept; those of larger images are computed anew.
const MAX_KEPT: usize = 1 << 21;

/// Share by which a ray may lie beyond the image's corners: farther out, distortion is meaningless.
const REACH: f64 = 1.2;

/// A pinhole with distortion, and the size of its images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    pub(super) size: Size,
    pub(super) intrinsics: Intrinsics,
    pub(super) distortion: Distortion,
}

/// The depth camera beside a colour camera.
#[derive(Debug)]
pub(super) struct DepthCamera {
    depth: Lens,
    color: Lens,
    /// From the depth camera to the colour camera: `x_color = rotation · x_depth + translation`.
    to_color: Pose,
    /// Largest distance from the optical axis at depth 1 that the colour camera sees.
    reach: f64,
    /// Rays through the centres of the depth camera's pixels, at depth 1.
    rays: OnceLock<Vec<[f32; 2]>>,
}

impl Lens {
    /// Place at depth 1 that appears at a pixel.
    fn ray(&self, pixel: [f64; 2]) -> [f64; 2] {
        self.distortion.undistort(self.intrinsics.plane(pixel))
    }

    /// Pixel at which a place at depth 1 appears.
    fn pixel(&self, ray: [f64; 2]) -> [f64; 2] {
        self.intrinsics.pixel(self.distortion.distort(ray))
    }
}

impl DepthCamera {
    pub(super) fn new(depth: Lens, color: Lens, to_color: Pose) -> Self {
        let [width, height] = color.size.map(|n| n as f64);
        let corners = [[-0.5, -0.5], [width, -0.5], [-0.5, height], [width, height]];
        let far = corners.map(|corner| {
            let [x, y] = color.ray(corner);
            x.hypot(y)
        });
        let reach = REACH * far.into_iter().fold(0.0, f64::max);
        Self { depth, color, to_color, reach, rays: OnceLock::new() }
    }

    /// Size of the depth images.
    pub(super) fn size(&self) -> Size {
        self.depth.size
    }

    /// A depth image on the grid of colour [m], 0 where the depth camera saw nothing.
    pub(super) fn align(&self, depth: &DepthImage) -> DepthImage {
        let [width, height] = self.color.size;
        let mut aligned = Image { width, height, pixels: vec![0.0_f32; width * height] };
        for row in 0..depth.height {
            for (column, &metres) in depth.row(row).iter().enumerate() {
                if metres > 0.0 && metres.is_finite() {
                    self.draw([column, row], f64::from(metres), &mut aligned);
                }
            }
        }
        aligned
    }

    /// Draws one pixel of depth.
    fn draw(&self, at: [usize; 2], metres: f64, aligned: &mut DepthImage) {
        let ray = self.ray(at);
        let Some((centre, z)) = self.place(ray, metres) else { return };
        let i = &self.depth.intrinsics;
        let (mut low, mut high) = (centre, centre);
        for [right, below] in [[-HALF, -HALF], [HALF, -HALF], [-HALF, HALF], [HALF, HALF]] {
            let corner = [ray[0] + right / i.fx, ray[1] + below / i.fy];
            let Some((p, _)) = self.place(corner, metres) else { return };
            low = [low[0].min(p[0]), low[1].min(p[1])];
            high = [high[0].max(p[0]), high[1].max(p[1])];
        }
        let range = |axis: usize| {
            let middle = centre[axis].round() as i64;
            let first = (low[axis].ceil() as i64).max(middle.saturating_sub(MAX_COVER)).max(0);
            let last = (high[axis].floor() as i64).min(middle.saturating_add(MAX_COVER));
            first..=last.min(self.color.size[axis] as i64 - 1)
        };
        let (columns, z) = (range(0), z as f32);
        for r in range(1) {
            for c in columns.clone() {
                let pixel = aligned.pixels.get_mut(r as usize * aligned.width + c as usize);
                let Some(pixel) = pixel else { continue };
                if *pixel == 0.0 || z < *pixel {
                    *pixel = z;
                }
            }
        }
    }

    /// Place at depth 1 of the depth camera that appears at the centre of a pixel.
    fn ray(&self, [column, row]: [usize; 2]) -> [f64; 2] {
        let [width, height] = self.depth.size;
        let compute = |column: usize, row: usize| self.depth.ray([column as f64, row as f64]);
        // Without distortion a ray is two divisions; with it, an iteration.
        if self.depth.distortion == Distortion::None || width * height > MAX_KEPT {
            return compute(column, row);
        }
        let all = || {
            let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
            pixels.map(|(column, row)| compute(column, row).map(|x| x as f32)).collect()
        };
        let kept = self.rays.get_or_init(all).get(row * width + column);
        kept.map_or_else(|| compute(column, row), |ray| ray.map(f64::from))
    }

    /// Pixel of colour at which the place on a ray of the depth camera appears, and its depth there
    /// [m].
    fn place(&self, [x, y]: [f64; 2], metres: f64) -> Option<([f64; 2], f64)> {
        let [x, y, z] = self.to_color.moved([x * metres, y * metres, metres]);
        let ray = [x / z, y / z];
        (z > NEAR_M && ray[0].hypot(ray[1]) <= self.reach).then(|| (self.color.pixel(ray), z))
    }
}

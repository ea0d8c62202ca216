//! Triangles onto pixels: which triangle is nearest in each, where on it, and how far away.

use bendtwin_core::Point;

use bendtwin_capture::raw::Camera;

/// Nearer than this nothing is drawn [m].
const NEAR_M: f64 = 0.05;

/// View of one camera in one frame, pixel by pixel.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    pub(super) width: usize,
    /// Shape [height, width].
    pub(super) hits: Vec<Option<Hit>>,
}

/// Content of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) triangle: u32,
    /// Share of each corner in the point, by perspective.
    pub(super) shares: [f32; 3],
    /// Depth along the optical axis [m].
    pub(super) depth_m: f32,
}

impl Raster {
    /// Draws triangles as a camera without distortion sees them.
    pub(super) fn draw(camera: &Camera, vertices: &[Point], triangles: &[[u32; 3]]) -> Self {
        let (width, height) = (camera.width, camera.height);
        let mut raster = Self { width, hits: vec![None; width * height] };
        let placed: Vec<Option<[f64; 3]>> = vertices
            .iter()
            .map(|v| {
                let ([x, y], depth) = camera.project(*v, 0)?;
                (depth > NEAR_M).then_some([x, y, depth])
            })
            .collect();
        for (number, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| placed.get(v as usize).copied().flatten());
            if let (Some(a), Some(b), Some(c)) = (a, b, c) {
                raster.fill(number as u32, [a, b, c], height);
            }
        }
        raster
    }

    fn fill(&mut self, triangle: u32, [a, b, c]: [[f64; 3]; 3], height: usize) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-12 {
            return;
        }
        let range = |axis: usize, size: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]).ceil().max(0.0);
            let high = a[axis].max(b[axis]).max(c[axis]).floor().min(size as f64 - 1.0);
            // An empty range where the triangle lies outside.
            (low as usize)..((high + 1.0).max(low) as usize)
        };
        let columns = range(0, self.width);
        for row in range(1, height) {
            for column in columns.clone() {
                let (x, y) = (column as f64, row as f64);
                let edge = |p: [f64; 3], q: [f64; 3]| {
                    ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / area
                };
                let flat = [edge(b, c), edge(c, a), edge(a, b)];
                if flat.iter().any(|s| *s < 0.0) {
                    continue;
                }
                let inverse = [flat[0] / a[2], flat[1] / b[2], flat[2] / c[2]];
                let depth = 1.0 / inverse.iter().sum::<f64>();
                let Some(pixel) = self.hits.get_mut(row * self.width + column) else { continue };
                if pixel.is_none_or(|hit| depth < f64::from(hit.depth_m)) {
                    let shares = inverse.map(|s| (s * depth) as f32);
                    *pixel = Some(Hit { triangle, shares, depth_m: depth as f32 });
                }
            }
        }
    }

    /// Content of a pixel, if it lies in the image.
    pub(super) fn get(&self, column: i64, row: i64) -> Option<Hit> {
        let column = usize::try_from(column).ok().filter(|c| *c < self.width)?;
        let row = usize::try_from(row).ok()?;
        *self.hits.get(row * self.width + column)?
    }
}

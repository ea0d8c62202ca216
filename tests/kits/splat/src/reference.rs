//! A plain second rasteriser in f64: every Gaussian at every pixel, covariances as products of whole
//! matrices, no tiles. Its decisions at a pixel, once made, can be held while parameters change, so
//! that finite differences are those of a smooth function.

use bendtwin_splat::{
    Camera, Gaussians, ImageBar,
    constants::{BLUR_PX2, LEAST_ALPHA, LEAST_TRANSMITTANCE, MOST_ALPHA, MOST_TANGENT, NEAR_M},
};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Quaternion, UnitQuaternion, Vector2, Vector3};

/// Relative distance from its threshold within which a decision in f32 may fall otherwise: alpha
/// has the rounding of a pixel's distance, 1e-5 px, times its slope, up to 3 / px.
const MARGIN: f64 = 1e-3;
/// Relative difference of depths within which f32 may order them otherwise.
const DEPTH_MARGIN: f64 = 1e-5;

/// Numbers of a Gaussian: mean, scales, rotation, opacity, colour, shift of the projected centre.
pub(super) const NUMBERS: usize = 16;
/// The first number of each kind.
pub(super) const SCALE: usize = 3;
pub(super) const ROTATION: usize = 6;
pub(super) const OPACITY: usize = 10;
pub(super) const COLOR: usize = 11;
pub(super) const SHIFT: usize = 14;

/// A Gaussian as numbers.
pub(super) type Numbers = [f64; NUMBERS];

/// A projected Gaussian.
#[derive(Clone, Copy)]
struct Flat {
    center: Vector2<f64>,
    inverse: Matrix2<f64>,
    opacity: f64,
    depth: f64,
    color: [f64; 3],
}

/// A Gaussian that a pixel takes.
#[derive(Clone, Copy)]
struct Step {
    gaussian: usize,
    /// True if the opacity is at its upper limit there.
    is_limited: bool,
}

/// A rendering, with its decisions.
pub(super) struct Reference {
    camera: Camera,
    gaussians: Vec<Numbers>,
    flat: Vec<Option<Flat>>,
    /// Gaussians that each pixel takes, front to back.
    steps: Vec<Vec<Step>>,
    decided: Vec<bool>,
}

impl Reference {
    pub(super) fn new(gaussians: &Gaussians, camera: &Camera) -> Self {
        let gaussians: Vec<Numbers> = (0..gaussians.len()).map(|i| numbers(gaussians, i)).collect();
        let flat: Vec<Option<Flat>> = gaussians.iter().map(|g| project(g, camera)).collect();
        let depth = |i: usize| flat[i].map_or(0.0, |f| f.depth);
        let mut order: Vec<usize> = (0..gaussians.len()).filter(|&i| flat[i].is_some()).collect();
        order.sort_by(|&a, &b| depth(a).total_cmp(&depth(b)).then(a.cmp(&b)));
        let mut this =
            Self { camera: *camera, gaussians, flat, steps: Vec::new(), decided: Vec::new() };
        for pixel in 0..camera.pixel_count() {
            let (steps, decided) = this.decide(pixel, &order);
            this.steps.push(steps);
            this.decided.push(decided);
        }
        this
    }

    /// Gaussians that a pixel takes, and whether no decision was close.
    fn decide(&self, pixel: usize, order: &[usize]) -> (Vec<Step>, bool) {
        let mut steps = Vec::new();
        let mut decided = true;
        let mut left = 1.0;
        let mut last = None;
        let close = |x: f64, threshold: f32| (x / f64::from(threshold) - 1.0).abs() < MARGIN;
        for &gaussian in order {
            let Some(flat) = &self.flat[gaussian] else { continue };
            let raw = flat.alpha(self.place(pixel));
            decided &= !close(raw, LEAST_ALPHA);
            if raw < f64::from(LEAST_ALPHA) {
                continue;
            }
            decided &= !close(raw, MOST_ALPHA);
            let is_limited = raw > f64::from(MOST_ALPHA);
            let alpha = if is_limited { f64::from(MOST_ALPHA) } else { raw };
            if let Some(last) = last {
                let apart = (flat.depth - last) / flat.depth;
                decided &= apart == 0.0 || apart > DEPTH_MARGIN;
            }
            last = Some(flat.depth);
            let next = left * (1.0 - alpha);
            decided &= !close(next, LEAST_TRANSMITTANCE);
            if next < f64::from(LEAST_TRANSMITTANCE) {
                break;
            }
            left = next;
            steps.push(Step { gaussian, is_limited });
        }
        (steps, decided)
    }

    fn place(&self, pixel: usize) -> Vector2<f64> {
        let width = self.camera.width as usize;
        Vector2::new((pixel % width) as f64, (pixel / width) as f64)
    }

    /// True if rounding cannot change a decision of the pixel.
    pub(super) fn is_decided(&self, pixel: usize) -> bool {
        self.decided[pixel]
    }

    /// Share of pixels that are decided.
    pub(super) fn decided_share(&self) -> f64 {
        self.decided.iter().filter(|d| **d).count() as f64 / self.decided.len().max(1) as f64
    }

    /// Zeroes derivatives by pixels that are not decided.
    pub(super) fn mask(&self, bar: &mut ImageBar) {
        for pixel in (0..self.decided.len()).filter(|p| !self.decided[*p]) {
            bar.color[pixel] = [0.0; 3];
            bar.alpha[pixel] = 0.0;
            bar.depth_m[pixel] = 0.0;
        }
    }

    /// Red, green, blue, alpha and depth of all pixels.
    pub(super) fn image(&self) -> Vec<[f64; 5]> {
        (0..self.steps.len()).map(|pixel| self.pixel(pixel, &self.flat)).collect()
    }

    /// A pixel, with the same decisions.
    fn pixel(&self, pixel: usize, flat: &[Option<Flat>]) -> [f64; 5] {
        let mut left = 1.0;
        let mut sums = [0.0; 5];
        for step in &self.steps[pixel] {
            let Some(flat) = &flat[step.gaussian] else { continue };
            let raw = flat.alpha(self.place(pixel));
            let alpha = if step.is_limited { f64::from(MOST_ALPHA) } else { raw };
            let [r, g, b] = flat.color;
            for (sum, x) in sums.iter_mut().zip([r, g, b, 1.0, flat.depth]) {
                *sum += alpha * left * x;
            }
            left *= 1.0 - alpha;
        }
        sums
    }

    /// d loss / d numbers of each Gaussian by central differences, for a loss with these
    /// derivatives by pixels.
    pub(super) fn differences(&self, bar: &ImageBar) -> Vec<Numbers> {
        let mut pixels = vec![Vec::new(); self.gaussians.len()];
        for (pixel, steps) in self.steps.iter().enumerate() {
            steps.iter().for_each(|s| pixels[s.gaussian].push(pixel));
        }
        let mut flat = self.flat.clone();
        let mut all = vec![[0.0; NUMBERS]; self.gaussians.len()];
        for (i, out) in all.iter_mut().enumerate() {
            for (k, out) in out.iter_mut().enumerate() {
                let size = match k {
                    0..SCALE => 0.01,
                    SCALE..ROTATION => self.gaussians[i][k],
                    _ => 1.0,
                };
                let step = 1e-6 * size;
                let mut loss = |by: f64| {
                    let mut numbers = self.gaussians[i];
                    numbers[k] += by;
                    flat[i] = project(&numbers, &self.camera);
                    pixels[i].iter().map(|&p| weigh(&self.pixel(p, &flat), bar, p)).sum::<f64>()
                };
                *out = (loss(step) - loss(-step)) / (2.0 * step);
            }
            flat[i] = self.flat[i];
        }
        all
    }
}

impl Flat {
    /// Opacity at a place, before it is limited.
    fn alpha(&self, place: Vector2<f64>) -> f64 {
        let off = place - self.center;
        self.opacity * (-0.5 * off.dot(&(self.inverse * off))).exp()
    }
}

fn weigh(pixel: &[f64; 5], bar: &ImageBar, at: usize) -> f64 {
    let [r, g, b] = bar.color[at];
    let bars = [r, g, b, bar.alpha[at], bar.depth_m[at]];
    pixel.iter().zip(bars).map(|(x, bar)| x * f64::from(bar)).sum()
}

fn numbers(gaussians: &Gaussians, i: usize) -> Numbers {
    let mut numbers = [0.0; NUMBERS];
    let own = gaussians.means_m[i].iter().chain(&gaussians.scales_m[i]);
    let own = own.chain(&gaussians.rotations[i]).chain([&gaussians.opacities[i]]);
    for (to, from) in numbers.iter_mut().zip(own.chain(&gaussians.colors[i])) {
        *to = f64::from(*from);
    }
    numbers
}

fn project(n: &Numbers, camera: &Camera) -> Option<Flat> {
    let m = camera.world_to_camera.map(|row| row.map(f64::from));
    let w = Matrix3::from_fn(|r, c| m[r][c]);
    let mean = w * Vector3::new(n[0], n[1], n[2]) + Vector3::new(m[0][3], m[1][3], m[2][3]);
    let z = mean.z;
    if z < f64::from(NEAR_M) {
        return None;
    }
    let q = &n[ROTATION..OPACITY];
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[3], q[0], q[1], q[2]));
    let scales = Vector3::new(n[SCALE], n[SCALE + 1], n[SCALE + 2]);
    let spread = turn.to_rotation_matrix().into_inner() * Matrix3::from_diagonal(&scales);
    let limit = f64::from(MOST_TANGENT);
    let tangents = [mean.x / z, mean.y / z].map(|t| t.clamp(-limit, limit));
    let (fx, fy) = (f64::from(camera.fx), f64::from(camera.fy));
    let jacobian =
        Matrix2x3::new(fx / z, 0.0, -fx * tangents[0] / z, 0.0, fy / z, -fy * tangents[1] / z);
    let half = jacobian * w * spread;
    let sharp = half * half.transpose();
    let blurred = sharp + Matrix2::identity() * f64::from(BLUR_PX2);
    let compensation = (sharp.determinant().max(0.0) / blurred.determinant()).sqrt();
    Some(Flat {
        center: Vector2::new(
            fx * mean.x / z + f64::from(camera.cx) + n[SHIFT],
            fy * mean.y / z + f64::from(camera.cy) + n[SHIFT + 1],
        ),
        inverse: blurred.try_inverse()?,
        opacity: n[OPACITY] * compensation,
        depth: z,
        color: [n[COLOR], n[COLOR + 1], n[COLOR + 2]],
    })
}

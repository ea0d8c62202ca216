//! Triangles and balls in a picture with depths.

use bendtwin_core::geometry::Vector;

/// Samples of a pixel along each side.
const SAMPLES: usize = 2;

/// A place in the picture [samples], with the light that comes from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Grows towards the viewer.
    pub(crate) depth: f64,
    pub(crate) light: [f64; 3],
}

impl Pixel {
    pub(crate) fn with_light(self, light: [f64; 3]) -> Self {
        Self { light, ..self }
    }
}

/// Samples of a picture.
#[derive(Clone, Debug)]
pub(crate) struct Raster {
    width: usize,
    height: usize,
    depths: Vec<f64>,
    /// Light of what is nearest; unset where the depth is that of nothing.
    light: Vec<[f32; 3]>,
}

impl Raster {
    /// An empty picture of this size [pixels].
    pub(crate) fn new(width: u32, height: u32) -> Self {
        let [width, height] = [width, height].map(|n| n as usize * SAMPLES);
        let count = width * height;
        Self { width, height, depths: vec![f64::NEG_INFINITY; count], light: vec![[0.0; 3]; count] }
    }

    /// Samples along each side.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The shorter side [samples].
    pub(crate) fn side(&self) -> f64 {
        self.height as f64
    }

    /// Draws a triangle.
    pub(crate) fn triangle(&mut self, [a, b, c]: [Pixel; 3]) {
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if !area.is_normal() {
            return;
        }
        let [low_x, high_x] = range([a.x, b.x, c.x], self.width);
        let [low_y, high_y] = range([a.y, b.y, c.y], self.height);
        for y in low_y..high_y {
            for x in low_x..high_x {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let of_b = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
                let of_c = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
                let of_a = 1.0 - of_b - of_c;
                if of_a < 0.0 || of_b < 0.0 || of_c < 0.0 {
                    continue;
                }
                let mix = |of: fn(&Pixel, usize) -> f64, k: usize| {
                    of_a * of(&a, k) + of_b * of(&b, k) + of_c * of(&c, k)
                };
                let light = [0, 1, 2].map(|k| mix(|pixel, k| pixel.light[k], k));
                self.set(x, y, mix(|pixel, _| pixel.depth, 0), light);
            }
        }
    }

    /// Draws a ball of a radius [samples] whose light depends on its normal in the axes of the picture.
    pub(crate) fn ball(&mut self, at: Pixel, radius: f64, light: impl Fn(Vector) -> [f64; 3]) {
        let [low_x, high_x] = range([at.x - radius, at.x, at.x + radius], self.width);
        let [low_y, high_y] = range([at.y - radius, at.y, at.y + radius], self.height);
        for y in low_y..high_y {
            for x in low_x..high_x {
                let across = (x as f64 + 0.5 - at.x) / radius;
                let up = (at.y - y as f64 - 0.5) / radius;
                let square = across * across + up * up;
                if square <= 1.0 {
                    let towards = (1.0 - square).sqrt();
                    self.set(x, y, at.depth + radius * towards, light([across, up, towards]));
                }
            }
        }
    }

    fn set(&mut self, x: usize, y: usize, depth: f64, light: [f64; 3]) {
        let i = y * self.width + x;
        if depth > self.depths[i] {
            self.depths[i] = depth;
            self.light[i] = light.map(|channel| channel as f32);
        }
    }

    /// The picture as PNG with transparency.
    pub(crate) fn png(&self) -> Vec<u8> {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
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
    fn mean(&self, x: usize, y: usize) -> [u8; 4] {
        let (mut sum, mut seen) = ([0.0; 3], 0);
        for k in 0..SAMPLES * SAMPLES {
            let (row, column) = (y * SAMPLES + k / SAMPLES, x * SAMPLES + k % SAMPLES);
            let i = row * self.width + column;
            if self.depths[i] > f64::NEG_INFINITY {
                seen += 1;
                for (sum, light) in sum.iter_mut().zip(self.light[i]) {
                    *sum += f64::from(light);
                }
            }
        }
        let count = f64::from(seen).max(1.0);
        let [red, green, blue] = sum.map(|channel| encoded(channel / count));
        [red, green, blue, (255 * seen / (SAMPLES * SAMPLES) as i32) as u8]
    }
}

/// The sRGB byte of a light.
fn encoded(light: f64) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value =
        if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    (255.0 * value).round() as u8
}

/// First sample and end of those between places, within a side.
fn range(places: [f64; 3], side: usize) -> [usize; 2] {
    let low = places.iter().copied().fold(f64::INFINITY, f64::min);
    let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // The conversion saturates, and makes 0 of what is not a number.
    [low.floor().max(0.0) as usize, ((high.ceil().max(0.0)) as usize + 1).min(side)]
}

//! Images whose pixels a formula gives, so that other programs can make them too.

use crate::{Image, Pair};

/// Two images of one size.
pub(crate) struct Scene {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) a: Vec<[f32; 3]>,
    pub(crate) b: Vec<[f32; 3]>,
}

impl Scene {
    fn from_fn(width: u32, height: u32, color: impl Fn(u32, u32) -> [[f32; 3]; 2]) -> Self {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let (a, b) = pixels.map(|(x, y)| color(x, y)).map(|[a, b]| (a, b)).unzip();
        Self { width, height, a, b }
    }

    pub(crate) fn pair<'a>(&'a self, valid: Option<&'a [bool]>) -> Pair<'a> {
        let image = |pixels| Image::new(self.width, self.height, pixels).unwrap();
        Pair::new(image(&self.a), image(&self.b), valid).unwrap()
    }

    /// Paints invalid pixels of both black.
    pub(crate) fn black_out(&mut self, valid: &[bool]) {
        for pixels in [&mut self.a, &mut self.b] {
            for (pixel, valid) in pixels.iter_mut().zip(valid) {
                if !valid {
                    *pixel = [0.0; 3];
                }
            }
        }
    }
}

/// Texture of 48 x 40 pixels in multiples of 1/64, with 6 black pixels on each side:
/// a = (7x + 13y + 29c + (xy mod 11)) mod 64, and b with ((x² + 3y + c + 2) mod 9) more before the
/// last mod.
pub(crate) fn tiles() -> Scene {
    Scene::from_fn(48, 40, |x, y| {
        if !((6..42).contains(&x) && (6..34).contains(&y)) {
            return [[0.0; 3]; 2];
        }
        let base = |c: usize| 7 * x + 13 * y + 29 * c as u32 + (x * y) % 11;
        let more = |c: usize| (x * x + 3 * y + c as u32 + 2) % 9;
        let color =
            |value: &dyn Fn(usize) -> u32| std::array::from_fn(|c| (value(c) % 64) as f32 / 64.0);
        [color(&base), color(&|c| base(c) + more(c))]
    })
}

/// Gradients of 60 x 50 pixels: a = (x/59, y/49, (x+y)/108), and b a quarter darker in a block and
/// with the last channel turned round in another.
pub(crate) fn smooth() -> Scene {
    Scene::from_fn(60, 50, |x, y| {
        let a = [f64::from(x) / 59.0, f64::from(y) / 49.0, f64::from(x + y) / 108.0];
        let mut b = a;
        if (12..25).contains(&y) && (15..30).contains(&x) {
            b = b.map(|v| 0.75 * v);
        }
        if y >= 25 && x >= 30 {
            b[2] = 1.0 - b[2];
        }
        [a, b].map(|color| color.map(|v| v as f32))
    })
}

//! Pixels that come from elsewhere (a camera, a heat map) on their way onto a canvas.

/// Pixels without transparency, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Photograph {
    /// A photograph of red, green, blue; `None` if there are not `width * height` pixels, or no
    /// pixels.
    pub fn new(width: usize, height: usize, pixels: Vec<[u8; 3]>) -> Option<Self> {
        let whole = width > 0 && height > 0 && width.checked_mul(height) == Some(pixels.len());
        whole.then_some(Self { width, height, pixels })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The mean colour of the cell `[from, to)` in columns and rows, at least the pixel that
    /// contains `from`.
    pub(crate) fn mean(&self, from: [f32; 2], to: [f32; 2]) -> [u8; 3] {
        let range = |a: usize, end: usize| {
            let first = (from[a].max(0.0) as usize).min(end - 1);
            first..(to[a].ceil().max(0.0) as usize).clamp(first + 1, end)
        };
        let (mut sum, mut count) = ([0_u32; 3], 0);
        for row in range(1, self.height) {
            for column in range(0, self.width) {
                let Some(pixel) = self.pixels.get(row * self.width + column) else { continue };
                sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += u32::from(*p));
                count += 1;
            }
        }
        sum.map(|s| (s / count.max(1)) as u8)
    }
}

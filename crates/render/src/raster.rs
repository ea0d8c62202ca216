//! Samples of a picture, or of a band of its rows, with what is nearest at each.
//!
//! Nearness is any quantity that grows towards the viewer and is linear in the picture: the inverse of the depth for
//! a pinhole camera, the place along the axis of view for a parallel projection.

/// Samples of a pixel along each side.
pub(crate) const SAMPLES: usize = 2;
/// Label of samples where nothing was drawn.
pub(crate) const NOTHING: u8 = 0;
/// Barycentric coordinate down to which a sample is within a triangle: rounding must leave no cracks between
/// neighbours.
const EDGE: f32 = -1e-5;

/// A corner of a triangle in the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// Place [samples]; the centre of the first sample is at (0.5, 0.5).
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) nearness: f32,
    /// Weight in the mean of lights: the inverse of the depth, or 1 in a parallel projection.
    pub(crate) weight: f32,
    /// Light that comes from there.
    pub(crate) light: [f32; 3],
}

/// A part of the picture [samples]: first column and row, and those after the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) columns: [usize; 2],
    pub(crate) rows: [usize; 2],
}

/// A sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    pub(crate) nearness: f32,
    pub(crate) light: [f32; 3],
    /// [`NOTHING`], or the label of what is nearest.
    pub(crate) label: u8,
}

const EMPTY: Sample = Sample { nearness: f32::NEG_INFINITY, light: [0.0; 3], label: NOTHING };

/// Samples of a band of rows of a picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Raster {
    /// Columns, first row and number of rows [samples].
    width: usize,
    first_row: usize,
    rows: usize,
    samples: Vec<Sample>,
}

impl Raster {
    /// Memory of a pixel [bytes].
    pub(crate) const PIXEL_BYTES: usize = SAMPLES * SAMPLES * size_of::<Sample>();

    /// Begins a band of a picture: its width, the first row and their number [pixels].
    pub(crate) fn begin(&mut self, width: usize, first_row: usize, rows: usize) {
        [self.width, self.first_row, self.rows] = [width, first_row, rows].map(|n| n * SAMPLES);
        self.samples.clear();
        self.samples.resize(self.width * self.rows, EMPTY);
    }

    /// The whole band.
    pub(crate) fn window(&self) -> Window {
        let rows = [self.first_row, self.first_row + self.rows];
        Window { columns: [0, self.width], rows }
    }

    /// The samples of the band whose centres may lie between places [samples].
    pub(crate) fn between(&self, x: [f32; 2], y: [f32; 2]) -> Window {
        let whole = self.window();
        let within = |[low, high]: [f32; 2], [first, end]: [usize; 2]| {
            // The conversion saturates, and makes 0 of what is not a number.
            let from = ((low - 0.5).ceil().max(0.0) as usize).clamp(first, end);
            let to = ((high + 0.5).floor().max(0.0) as usize).clamp(first, end);
            [from, to.max(from)]
        };
        Window { columns: within(x, whole.columns), rows: within(y, whole.rows) }
    }

    /// Draws a triangle.
    pub(crate) fn triangle(&mut self, [a, b, c]: &[Corner; 3], label: u8) {
        let least = |p: f32, q: f32, r: f32| p.min(q).min(r);
        let most = |p: f32, q: f32, r: f32| p.max(q).max(r);
        let window = self.between(
            [least(a.x, b.x, c.x), most(a.x, b.x, c.x)],
            [least(a.y, b.y, c.y), most(a.y, b.y, c.y)],
        );
        let ([low, high], [top, bottom]) = (window.columns, window.rows);
        if low == high || top == bottom {
            return;
        }
        // Corners may be far outside of the picture.
        let wide = |p: &Corner| [f64::from(p.x), f64::from(p.y)];
        let ([ax, ay], [bx, by], [cx, cy]) = (wide(a), wide(b), wide(c));
        let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
        if !area.is_normal() {
            return;
        }
        let step_b = ((cy - ay) / area) as f32;
        let step_c = ((ay - by) / area) as f32;
        let px = low as f64 + 0.5 - ax;
        for y in top..bottom {
            let py = y as f64 + 0.5 - ay;
            let first_b = ((px * (cy - ay) - (cx - ax) * py) / area) as f32;
            let first_c = (((bx - ax) * py - px * (by - ay)) / area) as f32;
            let start = (y - self.first_row) * self.width;
            let row = &mut self.samples[start + low..start + high];
            for (k, sample) in row.iter_mut().enumerate() {
                let of_b = first_b + k as f32 * step_b;
                let of_c = first_c + k as f32 * step_c;
                let of_a = 1.0 - of_b - of_c;
                if of_a < EDGE || of_b < EDGE || of_c < EDGE {
                    continue;
                }
                let nearness = of_a * a.nearness + of_b * b.nearness + of_c * c.nearness;
                if nearness <= sample.nearness {
                    continue;
                }
                let weights = [of_a * a.weight, of_b * b.weight, of_c * c.weight];
                let share = 1.0 / (weights[0] + weights[1] + weights[2]);
                let [of_a, of_b, of_c] = weights.map(|weight| weight * share);
                let mix = |k: usize| of_a * a.light[k] + of_b * b.light[k] + of_c * c.light[k];
                *sample = Sample { nearness, light: [mix(0), mix(1), mix(2)], label };
            }
        }
    }

    /// Draws what a function finds at the samples of a window: nearness and light at a row and a column [samples].
    pub(crate) fn fill(
        &mut self,
        window: Window,
        label: u8,
        find: impl Fn(usize, usize) -> Option<(f32, [f32; 3])>,
    ) {
        let [low, high] = window.columns;
        for y in window.rows[0]..window.rows[1] {
            let start = (y - self.first_row) * self.width;
            let row = &mut self.samples[start + low..start + high];
            for (sample, x) in row.iter_mut().zip(low..) {
                if let Some((nearness, light)) = find(x, y)
                    && nearness > sample.nearness
                {
                    *sample = Sample { nearness, light, label };
                }
            }
        }
    }

    /// The samples of a pixel of the band, by its column and its row within the band [pixels].
    pub(crate) fn pixel(&self, column: usize, row: usize) -> [Sample; SAMPLES * SAMPLES] {
        let upper = SAMPLES * (row * self.width + column);
        let lower = upper + self.width;
        let of = |i: usize| self.samples[i];
        [of(upper), of(upper + 1), of(lower), of(lower + 1)]
    }
}

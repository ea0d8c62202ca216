//! Samples of space on a cubic grid.

use bendtwin_core::{
    Point,
    geometry::{bounds, wide},
};

/// A cubic grid; x changes fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    /// The first sample [m].
    pub(crate) low: [f64; 3],
    /// Distance of neighbouring samples [m].
    pub(crate) cell_m: f64,
    /// Samples along each axis.
    pub(crate) size: [usize; 3],
}

impl Grid {
    /// A grid with cells of `cell_m`, or larger ones if the samples were more than `most`. It reaches beyond all
    /// points by the margin for its cells. `None` without points.
    pub(crate) fn around(
        points: &[Point],
        margin_m: impl Fn(f64) -> f64,
        cell_m: f64,
        most: usize,
    ) -> Option<Self> {
        let [low, high] = bounds(points)?.map(wide);
        let samples = |cell_m: f64| -> [f64; 3] {
            let extent = |a: usize| high[a] - low[a] + 2.0 * margin_m(cell_m);
            std::array::from_fn(|a| (extent(a) / cell_m).ceil() + 1.0)
        };
        let mut cell_m = cell_m;
        while samples(cell_m).iter().product::<f64>() > most as f64 {
            cell_m *= 1.1;
        }
        let size = samples(cell_m).map(|n| n as usize);
        Some(Self { low: low.map(|x| x - margin_m(cell_m)), cell_m, size })
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Number of the sample at these steps along the axes.
    pub(crate) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// Steps along the axes of a sample.
    pub(crate) fn steps(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// Position of steps along the axes, which may be fractions [m].
    pub(crate) fn place(&self, steps: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.low[a] + steps[a] * self.cell_m)
    }

    /// Steps along the axes of a position; fractions.
    pub(crate) fn steps_to(&self, p: Point) -> [f64; 3] {
        std::array::from_fn(|a| (f64::from(p[a]) - self.low[a]) / self.cell_m)
    }

    /// The nearest sample of a position, if it is within the grid.
    pub(crate) fn nearest(&self, p: Point) -> Option<usize> {
        let steps = self.steps_to(p).map(f64::round);
        let is_within = (0..3).all(|a| steps[a] >= 0.0 && steps[a] < self.size[a] as f64);
        is_within.then(|| self.index(steps.map(|s| s as usize)))
    }

    /// Samples beside a sample along the axes.
    pub(crate) fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (steps, size) = (self.steps(index), self.size);
        let strides = [1, size[0], size[0] * size[1]];
        (0..3).flat_map(move |a| {
            let below = (steps[a] > 0).then(|| index - strides[a]);
            let above = (steps[a] + 1 < size[a]).then(|| index + strides[a]);
            below.into_iter().chain(above)
        })
    }
}

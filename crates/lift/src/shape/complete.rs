//! Completion of what no camera saw: points of a completed shape, each kind only where the kinds
//! before it (observed, surface, interior) have no points.

use bendtwin_core::{Point, settings::ingest::CompletionSettings};

use crate::{grid::Grid, thin::spread};

/// A shape in the world at the first frame [m]: points on its surface, and on a grid inside.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shape {
    pub(crate) surface: Vec<Point>,
    pub(crate) interior: Vec<Point>,
}

/// Points of the shape that keep their distance from observed ones and from each other.
pub(crate) fn complete(observed: &[Point], shape: &Shape, settings: &CompletionSettings) -> Shape {
    // Neighbours on a grid are as far apart as the spacing but for rounding.
    let spacing = 0.999 * settings.spacing_m;
    let mut grid = Grid::of(observed.iter().copied(), spacing);
    let mut fill = |points: &[Point]| -> Vec<Point> {
        let finite = points.iter().copied().enumerate();
        let finite = finite.filter(|(_, p)| p.iter().all(|x| x.is_finite()));
        let mut kept = spread(&mut grid, finite, spacing);
        kept.truncate(settings.max_points as usize);
        kept.into_iter().map(|i| points[i]).collect()
    };
    let surface = fill(&shape.surface);
    let interior = fill(&shape.interior);
    Shape { surface, interior }
}

#[cfg(test)]
mod tests;

//! 2D tracks from arrays.

use super::Tracks;
use crate::{Error, array::Array, files::at_most, limits::Budget};

/// Order of a track's two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Column, row.
    Xy,
    /// Row, column.
    RowColumn,
}

/// Joins positions [T, N, 2] and visibilities [T, N].
pub(super) fn join(
    points: &Array<'_>,
    visible: Option<&Array<'_>>,
    order: Order,
    frame_count: usize,
    limit: usize,
    budget: &mut Budget,
) -> Result<Tracks, Error> {
    let count = match points.shape.as_slice() {
        &[frames, count, 2] if frames == frame_count => count,
        _ => return Err(points.wrong_shape(&format!("[{frame_count}, N, 2]"))),
    };
    at_most("tracks of a camera", count, limit)?;
    let flat = points.floats(budget)?;
    budget.take(flat.len() as u64 * 4, &points.at)?;
    let pairs = flat.as_chunks::<2>().0.iter();
    let points: Vec<[f32; 2]> = match order {
        Order::Xy => pairs.copied().collect(),
        Order::RowColumn => pairs.map(|[row, column]| [*column, *row]).collect(),
    };
    let mut seen = match visible {
        None => vec![true; points.len()],
        Some(visible) if visible.shape == [frame_count, count] => visible.bools(budget)?,
        Some(visible) => {
            return Err(visible.wrong_shape(&format!("[{frame_count}, {count}] as the positions")));
        }
    };
    for (seen, p) in seen.iter_mut().zip(&points) {
        *seen &= p.iter().all(|x| x.is_finite());
    }
    Ok(Tracks { count, points, visible: seen })
}

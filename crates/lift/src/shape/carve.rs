//! The object's whole shape at the first frame from what cameras did not see through: space carving.
//!
//! A cell of space belongs to the object if no camera looks through it (Kutulakos and Seitz 2000, "A
//! theory of shape by space carving"), two cameras have it behind what their masks show, it lies
//! above the ground, and the way to the object's surface, through such cells, is shorter than the way
//! to the hand's. Hands hide what they hold: `grip` continues the object's section into them where
//! it vanishes.

mod grip;
mod volume;

use std::{cmp::Reverse, collections::BinaryHeap};

use bendtwin_core::{CancelToken, Plane, Point};
use rayon::prelude::*;

use self::volume::Volume;
use super::{
    complete::Shape,
    sight::{FirstView, Sight},
};
use crate::{Error, error::check, grid::Grid, survey::clean::Label, thin::spread};

/// Cameras that must have a cell behind what they see. One alone sees a silhouette without an end.
pub(crate) const LEAST_VIEWS: usize = 2;
/// Cells visited between two checks for cancellation.
const CELLS_AT_ONCE: usize = 1 << 14;

/// Evidence of the first frame.
pub(crate) struct FirstFrame<'a> {
    pub(crate) views: &'a [FirstView<'a>],
    /// The object's surface, as all cameras see it [m].
    pub(crate) object: &'a [Point],
    /// The hands' surface, as all cameras see it [m].
    pub(crate) hands: &'a [Point],
    pub(crate) ground: Option<Plane>,
}

/// The object's shape, and the number of its cells that hands hide. `None` if too few cameras saw it.
pub(crate) fn carve(
    seen: &FirstFrame<'_>,
    spacing_m: f64,
    cancel: &CancelToken,
) -> Result<Option<(Shape, usize)>, Error> {
    if seen.views.len() < LEAST_VIEWS {
        return Ok(None);
    }
    let Some(volume) = Volume::around(seen.object, spacing_m) else { return Ok(None) };
    let cells = cells(&volume, seen, cancel)?;
    let owners = owners(&volume, &cells, seen, cancel)?;
    let is_object =
        |(owner, cell): (&Label, &Cell)| *owner == Label::Object && cell.views >= LEAST_VIEWS;
    let mut solid: Vec<bool> = owners.iter().zip(&cells).map(is_object).collect();
    let hidden: Vec<bool> =
        cells.iter().zip(&solid).map(|(c, solid)| c.open && c.behind_hand && !solid).collect();
    let held = grip::fill(&volume, &mut solid, &hidden, seen.hands, cancel)?;
    let (surface, interior) = (0..volume.count())
        .filter(|i| solid[*i])
        .partition::<Vec<_>, _>(|i| volume.faces(*i).iter().any(|j| j.is_none_or(|j| !solid[j])));
    // The visible surface, then the walls of the hidden space.
    let mut grid = Grid::new(spacing_m);
    let observed = spread(&mut grid, seen.object.iter().copied().enumerate(), spacing_m);
    let observed = observed.into_iter().map(|i| seen.object[i]);
    let surface = observed.chain(surface.into_iter().map(|i| volume.centre(i))).collect();
    let interior = interior.into_iter().map(|i| volume.centre(i)).collect();
    Ok(Some((Shape { surface, interior }, held)))
}

/// Knowledge of all cameras together about a cell.
#[derive(Clone, Copy, Default)]
struct Cell {
    /// No camera looks through it, nor is it below the ground.
    open: bool,
    /// Cameras that have it behind what a mask shows.
    views: usize,
    /// A camera has it behind a hand.
    behind_hand: bool,
}

fn cells(volume: &Volume, seen: &FirstFrame<'_>, cancel: &CancelToken) -> Result<Vec<Cell>, Error> {
    let know = |i: usize| {
        let centre = volume.centre(i);
        let above = |g: &Plane| {
            let height: f32 = (0..3).map(|a| g.normal[a] * centre[a]).sum();
            height > g.offset_m
        };
        if !seen.ground.as_ref().is_none_or(above) {
            return Cell::default();
        }
        let mut cell = Cell { open: true, ..Cell::default() };
        for view in seen.views {
            match view.sight(centre) {
                Sight::Empty => return Cell::default(),
                Sight::Unknown => {}
                Sight::Behind(label) => {
                    cell.views += 1;
                    cell.behind_hand |= label == Label::Manipulator;
                }
            }
        }
        cell
    };
    let mut cells = Vec::with_capacity(volume.count());
    while cells.len() < volume.count() {
        check(cancel)?;
        let end = (cells.len() + CELLS_AT_ONCE).min(volume.count());
        cells.par_extend((cells.len()..end).into_par_iter().map(know));
    }
    Ok(cells)
}

/// Owner of each open cell: the label whose surface is nearest along open cells; `Label::None` for
/// cells that no path reaches.
fn owners(
    volume: &Volume,
    cells: &[Cell],
    seen: &FirstFrame<'_>,
    cancel: &CancelToken,
) -> Result<Vec<Label>, Error> {
    let mut owner = vec![Label::None; cells.len()];
    let mut ways_m = vec![f64::INFINITY; cells.len()];
    // Distances are not negative, so their bits have the same order.
    let mut next = BinaryHeap::new();
    for (label, points) in [(Label::Object, seen.object), (Label::Manipulator, seen.hands)] {
        for cell in points.iter().filter_map(|p| volume.cell(*p)) {
            next.push(Reverse((0_u64, cell, label == Label::Manipulator)));
        }
    }
    let mut visited = 0;
    while let Some(Reverse((bits, cell, hand))) = next.pop() {
        if owner[cell] != Label::None {
            continue;
        }
        if visited % CELLS_AT_ONCE == 0 {
            check(cancel)?;
        }
        visited += 1;
        owner[cell] = if hand { Label::Manipulator } else { Label::Object };
        for (other, step_m) in volume.around_cell(cell) {
            let way_m = f64::from_bits(bits) + step_m;
            if owner[other] == Label::None && cells[other].open && way_m <= ways_m[other] {
                ways_m[other] = way_m;
                next.push(Reverse((way_m.to_bits(), other, hand)));
            }
        }
    }
    Ok(owner)
}

#[cfg(test)]
mod tests;

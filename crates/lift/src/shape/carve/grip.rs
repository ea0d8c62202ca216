//! The part of the object that the hand which holds it hides.
//!
//! The last cells before the object vanishes into a hand are a section of it. The section is
//! continued towards the middle of the hand around it, through cells that no camera saw to be
//! empty: like a rope's end in a fist. The part on the other side meets it halfway.

use bendtwin_core::{CancelToken, Point};
use bendtwin_near::PointTree;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::volume::Volume;
use crate::{Error, error::check, rigid::vector};

/// Hand points this near to a section are those that hold it [m].
const HOLDS_M: f64 = 0.04;
/// Least cells of a section.
const LEAST_CELLS: usize = 4;
/// Most sections, the largest: a few hands hold with two each.
const MOST_SECTIONS: usize = 8;
/// Most steps of the way back from a hidden cell: those of a metre in cells of a few millimetres.
const MOST_STEPS: usize = 400;

/// Makes hidden cells solid where a hand holds the object; returns how many those are.
pub(super) fn fill(
    volume: &Volume,
    solid: &mut [bool],
    hidden: &[bool],
    hands: &[Point],
    cancel: &CancelToken,
) -> Result<usize, Error> {
    let unseen: Vec<usize> = (0..hidden.len()).filter(|i| hidden[*i]).collect();
    let mut filled = Vec::new();
    for section in sections(volume, solid, hidden) {
        check(cancel)?;
        let centres: Vec<Point> = section.iter().map(|i| volume.centre(*i)).collect();
        let near = PointTree::new(centres.iter().copied());
        let holding: Vec<Point> =
            hands.iter().copied().filter(|p| near.any_within(*p, HOLDS_M)).collect();
        if holding.is_empty() {
            continue;
        }
        let way = middle(&holding) - middle(&centres);
        let steps = ((2.0 * way.norm() / volume.cell_m).ceil() as usize).min(MOST_STEPS);
        let mut is_section = vec![false; solid.len()];
        section.iter().for_each(|i| is_section[*i] = true);
        // True if the way back from a cell, through hidden ones, ends in the section.
        let continues = |cell: &usize| {
            let from = vector(volume.centre(*cell));
            for step in 1..=steps {
                let at = from - way * (step as f64 / steps as f64);
                match volume.cell([at.x as f32, at.y as f32, at.z as f32]) {
                    Some(at) if is_section[at] => return true,
                    Some(at) if hidden[at] => {}
                    _ => return false,
                }
            }
            false
        };
        filled.par_extend(unseen.par_iter().copied().filter(continues));
    }
    filled.sort_unstable();
    filled.dedup();
    filled.iter().for_each(|i| solid[*i] = true);
    Ok(filled.len())
}

/// Solid cells beside hidden ones, by parts that hang together; the largest first.
fn sections(volume: &Volume, solid: &[bool], hidden: &[bool]) -> Vec<Vec<usize>> {
    let is_rim = |i: usize| solid[i] && volume.around_cell(i).iter().any(|(j, _)| hidden[*j]);
    let rim: Vec<bool> = (0..solid.len()).map(is_rim).collect();
    let mut open = rim.clone();
    let mut sections = Vec::new();
    for seed in 0..rim.len() {
        if !std::mem::take(&mut open[seed]) {
            continue;
        }
        let mut section = vec![seed];
        let mut next = 0;
        while let Some(&cell) = section.get(next) {
            next += 1;
            for (other, _) in volume.around_cell(cell) {
                if std::mem::take(&mut open[other]) {
                    section.push(other);
                }
            }
        }
        if section.len() >= LEAST_CELLS {
            sections.push(section);
        }
    }
    sections.sort_by_key(|s| (std::cmp::Reverse(s.len()), s[0]));
    sections.truncate(MOST_SECTIONS);
    sections
}

fn middle(points: &[Point]) -> Vector3<f64> {
    points.iter().map(|p| vector(*p)).sum::<Vector3<f64>>() / points.len().max(1) as f64
}

#[cfg(test)]
mod tests;

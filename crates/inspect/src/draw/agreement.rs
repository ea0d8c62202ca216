//! Where a camera agrees with the others: its surface, coloured by how far the others see it elsewhere.

use bendtwin_picture::Error;

use super::{
    Plate, Plates,
    coverage::{faded, framed, photograph},
};
use crate::{
    gallery::{Gallery, Wall},
    statistics::median,
    vector::{dot, pixel_of, scaled, sub, to_camera, to_world, turn, unit},
    watch::sketch::{Label, Sketch},
};

/// The colours end at so much [m].
const FULL_M: f64 = 0.01;
/// Differences beyond this are something else, not disagreement [m].
const FAR_M: f64 = 0.05;
/// What another camera sees so much nearer hides the spot from it [m].
const HIDDEN_M: f64 = -0.015;
const FACING: f64 = 0.35;
const MOST: usize = 6;

/// A picture for each camera that has something in common with another.
pub(crate) fn agreement(gallery: &Gallery) -> Plates {
    let cameras = 0..gallery.walls.len().min(MOST);
    cameras.filter_map(|index| one(gallery, index).transpose()).collect()
}

fn one(gallery: &Gallery, index: usize) -> Result<Option<Plate>, Error> {
    let Some(wall) = gallery.walls.get(index) else { return Ok(None) };
    let shared = |sketch: &&Sketch| {
        let has = |w: &Wall| w.sketches.iter().any(|s| s.frame == sketch.frame);
        gallery.walls.iter().enumerate().any(|(i, w)| i != index && has(w))
    };
    let Some(sketch) = wall.sketches.iter().find(shared) else { return Ok(None) };
    let differences: Vec<Option<f64>> =
        (0..sketch.labels.len()).map(|cell| difference(gallery, index, sketch, cell)).collect();
    let known: Vec<f64> = differences.iter().flatten().copied().collect();
    if known.is_empty() {
        return Ok(None);
    }
    let picture = photograph(sketch, |cell, color| {
        match (sketch.labels.get(cell), differences.get(cell).copied().flatten()) {
            (Some(Label::Nothing) | None, _) => faded(color, 0.12),
            (_, Some(difference)) => heat(difference / FULL_M),
            (_, None) => faded(color, 0.35),
        }
    });
    let Some(picture) = picture else { return Ok(None) };
    let caption = format!(
        "Camera {index} ({}), frame {}: green where another camera measures the same surface, red where the other \
         measures it {:.0} mm farther away, blue where nearer; typically {:.1} mm. Grey: seen by this camera alone.",
        wall.camera.name,
        sketch.frame,
        1e3 * FULL_M,
        1e3 * median(known.iter().map(|d| d.abs())).unwrap_or(0.0)
    );
    Ok(Some(Plate { png: framed(&picture)?, caption }))
}

/// How much farther than this camera the others see the surface of a cell [m].
fn difference(gallery: &Gallery, index: usize, sketch: &Sketch, cell: usize) -> Option<f64> {
    let camera = &gallery.walls.get(index)?.camera;
    let at = sketch.place(camera, cell)?;
    let normal = sketch.normal(camera, cell)?;
    let pose = camera.pose(sketch.frame);
    let (place, normal) = (to_world(pose, at), turn(&pose.rotation, normal));
    let faces = |eye| unit(sub(eye, place)).is_some_and(|to| dot(normal, to) > FACING);
    if !faces(pose.translation) {
        return None;
    }
    let others = gallery.walls.iter().enumerate().filter(|(i, _)| *i != index);
    let seen = others.filter_map(|(_, wall)| {
        let other = wall.sketches.iter().find(|s| s.frame == sketch.frame)?;
        let stand = wall.camera.pose(sketch.frame);
        if !faces(stand.translation) {
            return None;
        }
        let there = to_camera(stand, place);
        let (_, depth) = other.surface(other.cell(pixel_of(&wall.camera, there)?)?)?;
        // Along the other's view, seen across the surface.
        let ray = scaled(there, 1.0 / there[2]);
        let slant = unit(turn(&stand.rotation, ray)).map_or(1.0, |ray| dot(ray, normal).abs());
        Some((depth - there[2]) * slant).filter(|d| (HIDDEN_M..FAR_M).contains(d))
    });
    median(seen)
}

/// Blue over green to red, for -1 to 1.
fn heat(value: f64) -> [u8; 3] {
    const BLUE: [f64; 3] = [40.0, 90.0, 235.0];
    const GREEN: [f64; 3] = [62.0, 190.0, 120.0];
    const RED: [f64; 3] = [235.0, 60.0, 50.0];
    let share = value.clamp(-1.0, 1.0);
    let end = if share < 0.0 { BLUE } else { RED };
    std::array::from_fn(|a| (GREEN[a] + (end[a] - GREEN[a]) * share.abs()) as u8)
}

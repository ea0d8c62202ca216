//! Pictures of agreement: each camera's surface, coloured by its distance from the surfaces that
//! the others measured.

use bendtwin_picture::Error;

use super::{
    Figure, Figures,
    coverage::{faded, framed, photograph},
};
use crate::{
    picture_inputs::{CameraPictures, PictureInputs},
    scan::crop::{Crop, Label},
    statistics::median,
    vector::{dot, pixel_of, scaled, sub, to_camera, to_world, turn, unit},
};

/// Distance at which the colours end [m].
const COLOR_RANGE_M: f64 = 0.01;
/// Larger differences are between different surfaces, not disagreement [m].
const MAX_DIFFERENCE_M: f64 = 0.05;
/// A surface that another camera sees nearer by more than this hides the spot from it [m].
const OCCLUSION_M: f64 = -0.015;
/// Least cosine between a normal and the direction to a camera that faces it.
const MIN_FACING_COSINE: f64 = 0.35;
/// Cameras that are shown.
const MAX_CAMERAS: usize = 6;

/// A picture for each camera that has something in common with another.
pub(crate) fn agreement(inputs: &PictureInputs) -> Figures {
    let cameras = 0..inputs.cameras.len().min(MAX_CAMERAS);
    cameras.filter_map(|index| one(inputs, index).transpose()).collect()
}

fn one(inputs: &PictureInputs, index: usize) -> Result<Option<Figure>, Error> {
    let Some(pictures) = inputs.cameras.get(index) else { return Ok(None) };
    let shared = |crop: &&Crop| {
        let has = |other: &CameraPictures| other.crops.iter().any(|s| s.frame == crop.frame);
        inputs.cameras.iter().enumerate().any(|(i, other)| i != index && has(other))
    };
    let Some(crop) = pictures.crops.iter().find(shared) else { return Ok(None) };
    let differences: Vec<Option<f64>> =
        (0..crop.labels.len()).map(|cell| difference(inputs, index, crop, cell)).collect();
    let known: Vec<f64> = differences.iter().flatten().copied().collect();
    if known.is_empty() {
        return Ok(None);
    }
    let picture = photograph(crop, |cell, color| {
        match (crop.labels.get(cell), differences.get(cell).copied().flatten()) {
            (Some(Label::Nothing) | None, _) => faded(color, 0.12),
            (_, Some(difference)) => heat(difference / COLOR_RANGE_M),
            (_, None) => faded(color, 0.35),
        }
    });
    let Some(picture) = picture else { return Ok(None) };
    let caption = format!(
        "Camera {index} ({}), frame {}: green where another camera measures the same surface, red where the other \
         measures it {:.0} mm farther away, blue where nearer; typically {:.1} mm. Grey: seen by this camera alone.",
        pictures.camera.name,
        crop.frame,
        1e3 * COLOR_RANGE_M,
        1e3 * median(known.iter().map(|d| d.abs())).unwrap_or(0.0)
    );
    Ok(Some(Figure { png: framed(&picture)?, caption }))
}

/// Distance by which the others see the surface of a cell farther away than this camera [m].
fn difference(inputs: &PictureInputs, index: usize, crop: &Crop, cell: usize) -> Option<f64> {
    let camera = &inputs.cameras.get(index)?.camera;
    let at = crop.place(camera, cell)?;
    let normal = crop.normal(camera, cell)?;
    let pose = camera.pose(crop.frame);
    let (place, normal) = (to_world(pose, at), turn(&pose.rotation, normal));
    let faces = |eye| unit(sub(eye, place)).is_some_and(|to| dot(normal, to) > MIN_FACING_COSINE);
    if !faces(pose.translation) {
        return None;
    }
    let others = inputs.cameras.iter().enumerate().filter(|(i, _)| *i != index);
    let seen = others.filter_map(|(_, pictures)| {
        let other = pictures.crops.iter().find(|s| s.frame == crop.frame)?;
        let other_pose = pictures.camera.pose(crop.frame);
        if !faces(other_pose.translation) {
            return None;
        }
        let there = to_camera(other_pose, place);
        let (_, depth) = other.surface(other.cell(pixel_of(&pictures.camera, there)?)?)?;
        // Along the other's view, seen across the surface.
        let ray = scaled(there, 1.0 / there[2]);
        let slant = unit(turn(&other_pose.rotation, ray)).map_or(1.0, |ray| dot(ray, normal).abs());
        Some((depth - there[2]) * slant).filter(|d| (OCCLUSION_M..MAX_DIFFERENCE_M).contains(d))
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

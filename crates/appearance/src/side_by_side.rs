//! A video of one camera: what it recorded, what was predicted, and the difference of both as the
//! measures see it.

mod layout;

use std::io::Write;

use bendtwin_core::{View, views::Label};
use bendtwin_picture::{Animation, Photograph};
use bendtwin_splat::{Image, Rasteriser};

use self::layout::Layout;
use crate::{
    Error, Scene, camera,
    score::around,
    target::{Rectangle, Target},
};

/// Colour of unknown pixels: beyond the view, and behind the object.
const UNKNOWN: [u8; 3] = [28, 28, 32];
/// Colour of hands among differences, which are not compared there.
const NOT_COMPARED: [u8; 3] = [70, 70, 78];
/// Brightness of the recorded surroundings around a prediction.
const DIMMED: f32 = 0.4;

/// Writes the frames of a camera, counted from 0, that have a view and a prediction, as an animated
/// PNG. Returns false without such frames, or if `keep_going`, which is asked before each frame, returns
/// false.
///
/// # Errors
/// If the rasteriser or writing fails.
pub fn side_by_side(
    scene: &Scene<'_>,
    camera: usize,
    fps: f64,
    rasteriser: &mut dyn Rasteriser,
    out: &mut dyn Write,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<bool, Error> {
    let Some(camera) = scene.views.cameras.get(camera) else { return Ok(false) };
    let predicted = |view: &&View| scene.motion.at(view.frame as usize).is_some();
    let shown: Vec<&View> = camera.views.iter().filter(predicted).collect();
    let gaussians = |view: &View| {
        // Views without a prediction are not shown.
        scene.dressed.at(scene.motion.at(view.frame as usize).unwrap_or_default())
    };
    let mut area: Option<Rectangle> = None;
    for view in &shown {
        let own = around(&gaussians(view)?, &camera::whole(camera, view.frame), view);
        area = Some(area.map_or(own, |area| area.union(own)));
    }
    let Some(area) = area else { return Ok(false) };
    let layout = Layout::new(area.size);
    let frame_count = u32::try_from(shown.len()).unwrap_or(u32::MAX);
    let mut video = Animation::new(out, layout.size(), frame_count, fps)?;
    let last = scene.motion.frames().end.saturating_sub(1);
    for (index, view) in shown.iter().enumerate() {
        if !keep_going() {
            return Ok(false);
        }
        let whole = camera::whole(camera, view.frame);
        let crop = whole.crop(area.corner[0], area.corner[1], area.size[0], area.size[1]);
        let image = rasteriser.render(&gaussians(view)?, &crop)?;
        let target = Target::new(view, area);
        let panels =
            [recorded(view, area), prediction(&image, view, area), difference(&image, &target)];
        let [columns, rows] = area.size.map(|n| n as usize);
        let panels = panels.map(|pixels| Photograph::new(columns, rows, pixels));
        let span = match (view.frame as usize) < scene.motion.train_frame_count {
            true => "training",
            false => "future",
        };
        let text = format!("{}  frame {} of {last}, {span}", camera.name, view.frame);
        let next = shown.get(index + 1).map_or(1, |next| next.frame - view.frame);
        video.push(&layout.draw(&panels, &text)?, next)?;
    }
    video.finish()?;
    Ok(true)
}

/// Pixels of an area by what the view has there, if it reaches that far.
fn pixels(
    view: &View,
    area: Rectangle,
    color: impl Fn(usize, Option<usize>) -> [u8; 3],
) -> Vec<[u8; 3]> {
    area.in_view(view).enumerate().map(|(pixel, index)| color(pixel, index)).collect()
}

fn recorded(view: &View, area: Rectangle) -> Vec<[u8; 3]> {
    pixels(view, area, |_, index| index.map_or(UNKNOWN, |i| view.colors[i]))
}

/// The rendering in the dimmed surroundings of the recording, behind its hands.
fn prediction(image: &Image, view: &View, area: Rectangle) -> Vec<[u8; 3]> {
    pixels(view, area, |pixel, index| {
        let label = index.map(|i| view.labels[i]);
        let known = index.filter(|_| label != Some(Label::Object));
        let around =
            known.map_or(UNKNOWN.map(f32::from), |i| view.colors[i].map(|c| DIMMED * f32::from(c)));
        // A hand may hide the object.
        let (color, alpha) = match label {
            Some(Label::Hand) => ([0.0; 3], 0.0),
            _ => (image.color[pixel], image.alpha[pixel]),
        };
        std::array::from_fn(|k| byte(255.0 * color[k] + (1.0 - alpha) * around[k]))
    })
}

/// Absolute difference of the colours over black.
fn difference(image: &Image, target: &Target) -> Vec<[u8; 3]> {
    let colors = image.color.iter().zip(&target.colors).zip(&target.valid);
    colors
        .map(|((drawn, seen), valid)| match valid {
            true => std::array::from_fn(|k| byte(255.0 * (drawn[k] - seen[k]).abs())),
            false => NOT_COMPARED,
        })
        .collect()
}

fn byte(value: f32) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests;

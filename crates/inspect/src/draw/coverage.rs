//! Pictures of depth coverage: where a camera has depth on the object and where it has none.

use bendtwin_picture::{Canvas, Color, Error, Photograph, Rect};

use super::{Figure, Figures, HOLE, enlargement};
use crate::{
    picture_inputs::{CameraPictures, PictureInputs},
    scan::crop::{Crop, Label},
};

/// Width of a picture [px].
const WIDTH: f32 = 340.0;
/// Cameras that are shown.
const MAX_CAMERAS: usize = 6;

/// A picture for each camera, of the frame with the most holes.
pub(crate) fn coverage(inputs: &PictureInputs) -> Figures {
    inputs
        .cameras
        .iter()
        .enumerate()
        .take(MAX_CAMERAS)
        .filter_map(|(i, w)| one(i, w).transpose())
        .collect()
}

fn one(index: usize, pictures: &CameraPictures) -> Result<Option<Figure>, Error> {
    let share = |crop: &Crop| {
        let labels = crop.labels.iter().zip(&crop.depth);
        let object = labels.filter(|(l, _)| **l == Label::Object);
        let (all, holes) =
            object.fold((0, 0), |(all, holes), (_, d)| (all + 1, holes + usize::from(*d <= 0.0)));
        crate::statistics::share(holes, all)
    };
    let Some(worst) = pictures.crops.iter().max_by(|a, b| share(a).total_cmp(&share(b))) else {
        return Ok(None);
    };
    let Some(photograph) = photograph(worst, |cell, color| {
        let has_depth = worst.depth.get(cell).is_some_and(|d| *d > 0.0);
        match worst.labels.get(cell) {
            Some(Label::Nothing) | None => faded(color, 0.3),
            Some(_) if !has_depth => [HOLE.0, HOLE.1, HOLE.2],
            Some(Label::Object) => color,
            Some(Label::Manipulator) => faded(color, 0.6),
        }
    }) else {
        return Ok(None);
    };
    let caption = format!(
        "Camera {index} ({}), frame {}: {:.1} % of the object without depth (pink).",
        pictures.camera.name,
        worst.frame,
        100.0 * share(worst)
    );
    Ok(Some(Figure { png: framed(&photograph)?, caption }))
}

/// The cells of a sketch as pixels.
pub(super) fn photograph(
    crop: &Crop,
    shade: impl Fn(usize, [u8; 3]) -> [u8; 3],
) -> Option<Photograph> {
    let pixels = crop.color.iter().enumerate().map(|(cell, color)| shade(cell, *color));
    Photograph::new(crop.width, crop.height, pixels.collect())
}

/// A colour faded towards grey, for what a picture is not about.
pub(super) fn faded(color: [u8; 3], keep: f32) -> [u8; 3] {
    color.map(|c| (keep * f32::from(c) + (1.0 - keep) * 150.0) as u8)
}

/// A photograph alone on a canvas, enlarged, as PNG.
pub(super) fn framed(photograph: &Photograph) -> Result<Vec<u8>, Error> {
    let scale = enlargement(photograph.width().max(photograph.height()), WIDTH);
    let (width, height) =
        ((scale * photograph.width() as f32).floor(), (scale * photograph.height() as f32).floor());
    let mut canvas = Canvas::new(width.max(1.0), height.max(1.0), Color(150, 150, 150))?;
    canvas.photograph(Rect { x: 0.0, y: 0.0, width, height }, photograph);
    canvas.to_png()
}

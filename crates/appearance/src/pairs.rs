//! The images that the measures compare, drawn side by side for measures that are not built in.

use bendtwin_picture::{Canvas, Color, Photograph, Rect};
use bendtwin_splat::Rasteriser;

use crate::{
    Error, Scene, camera,
    target::{Rectangle, Target},
};

/// A recorded image on the left and its rendering on the right, each as large as the camera's images,
/// over black and without hands.
#[derive(Debug)]
pub struct ComparedPair {
    /// Camera, counted from 0.
    pub camera: usize,
    /// Frame of the recording.
    pub frame: u32,
    /// True for a frame that the fit saw.
    pub is_training: bool,
    /// Both images.
    pub canvas: Canvas,
}

/// Hands every pair of a scene to `emit`, until that returns false.
///
/// # Errors
/// If the rasteriser or `emit` fails, or if an image has another size than its camera.
pub fn compared_pairs(
    scene: &Scene<'_>,
    rasteriser: &mut dyn Rasteriser,
    emit: &mut dyn FnMut(ComparedPair) -> Result<bool, Error>,
) -> Result<(), Error> {
    for (index, camera) in scene.views.cameras.iter().enumerate() {
        let [columns, rows] = camera.size;
        let area = Rectangle { corner: [0; 2], size: camera.size };
        for view in &camera.views {
            let Some(nodes) = scene.motion.at(view.frame as usize) else { continue };
            let whole = camera::whole(camera, view.frame);
            let image = rasteriser.render(&scene.dressed.at(nodes)?, &whole)?;
            let target = Target::new(view, area);
            let (width, height) = (columns as f32, rows as f32);
            let mut canvas = Canvas::new(2.0 * width, height, Color(0, 0, 0))?;
            for (x, colors) in [(0.0, &target.colors), (width, &image.color)] {
                let shown = colors.iter().zip(&target.valid);
                let bytes = |(color, valid): (&[f32; 3], &bool)| match valid {
                    true => color.map(|c| (255.0 * c).round().clamp(0.0, 255.0) as u8),
                    false => [0; 3],
                };
                let pixels = shown.map(bytes).collect();
                let image = Photograph::new(columns as usize, rows as usize, pixels);
                let other_size =
                    || Error::Compare("an image has another size than its camera".into());
                let image = image.ok_or_else(other_size)?;
                canvas.photograph(Rect { x, y: 0.0, width, height }, &image);
            }
            let is_training = (view.frame as usize) < scene.motion.train_frame_count;
            let pair = ComparedPair { camera: index, frame: view.frame, is_training, canvas };
            if !emit(pair)? {
                return Ok(());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;

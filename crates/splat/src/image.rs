//! Renderings, and derivatives of a loss by them.

use crate::{Camera, Error, scan::first_wrong};

/// A rendering over black. Arrays are row-major, shape [height, width].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Columns [px].
    pub width: u32,
    /// Rows [px].
    pub height: u32,
    /// Colours: the sum of colours of Gaussians by their weights.
    pub color: Vec<[f32; 3]>,
    /// Coverage, 0..1: the sum of weights.
    pub alpha: Vec<f32>,
    /// Sum of depths of Gaussians by their weights [m]; divided by `alpha` it is a depth.
    pub depth_m: Vec<f32>,
}

/// d loss / d image. Arrays are row-major, shape [height, width].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageBar {
    /// Gradient by colours.
    pub color: Vec<[f32; 3]>,
    /// Gradient by coverage.
    pub alpha: Vec<f32>,
    /// Gradient by the sum of weighted depths [1/m].
    pub depth_m: Vec<f32>,
}

impl Image {
    /// An image with nothing in it.
    pub fn black(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            color: vec![[0.0; 3]; pixels],
            alpha: vec![0.0; pixels],
            depth_m: vec![0.0; pixels],
        }
    }
}

impl ImageBar {
    /// Zeros for `pixels` pixels.
    pub fn zeros(pixels: usize) -> Self {
        Self { color: vec![[0.0; 3]; pixels], alpha: vec![0.0; pixels], depth_m: vec![0.0; pixels] }
    }

    /// Checks that there is one finite number for each of a camera's pixels.
    ///
    /// # Errors
    /// The first array or number that is wrong.
    pub fn check(&self, camera: &Camera) -> Result<(), Error> {
        let expected = camera.pixel_count();
        let lengths = [
            ("derivatives by colour", self.color.len()),
            ("derivatives by alpha", self.alpha.len()),
            ("derivatives by depth", self.depth_m.len()),
        ];
        if let Some((what, got)) = lengths.into_iter().find(|(_, got)| *got != expected) {
            return Err(Error::Lengths { expected, of: "pixels", got, what });
        }
        let fail = |what, pixel, value| Err(Error::Bar { what, pixel, value });
        let colors = self.color.as_flattened();
        if let Some(i) = first_wrong(colors, f32::is_finite) {
            return fail("colour", i / 3, colors[i]);
        }
        for (what, values) in [("alpha", &self.alpha), ("depth", &self.depth_m)] {
            if let Some(i) = first_wrong(values, f32::is_finite) {
                return fail(what, i, values[i]);
            }
        }
        Ok(())
    }
}

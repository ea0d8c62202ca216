//! The interface of rasterisers.

use std::sync::Arc;

use crate::{Camera, Error, Gaussians, GaussiansBar, Image, ImageBar};

/// Draws Gaussians, and passes derivatives of a loss by the image back to them.
///
/// Each Gaussian is projected along the linear part of the projection at its mean (EWA, Zwicker et
/// al. 2001), widened by [`crate::constants::BLUR_PX2`] with its opacity lowered as its area grows
/// (Yu et al. 2024, "Mip-Splatting"), and composited front to back by the depth of its mean, ties
/// by index: alpha_i = min([`crate::constants::MOST_ALPHA`], o_i exp(-d^T S_i^-1 d / 2)), left out
/// below [`crate::constants::LEAST_ALPHA`]; weight w_i = alpha_i T_i with the transmittance T_i =
/// Π_{j < i} (1 - alpha_j), ended where it would fall below
/// [`crate::constants::LEAST_TRANSMITTANCE`].
///
/// The same input gives the same bits on the same build and device.
pub trait Rasteriser: Send {
    /// The image that a camera takes of Gaussians.
    ///
    /// # Errors
    /// [`Error::Gaussian`], [`Error::Camera`] and similar for wrong input, [`Error::TooMany`] where
    /// memory would not suffice, [`Error::Device`] if a device fails.
    fn render(&mut self, gaussians: &Gaussians, camera: &Camera) -> Result<Image, Error>;

    /// d loss / d Gaussians, from d loss / d image. After a rendering of the same Gaussians by the
    /// same camera it costs less.
    ///
    /// # Errors
    /// Those of [`Rasteriser::render`].
    fn gradients(
        &mut self,
        gaussians: &Gaussians,
        camera: &Camera,
        bar: &ImageBar,
    ) -> Result<GaussiansBar, Error>;

    /// Name for logs and reports.
    fn name(&self) -> String;
}

/// Opens a rasteriser, or says why it cannot be.
pub type OpenRasteriser = Arc<dyn Fn() -> Result<Box<dyn Rasteriser>, String> + Send + Sync>;

/// Checks what every rasteriser is given.
///
/// # Errors
/// The first number that is wrong.
pub fn check_input(
    gaussians: &Gaussians,
    camera: &Camera,
    bar: Option<&ImageBar>,
) -> Result<(), Error> {
    camera.check()?;
    gaussians.check()?;
    bar.map_or(Ok(()), |bar| bar.check(camera))
}

//! Differences between a rendered image and a recorded one.
//!
//! A [`Pair`] holds two images of one size and says which pixels count. Pixels that do not count
//! are black in both, and every mean runs over all pixels of the images: that is how PhysTwin
//! scores its renderings, whose background and hands are black. Such a mean depends on the share
//! of black, so images are compared in one size; [`Whole`] gives the scores that crops would have
//! in the images that they were cut from.
//!
//! Colours are sRGB, 0 to 1, as files store them; none of the measures but FLIP makes them linear.
//! This crate knows neither cameras nor files of images.

mod error;
mod filter;
mod flip;
mod image;
mod iou;
mod planes;
mod psnr;
mod ssim;
#[cfg(test)]
mod test_images;
mod whole;

pub use error::Error;
pub use flip::{PIXELS_PER_DEGREE, flip, linear};
pub use image::{Image, Pair};
pub use iou::iou;
pub use psnr::{mean_squared_error, psnr};
pub use ssim::{Reference, ssim, ssim_with_gradient};
pub use whole::Whole;

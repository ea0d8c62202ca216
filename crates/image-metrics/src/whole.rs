//! Scores of crops in the images that they were cut from.

use crate::Error;

/// Crop of a larger image that is black, in the rendering as in the recording, outside the crop.
///
/// Means over all pixels then follow from the crop: nothing differs outside. For SSIM and FLIP,
/// whose windows reach over the border, that is exact if the outermost 5 and 10 pixels of the crop
/// are black in both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    share: f64,
}

impl Whole {
    /// Crop of an image, by their numbers of pixels.
    ///
    /// # Errors
    /// A crop without pixels or larger than the image.
    pub fn new(crop_pixels: usize, image_pixels: usize) -> Result<Self, Error> {
        if crop_pixels == 0 || crop_pixels > image_pixels {
            return Err(Error::Whole { crop: crop_pixels, whole: image_pixels });
        }
        Ok(Self { share: crop_pixels as f64 / image_pixels as f64 })
    }

    /// PSNR of the image [dB] from that of the crop.
    pub fn psnr(&self, crop_psnr: f64) -> f64 {
        crop_psnr - 10.0 * self.share.log10()
    }

    /// SSIM of the image from that of the crop.
    pub fn ssim(&self, crop_ssim: f64) -> f64 {
        1.0 - self.share * (1.0 - crop_ssim)
    }

    /// FLIP of the image from that of the crop.
    pub fn flip(&self, crop_flip: f64) -> f64 {
        self.share * crop_flip
    }
}

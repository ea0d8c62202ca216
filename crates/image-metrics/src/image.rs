//! Views of images, and pairs of them to compare.

use crate::Error;

/// View of an image.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    width: usize,
    height: usize,
    pixels: &'a [[f32; 3]],
}

impl<'a> Image<'a> {
    /// Image of pixels in sRGB, 0 to 1, shape [height, width, 3].
    ///
    /// # Errors
    /// No pixels, another number of pixels than the size says, a colour that is not finite.
    pub fn new(width: u32, height: u32, pixels: &'a [[f32; 3]]) -> Result<Self, Error> {
        if width == 0 || height == 0 {
            return Err(Error::Empty { width, height });
        }
        length("colours", pixels.len(), width, height)?;
        if let Some(pixel) = pixels.iter().position(|c| !c.iter().all(|v| v.is_finite())) {
            return Err(Error::NotFinite { pixel });
        }
        Ok(Self { width: width as usize, height: height as usize, pixels })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Colours in sRGB, shape [height, width, 3].
    pub fn pixels(&self) -> &'a [[f32; 3]] {
        self.pixels
    }

    fn size(&self) -> [u32; 2] {
        // Both were u32.
        [self.width as u32, self.height as u32]
    }
}

/// Two images of one size, and the pixels that count.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    image: Image<'a>,
    reference: Image<'a>,
    valid: Option<&'a [bool]>,
}

impl<'a> Pair<'a> {
    /// An image, the reference that it is compared with, and the valid pixels, shape
    /// [height, width]; all are valid without.
    ///
    /// # Errors
    /// Images of two sizes, a mask of another size.
    pub fn new(
        image: Image<'a>,
        reference: Image<'a>,
        valid: Option<&'a [bool]>,
    ) -> Result<Self, Error> {
        if image.size() != reference.size() {
            return Err(Error::Sizes { a: image.size(), b: reference.size() });
        }
        if let Some(valid) = valid {
            let [width, height] = image.size();
            length("valid pixels", valid.len(), width, height)?;
        }
        Ok(Self { image, reference, valid })
    }

    /// The image.
    pub fn image(&self) -> Image<'a> {
        self.image
    }

    /// The image that it is compared with.
    pub fn reference(&self) -> Image<'a> {
        self.reference
    }

    /// Number of pixels, valid or not.
    pub fn pixel_count(&self) -> usize {
        self.image.pixels.len()
    }

    /// The valid pixels, shape [height, width]; none if all are.
    pub fn valid(&self) -> Option<&'a [bool]> {
        self.valid
    }

    /// True for a pixel that counts.
    pub(crate) fn is_valid(&self, pixel: usize) -> bool {
        self.valid.is_none_or(|valid| valid[pixel])
    }
}

fn length(what: &'static str, found: usize, width: u32, height: u32) -> Result<(), Error> {
    if found as u64 == u64::from(width) * u64::from(height) {
        Ok(())
    } else {
        Err(Error::Length { what, found, width, height })
    }
}

#[cfg(test)]
mod tests;

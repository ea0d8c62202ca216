//! Moving pictures as animated PNG, written frame by frame: without loss, in every colour, and played
//! by browsers, which take no video that can be encoded without C libraries or minutes of work.

use std::io::Write;

use crate::{Canvas, Error};

/// Parts of a frame and of a second in which delays are given.
const PARTS: f64 = 100.0;

/// A picture of several canvases of one size, which is played again and again.
pub struct Animation<W: Write> {
    writer: png::Writer<W>,
    size: [u32; 2],
    fps: f64,
}

impl<W: Write> Animation<W> {
    /// An animation of `frame_count` canvases of the given size.
    ///
    /// # Errors
    /// If there are no frames, or writing fails.
    pub fn new(out: W, size: [u32; 2], frame_count: u32, fps: f64) -> Result<Self, Error> {
        let mut encoder = png::Encoder::new(out, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(frame_count, 0).map_err(failed)?;
        encoder.validate_sequence(true);
        Ok(Self { writer: encoder.write_header().map_err(failed)?, size, fps })
    }

    /// Adds a canvas, which is shown for `frames` frames of the frame rate.
    ///
    /// # Errors
    /// If it has another size, there are more than announced, or writing fails.
    pub fn push(&mut self, canvas: &Canvas, frames: u32) -> Result<(), Error> {
        if canvas.size() != self.size {
            let [width, height] = canvas.size().map(|n| n as f32);
            return Err(Error::Size { width, height });
        }
        let parts = |value: f64| (PARTS * value).round().clamp(1.0, f64::from(u16::MAX)) as u16;
        let delay = (parts(f64::from(frames)), parts(self.fps));
        self.writer.set_frame_delay(delay.0, delay.1).map_err(failed)?;
        self.writer.write_image_data(&canvas.rgb()).map_err(failed)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If frames are missing, or writing fails.
    pub fn finish(self) -> Result<(), Error> {
        self.writer.finish().map_err(failed)
    }
}

fn failed(error: png::EncodingError) -> Error {
    match error {
        png::EncodingError::IoError(error) => Error::Write(error.to_string()),
        other => Error::Encoding(other.to_string()),
    }
}

#[cfg(test)]
mod tests;

//! Corners of chessboards in an image, to a few hundredths of a pixel: `chess-corners` (Bennett and
//! Lasenby, *ChESS*, 2014; saddle points refined on the image).

use bendtwin_capture::raw::ColorImage;
use chess_corners::{Detector, DetectorConfig, ImageRefiner, UpscaleConfig};

use crate::Error;

/// Images with fewer pixels are enlarged: small squares are found, and places are half as far off
/// (0.034 px instead of 0.13 px at squares of 20 pixels).
const ENLARGED_PIXELS: usize = 1_600_000;
/// Most corners that are looked at; a board has hundreds.
const MOST: usize = 6_000;

/// Brightness of an image.
#[derive(Clone, Debug)]
pub(crate) struct Gray {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<u8>,
}

/// A point where two dark and two light sectors meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Saddle {
    /// Column and row [px].
    pub(crate) at: [f64; 2],
    /// Angles of the four edges in ascending order, a turn from the first to itself; the sector after
    /// the first is dark, that after the second light, and so on.
    pub(crate) edges: [f64; 4],
}

impl Gray {
    pub(crate) fn of(image: &ColorImage) -> Self {
        let gray = |[r, g, b]: &[u8; 3]| {
            ((u32::from(*r) * 299 + u32::from(*g) * 587 + u32::from(*b) * 114 + 500) / 1000) as u8
        };
        Self {
            width: image.width,
            height: image.height,
            pixels: image.pixels.iter().map(gray).collect(),
        }
    }

    /// The image as a mirror shows it.
    pub(crate) fn mirrored(&self) -> Self {
        let rows = self.pixels.chunks_exact(self.width.max(1));
        Self { pixels: rows.flat_map(|row| row.iter().rev().copied()).collect(), ..*self }
    }

    /// Brightness between pixels; `None` outside.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let inside = |v: f64, size: usize| v >= 0.0 && v <= size as f64 - 1.0;
        if !inside(x, self.width) || !inside(y, self.height) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, below) = ((column + 1).min(self.width - 1), (row + 1).min(self.height - 1));
        let pixel = |column: usize, row: usize| f64::from(self.pixels[row * self.width + column]);
        let (fx, fy) = (x - column as f64, y - row as f64);
        let upper = pixel(column, row) * (1.0 - fx) + pixel(right, row) * fx;
        let lower = pixel(column, below) * (1.0 - fx) + pixel(right, below) * fx;
        Some(upper * (1.0 - fy) + lower * fy)
    }
}

/// The saddle points of an image.
pub(crate) fn saddles(image: &Gray) -> Result<Vec<Saddle>, Error> {
    let failed = |error: chess_corners::ChessError| Error::Detector(error.to_string());
    let mut config = DetectorConfig::chess().with_refiner(ImageRefiner::saddle_point());
    if image.pixels.len() < ENLARGED_PIXELS {
        config = config.with_upscale(UpscaleConfig::Fixed(2));
    }
    let mut detector = Detector::new(config).map_err(failed)?;
    let size = [image.width, image.height].map(|n| n as u32);
    let mut found = detector.detect_u8(&image.pixels, size[0], size[1]).map_err(failed)?;
    found.sort_by(|a, b| b.response.total_cmp(&a.response));
    found.truncate(MOST);
    let saddles = found.iter().filter_map(|corner| {
        let [first, second] = corner.axes?.map(|axis| f64::from(axis.angle));
        let half = std::f64::consts::PI;
        let at = [corner.x, corner.y].map(f64::from);
        let edges = [first, second, first + half, second + half];
        edges.iter().chain(&at).all(|x| x.is_finite()).then_some(Saddle { at, edges })
    });
    Ok(saddles.collect())
}

//! The pictures of a report, as PNG files.

mod agreement;
mod coverage;
mod graph;
mod points;

use bendtwin_picture::{Color, Error};

pub(crate) use self::{
    agreement::agreement,
    coverage::coverage,
    graph::graph,
    points::{lifted, seen},
};

/// A picture and its caption.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    pub(crate) png: Vec<u8>,
    pub(crate) caption: String,
}

/// Colours that work on light and dark pages.
pub(crate) const HAND: Color = Color(214, 69, 80);
pub(crate) const ACCENT: Color = Color(0, 134, 149);
pub(crate) const FAINT: Color = Color(128, 136, 146);
/// Colour of pixels without depth.
pub(crate) const HOLE: Color = Color(255, 45, 149);

/// The factor by which an image is enlarged to about the wanted width, so that a page does not have
/// to.
pub(crate) fn enlargement(width: usize, wanted: f32) -> f32 {
    (wanted / width.max(1) as f32).clamp(0.25, 4.0)
}

pub(crate) type Figures = Result<Vec<Figure>, Error>;

//! Places of three panels and of words about them.

use bendtwin_picture::{Align, Canvas, Color, Photograph, Rect};

use crate::Error;

/// Words over the panels.
const TITLES: [&str; 3] = ["recorded", "predicted", "difference"];
const BACKGROUND: Color = Color(16, 16, 18);
const LETTERS: Color = Color(230, 230, 230);
/// Longest side that a panel has, and longest side of one that is enlarged [px].
const MOST_PX: f32 = 480.0;
const SMALL_PX: f32 = 240.0;
/// Height of a line of words, and space between panels [px].
pub(super) const LINE_PX: f32 = 24.0;
pub(super) const GAP_PX: f32 = 8.0;
/// Least width of a panel, so that its title fits [px].
const LEAST_WIDTH_PX: f32 = 110.0;

/// Sizes of a video [px].
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Width and height of a panel.
    pub(super) panel: [f32; 2],
    /// Distance from a panel to the next.
    pub(super) step: f32,
}

impl Layout {
    /// Panels for images of the given size: large images reduced, small ones enlarged by whole
    /// numbers.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let longest = size[0].max(size[1]).max(1) as f32;
        let scale = match longest < SMALL_PX {
            true => (SMALL_PX / longest).floor(),
            false => (MOST_PX / longest).min(1.0),
        };
        let panel = size.map(|n| (scale * n as f32).round().max(1.0));
        Self { panel, step: panel[0].max(LEAST_WIDTH_PX) + GAP_PX }
    }

    /// Columns and rows; even, as encoders of videos want them.
    pub(super) fn size(&self) -> [u32; 2] {
        let [width, height] = [3.0 * self.step + GAP_PX, self.panel[1] + 2.0 * LINE_PX];
        [width, height].map(|n| (n.ceil() as u32).next_multiple_of(2))
    }

    /// Panels, and a line of words below them.
    pub(super) fn draw(
        &self,
        panels: &[Option<Photograph>; 3],
        text: &str,
    ) -> Result<Canvas, Error> {
        let [width, height] = self.size().map(|n| n as f32);
        let mut canvas = Canvas::new(width, height, BACKGROUND)?;
        let word = (LINE_PX - 16.0) / 2.0;
        for (k, (title, panel)) in TITLES.iter().zip(panels).enumerate() {
            let x = GAP_PX + k as f32 * self.step;
            canvas.text(x, word, LETTERS, title, Align::Left);
            let [width, height] = self.panel;
            let area = Rect { x, y: LINE_PX, width, height };
            if let Some(panel) = panel {
                canvas.photograph(area, panel);
            }
        }
        canvas.text(GAP_PX, LINE_PX + self.panel[1] + word, LETTERS, text, Align::Left);
        Ok(canvas)
    }
}

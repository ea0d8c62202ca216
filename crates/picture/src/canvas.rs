//! Drawing: anti-aliased shapes by `tiny-skia`, letters from a pre-rasterised font, PNG by `png`.
//! Pure Rust, no system font needed, so the picture is the same everywhere.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Stroke, Transform,
};

use crate::{Error, Photograph};

/// Red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(
    /// Red.
    pub u8,
    /// Green.
    pub u8,
    /// Blue.
    pub u8,
);

/// A rectangle [px]; y points down.
#[derive(Clone, Copy, Debug)]
pub struct Rect {
    /// Left edge.
    pub x: f32,
    /// Upper edge.
    pub y: f32,
    /// Extent to the right.
    pub width: f32,
    /// Extent downwards.
    pub height: f32,
}

/// The end of a text that lies at its x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Left end.
    Left,
    /// Right end.
    Right,
}

/// The area that drawing is kept to.
#[derive(Clone, Debug)]
pub struct Clip(Mask);

/// An image that is drawn on.
#[derive(Clone, Debug)]
pub struct Canvas {
    pixels: Pixmap,
    is_opaque: bool,
}

/// Heights of letters in texts and in titles.
const TEXT: RasterHeight = RasterHeight::Size16;
const TITLE: RasterHeight = RasterHeight::Size20;

impl Canvas {
    /// An empty canvas of one colour.
    ///
    /// # Errors
    /// If it is empty or too large.
    pub fn new(width: f32, height: f32, background: Color) -> Result<Self, Error> {
        let mut pixels = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
            .ok_or(Error::Size { width, height })?;
        let Color(r, g, b) = background;
        pixels.fill(tiny_skia::Color::from_rgba8(r, g, b, 255));
        Ok(Self { pixels, is_opaque: true })
    }

    /// An empty canvas through which the page is seen; letters are for opaque ones.
    ///
    /// # Errors
    /// If it is empty or too large.
    pub fn transparent(width: f32, height: f32) -> Result<Self, Error> {
        let pixels = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
            .ok_or(Error::Size { width, height })?;
        Ok(Self { pixels, is_opaque: false })
    }

    /// Keeps drawing inside a rectangle; `None` if that is empty.
    pub fn clip(&self, area: Rect) -> Option<Clip> {
        let mut mask = Mask::new(self.pixels.width(), self.pixels.height())?;
        mask.fill_path(&outline(area)?, FillRule::Winding, true, Transform::identity());
        Some(Clip(mask))
    }

    /// A filled rectangle.
    pub fn fill(&mut self, area: Rect, color: Color) {
        if let Some(path) = outline(area) {
            self.fill_path(&path, color, 1.0, None);
        }
    }

    /// The outline of a rectangle.
    pub fn frame(&mut self, area: Rect, color: Color) {
        if let Some(path) = outline(area) {
            self.stroke_path(&path, 1.5, color, 1.0, None);
        }
    }

    /// A filled circle.
    pub fn disc(&mut self, at: [f32; 2], radius: f32, color: Color, alpha: f32) {
        self.disc_clipped(at, radius, color, alpha, None);
    }

    /// A filled circle, kept to a clip.
    pub fn disc_clipped(
        &mut self,
        at: [f32; 2],
        radius: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Clip>,
    ) {
        if let Some(path) = PathBuilder::from_circle(at[0], at[1], radius) {
            self.fill_path(&path, color, alpha, clip);
        }
    }

    /// A straight line.
    pub fn line(
        &mut self,
        from: [f32; 2],
        to: [f32; 2],
        width: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Clip>,
    ) {
        self.polyline(&[from, to], width, color, alpha, clip);
    }

    /// A line through points.
    pub fn polyline(
        &mut self,
        points: &[[f32; 2]],
        width: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Clip>,
    ) {
        let mut builder = PathBuilder::new();
        for (i, p) in points.iter().enumerate() {
            if i == 0 { builder.move_to(p[0], p[1]) } else { builder.line_to(p[0], p[1]) }
        }
        if let Some(path) = builder.finish() {
            self.stroke_path(&path, width, color, alpha, clip);
        }
    }

    /// A photograph, scaled to fill a rectangle: smaller by means, larger as blocks.
    pub fn photograph(&mut self, area: Rect, photograph: &Photograph) {
        let (columns, rows) = (self.pixels.width() as usize, self.pixels.height() as usize);
        let scale = [
            photograph.width() as f32 / area.width.max(1e-3),
            photograph.height() as f32 / area.height.max(1e-3),
        ];
        let within = |from: f32, extent: f32, end: usize| {
            (from.max(0.0) as usize).min(end)..((from + extent).max(0.0) as usize).min(end)
        };
        let xs = within(area.x, area.width, columns);
        for y in within(area.y, area.height, rows) {
            for x in xs.clone() {
                let from = [(x as f32 - area.x) * scale[0], (y as f32 - area.y) * scale[1]];
                let to = [from[0] + scale[0], from[1] + scale[1]];
                let [r, g, b] = photograph.mean(from, to);
                let at = 4 * (y * columns + x);
                if let Some(pixel) = self.pixels.data_mut().get_mut(at..at + 4) {
                    pixel.copy_from_slice(&[r, g, b, 255]);
                }
            }
        }
    }

    /// Width of a text [px].
    pub fn text_width(text: &str) -> f32 {
        (text.chars().count() * get_raster_width(FontWeight::Regular, TEXT)) as f32
    }

    /// A line of text whose upper left (or right) corner lies at (x, y). Letters outside ASCII
    /// become `?`.
    pub fn text(&mut self, x: f32, y: f32, color: Color, text: &str, align: Align) {
        let x = if align == Align::Right { x - Self::text_width(text) } else { x };
        self.draw_letters(x, y, color, text, FontWeight::Regular, TEXT);
    }

    /// A title.
    pub fn bold(&mut self, x: f32, y: f32, color: Color, text: &str) {
        self.draw_letters(x, y, color, text, FontWeight::Bold, TITLE);
    }

    fn draw_letters(
        &mut self,
        x: f32,
        y: f32,
        color: Color,
        text: &str,
        weight: FontWeight,
        height: RasterHeight,
    ) {
        let advance = get_raster_width(weight, height);
        for (i, c) in text.chars().enumerate() {
            let letter = get_raster(c, weight, height).or_else(|| get_raster('?', weight, height));
            let Some(letter) = letter else { continue };
            for (row, line) in letter.rows().enumerate() {
                for (column, &intensity) in line.iter().enumerate() {
                    let at = [x as usize + i * advance + column, y as usize + row];
                    self.blend(at, color, intensity);
                }
            }
        }
    }

    fn blend(&mut self, [x, y]: [usize; 2], Color(r, g, b): Color, intensity: u8) {
        let width = self.pixels.width() as usize;
        if x >= width {
            return;
        }
        let Some(pixel) = self.pixels.data_mut().chunks_exact_mut(4).nth(y * width + x) else {
            return;
        };
        for (old, new) in pixel.iter_mut().zip([r, g, b]) {
            let (keep, add) = (255 - u32::from(intensity), u32::from(intensity));
            *old = ((u32::from(*old) * keep + u32::from(new) * add) / 255) as u8;
        }
    }

    fn fill_path(&mut self, path: &Path, color: Color, alpha: f32, clip: Option<&Clip>) {
        let (paint, identity) = (paint(color, alpha), Transform::identity());
        self.pixels.fill_path(path, &paint, FillRule::Winding, identity, clip.map(|c| &c.0));
    }

    fn stroke_path(
        &mut self,
        path: &Path,
        width: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Clip>,
    ) {
        let stroke = Stroke {
            width,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        let (paint, identity) = (paint(color, alpha), Transform::identity());
        self.pixels.stroke_path(path, &paint, &stroke, identity, clip.map(|c| &c.0));
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.pixels.width(), self.pixels.height()]
    }

    /// Red, green, blue of each pixel of an opaque canvas.
    pub(crate) fn rgb(&self) -> Vec<u8> {
        self.pixels.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect()
    }

    /// The file's bytes, with transparency only if the canvas has it.
    ///
    /// # Errors
    /// If the encoder fails.
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        let failed = |e: png::EncodingError| Error::Encoding(e.to_string());
        let (color, data): (_, Vec<u8>) = if self.is_opaque {
            (png::ColorType::Rgb, self.rgb())
        } else {
            let straight = self.pixels.pixels().iter().flat_map(|p| {
                let p = p.demultiply();
                [p.red(), p.green(), p.blue(), p.alpha()]
            });
            (png::ColorType::Rgba, straight.collect())
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.pixels.width(), self.pixels.height());
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&data).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }
}

fn outline(r: Rect) -> Option<Path> {
    tiny_skia::Rect::from_xywh(r.x, r.y, r.width, r.height).map(PathBuilder::from_rect)
}

fn paint(Color(r, g, b): Color, alpha: f32) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, (255.0 * alpha.clamp(0.0, 1.0)) as u8);
    paint
}

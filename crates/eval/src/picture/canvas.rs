//! Drawing: anti-aliased shapes by `tiny-skia`, letters from a pre-rasterised font, PNG by `png`. Pure Rust, no system
//! font needed, so the picture is the same everywhere.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Stroke, Transform,
};

use crate::Error;

/// Red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Color(pub(super) u8, pub(super) u8, pub(super) u8);

/// A rectangle [px]; y points down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) width: f32,
    pub(super) height: f32,
}

/// Which end of a text lies at its x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Right,
}

pub(super) struct Canvas {
    pixels: Pixmap,
}

const TEXT: RasterHeight = RasterHeight::Size16;
const TITLE: RasterHeight = RasterHeight::Size20;

impl Canvas {
    pub(super) fn new(width: f32, height: f32, background: Color) -> Result<Self, Error> {
        let mut pixels = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
            .ok_or_else(|| Error::Picture(format!("{width} x {height} pixels are too many")))?;
        let Color(r, g, b) = background;
        pixels.fill(tiny_skia::Color::from_rgba8(r, g, b, 255));
        Ok(Self { pixels })
    }

    /// A mask that keeps drawing inside a rectangle.
    pub(super) fn clip(&self, area: Rect) -> Option<Mask> {
        let mut mask = Mask::new(self.pixels.width(), self.pixels.height())?;
        mask.fill_path(&outline(area)?, FillRule::Winding, true, Transform::identity());
        Some(mask)
    }

    pub(super) fn fill(&mut self, area: Rect, color: Color) {
        if let Some(path) = outline(area) {
            self.fill_path(&path, color, 1.0, None);
        }
    }

    pub(super) fn frame(&mut self, area: Rect, color: Color) {
        if let Some(path) = outline(area) {
            self.stroke_path(&path, 1.5, color, 1.0, None);
        }
    }

    pub(super) fn disc(&mut self, at: [f32; 2], radius: f32, color: Color, alpha: f32) {
        self.disc_clipped(at, radius, color, alpha, None);
    }

    pub(super) fn disc_clipped(
        &mut self,
        at: [f32; 2],
        radius: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Mask>,
    ) {
        if let Some(path) = PathBuilder::from_circle(at[0], at[1], radius) {
            self.fill_path(&path, color, alpha, clip);
        }
    }

    pub(super) fn line(
        &mut self,
        from: [f32; 2],
        to: [f32; 2],
        width: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Mask>,
    ) {
        self.polyline(&[from, to], width, color, alpha, clip);
    }

    pub(super) fn polyline(
        &mut self,
        points: &[[f32; 2]],
        width: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Mask>,
    ) {
        let mut builder = PathBuilder::new();
        for (i, p) in points.iter().enumerate() {
            if i == 0 { builder.move_to(p[0], p[1]) } else { builder.line_to(p[0], p[1]) }
        }
        if let Some(path) = builder.finish() {
            self.stroke_path(&path, width, color, alpha, clip);
        }
    }

    /// Width of a text [px].
    pub(super) fn text_width(text: &str) -> f32 {
        (text.chars().count() * get_raster_width(FontWeight::Regular, TEXT)) as f32
    }

    /// A line of text whose upper left (or right) corner lies at (x, y). Letters outside ASCII become `?`.
    pub(super) fn text(&mut self, x: f32, y: f32, color: Color, text: &str, align: Align) {
        let x = if align == Align::Right { x - Self::text_width(text) } else { x };
        self.letters(x, y, color, text, FontWeight::Regular, TEXT);
    }

    /// A title.
    pub(super) fn bold(&mut self, x: f32, y: f32, color: Color, text: &str) {
        self.letters(x, y, color, text, FontWeight::Bold, TITLE);
    }

    fn letters(
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

    fn fill_path(&mut self, path: &Path, color: Color, alpha: f32, clip: Option<&Mask>) {
        let (paint, still) = (paint(color, alpha), Transform::identity());
        self.pixels.fill_path(path, &paint, FillRule::Winding, still, clip);
    }

    fn stroke_path(
        &mut self,
        path: &Path,
        width: f32,
        color: Color,
        alpha: f32,
        clip: Option<&Mask>,
    ) {
        let stroke = Stroke {
            width,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        self.pixels.stroke_path(path, &paint(color, alpha), &stroke, Transform::identity(), clip);
    }

    /// The file's bytes. The background is opaque, so there is no alpha to keep.
    pub(super) fn to_png(&self) -> Result<Vec<u8>, Error> {
        let failed = |e: png::EncodingError| Error::Picture(e.to_string());
        let opaque: Vec<u8> =
            self.pixels.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.pixels.width(), self.pixels.height());
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&opaque).map_err(failed)?;
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

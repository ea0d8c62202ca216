//! A camera's images of a frame, prepared for tracking: layers of colour, smoothed depth, and
//! the distance of each pixel from the outline of its region.

use std::ops::Range;

use bendtwin_capture::raw::{Camera, ColorImage, DepthImage, Frames, Image, Mask, Region};

use crate::{Error, FlowSettings, matching::layer::Layer};

#[cfg(test)]
mod tests;

/// A camera at a frame.
#[derive(Debug)]
pub(crate) struct View {
    /// The object's colours; `None` if it is not in the image.
    pub(crate) object: Option<Layer>,
    /// The manipulator's colours; `None` if it is not in the image.
    pub(crate) manipulator: Option<Layer>,
    /// The region that each pixel shows.
    labels: Image<Option<Region>>,
    /// Distance to the nearest pixel of another region [px], at most [`MAX_INSET_PX`].
    insets: Vec<u8>,
    /// Depth without its noise [m], 0 where nothing was measured; smoothed within a surface only.
    depth: DepthImage,
}

/// Largest distance that is represented [px].
const MAX_INSET_PX: u8 = 255;

impl View {
    /// Reads and prepares a frame; `None` if it was not recorded, or has no mask of the object.
    pub(crate) fn read(
        frames: &mut dyn Frames,
        camera: &Camera,
        frame: usize,
        settings: &FlowSettings,
    ) -> Result<Option<Self>, Error> {
        let (Some(color), Some(depth)) = (frames.color(frame)?, frames.depth(frame)?) else {
            return Ok(None);
        };
        let Some(object) = frames.mask(frame, Region::Object)? else { return Ok(None) };
        let manipulator = frames.mask(frame, Region::Manipulator)?;
        let size = |what, width, height, pixels| {
            let expected = (camera.width, camera.height);
            if (width, height) == expected && pixels == width * height {
                return Ok(());
            }
            let found = (width, height);
            Err(Error::ImageSize { camera: camera.name.clone(), frame, what, found, expected })
        };
        size("the colour image", color.width, color.height, color.pixels.len())?;
        size("the depth image", depth.width, depth.height, depth.pixels.len())?;
        size("the object's mask", object.width, object.height, object.pixels.len())?;
        if let Some(m) = &manipulator {
            size("the manipulator's mask", m.width, m.height, m.pixels.len())?;
        }
        Ok(Some(Self::new(&color, &depth, &object, manipulator.as_ref(), settings)))
    }

    /// Prepares images that are known to be of one size.
    pub(crate) fn new(
        color: &ColorImage,
        depth: &DepthImage,
        object: &Mask,
        manipulator: Option<&Mask>,
        settings: &FlowSettings,
    ) -> Self {
        // A hand in front of the object may be in both masks: it is the hand that is seen.
        let pixels: Vec<_> = (0..color.pixels.len())
            .map(|i| {
                if manipulator.is_some_and(|m| m.pixels[i]) {
                    Some(Region::Manipulator)
                } else {
                    object.pixels[i].then_some(Region::Object)
                }
            })
            .collect();
        let layer = |region| {
            let inside: Vec<bool> = pixels.iter().map(|&l| l == Some(region)).collect();
            Layer::new(color, &inside, settings.smoothing_px, settings.levels)
        };
        let (object, manipulator) = (layer(Region::Object), layer(Region::Manipulator));
        let labels = Image { width: color.width, height: color.height, pixels };
        let insets = insets(&labels);
        let depth = smoothed(depth, &labels, settings.depth_jump_m as f32);
        Self { object, manipulator, labels, insets, depth }
    }

    /// The colours of a region.
    pub(crate) fn layer(&self, region: Region) -> Option<&Layer> {
        match region {
            Region::Object => self.object.as_ref(),
            Region::Manipulator => self.manipulator.as_ref(),
        }
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.labels.width, self.labels.height]
    }

    /// Pixels at least `min_inset` inside of a region: about `count` of them on a square grid, or
    /// all if there are fewer.
    pub(crate) fn places(&self, region: Region, min_inset: u8, count: usize) -> Vec<[f64; 2]> {
        let inside =
            |i: &usize| self.labels.pixels[*i] == Some(region) && self.insets[*i] >= min_inset;
        let all = (0..self.insets.len()).filter(inside).count();
        let stride = ((all as f64 / count.max(1) as f64).sqrt().floor() as usize).max(1);
        let width = self.labels.width;
        (0..self.insets.len())
            .filter(|i| (i % width).is_multiple_of(stride) && (i / width).is_multiple_of(stride))
            .filter(inside)
            .map(|i| [(i % width) as f64, (i / width) as f64])
            .collect()
    }

    /// True if any pixel within `radius` of a place shows a region; beyond the image, nothing is
    /// shown.
    pub(crate) fn shows_near(&self, at: [f64; 2], radius: usize) -> bool {
        let Some([rows, columns]) = self.square(at, radius) else { return false };
        rows.into_iter().any(|r| self.labels.row(r)[columns.clone()].iter().any(Option::is_some))
    }

    /// Distance of a place inside `region` from its outline [px]; 0 outside.
    pub(crate) fn inset(&self, at: [f64; 2], region: Region) -> u8 {
        let Some([column, row]) = self.nearest(at) else { return 0 };
        let i = row * self.labels.width + column;
        if self.labels.pixels[i] == Some(region) { self.insets[i] } else { 0 }
    }

    /// Depth of `region` at a sub-pixel place [m], interpolated within one surface. `None` where
    /// nothing was measured.
    pub(crate) fn depth(&self, at: [f64; 2], region: Region, jump: f32) -> Option<f32> {
        let [column, row] = self.nearest(at)?;
        let label = |c: usize, r: usize| self.labels.get(c, r).flatten();
        let here = self
            .depth
            .get(column, row)
            .filter(|&d| d > 0.0 && label(column, row) == Some(region))?;
        let (left, top) = (at[0].floor(), at[1].floor());
        let (u, v) = ((at[0] - left) as f32, (at[1] - top) as f32);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dx, dy, weight) in [
            (0, 0, (1.0 - u) * (1.0 - v)),
            (1, 0, u * (1.0 - v)),
            (0, 1, (1.0 - u) * v),
            (1, 1, u * v),
        ] {
            let (c, r) = (left as i64 + dx, top as i64 + dy);
            let (Ok(c), Ok(r)) = (usize::try_from(c), usize::try_from(r)) else { continue };
            let Some(d) = self.depth.get(c, r) else { continue };
            if d > 0.0 && label(c, r) == Some(region) && (d - here).abs() < jump {
                sum += weight * d;
                weights += weight;
            }
        }
        Some(if weights > 0.0 { sum / weights } else { here })
    }

    /// True if a place lies on one surface: all that was measured beside it is about as deep.
    pub(crate) fn is_smooth(&self, at: [f64; 2], region: Region, jump: f32) -> bool {
        let Some(here) = self.depth(at, region, jump) else { return false };
        let Some([mut rows, columns]) = self.square(at, 1) else { return false };
        rows.all(|row| {
            let there = &self.depth.row(row)[columns.clone()];
            there.iter().all(|&d| d <= 0.0 || (d - here).abs() < jump)
        })
    }

    /// Smallest depth measured within `radius` pixels of a place [m], `None` where nothing was
    /// measured.
    pub(crate) fn nearest_depth_near(&self, at: [f64; 2], radius: usize) -> Option<f32> {
        let [rows, columns] = self.square(at, radius)?;
        rows.flat_map(|row| self.depth.row(row)[columns.clone()].iter().copied())
            .filter(|&d| d > 0.0)
            .min_by(f32::total_cmp)
    }

    /// Rows and columns within `radius` pixels of a place.
    fn square(&self, at: [f64; 2], radius: usize) -> Option<[Range<usize>; 2]> {
        let [column, row] = self.nearest(at)?;
        let [width, height] = self.size();
        Some([
            row.saturating_sub(radius)..(row + radius + 1).min(height),
            column.saturating_sub(radius)..(column + radius + 1).min(width),
        ])
    }

    fn nearest(&self, at: [f64; 2]) -> Option<[usize; 2]> {
        let [x, y] = [at[0].round(), at[1].round()];
        let inside =
            x >= 0.0 && y >= 0.0 && x < self.labels.width as f64 && y < self.labels.height as f64;
        inside.then_some([x as usize, y as usize])
    }
}

/// City-block distance to the nearest pixel with another label, in two sweeps.
fn insets(labels: &Image<Option<Region>>) -> Vec<u8> {
    let (width, height) = (labels.width, labels.height);
    let mut distance = vec![MAX_INSET_PX; width * height];
    let mut relax = |i: usize, other: usize| {
        let through = if labels.pixels[i] == labels.pixels[other] {
            distance[other].saturating_add(1)
        } else {
            1
        };
        distance[i] = distance[i].min(through);
    };
    for i in 0..width * height {
        if i % width > 0 {
            relax(i, i - 1);
        }
        if i >= width {
            relax(i, i - width);
        }
    }
    for i in (0..width * height).rev() {
        if i % width + 1 < width {
            relax(i, i + 1);
        }
        if i + width < width * height {
            relax(i, i + width);
        }
    }
    distance
}

/// Mean of the 5 x 5 neighbours of the same region that lie within `jump` of a pixel, itself
/// included.
fn smoothed(depth: &DepthImage, labels: &Image<Option<Region>>, jump: f32) -> DepthImage {
    const HALF: usize = 2;
    let (width, height) = (depth.width, depth.height);
    let mut out = depth.clone();
    for row in 0..height {
        for column in 0..width {
            let i = row * width + column;
            let here = depth.pixels[i];
            // NaN and infinity count as not measured.
            if !(here > 0.0 && here.is_finite()) {
                out.pixels[i] = 0.0;
                continue;
            }
            if labels.pixels[i].is_none() {
                continue;
            }
            let (mut sum, mut count) = (0.0, 0.0_f32);
            for r in row.saturating_sub(HALF)..(row + HALF + 1).min(height) {
                for c in column.saturating_sub(HALF)..(column + HALF + 1).min(width) {
                    let j = r * width + c;
                    let there = depth.pixels[j];
                    if (there - here).abs() < jump && labels.pixels[j] == labels.pixels[i] {
                        sum += there;
                        count += 1.0;
                    }
                }
            }
            out.pixels[i] = sum / count.max(1.0);
        }
    }
    out
}

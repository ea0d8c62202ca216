//! Cleaning of one camera's masks in one frame: what is left are pixels whose depth is that of the
//! object, or of the manipulator.

use bendtwin_capture::raw::{DepthImage, Image, Intrinsics, Mask};
use bendtwin_core::{Point, settings::ingest::MaskSettings};
use bendtwin_near::PointTree;

use crate::{evidence::MaskCounts, rigid::distance};

/// Pixels of an object to which the distance of a small part is measured.
const MAX_MEASURED_PIXELS: usize = 1500;

/// Label of a pixel after cleaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    /// No usable depth.
    None,
    /// The object.
    Object,
    /// A hand or gripper.
    Manipulator,
}

/// Cleaned masks of a frame, and where the pixels went.
pub(crate) struct CleanMasks {
    /// A label for every pixel.
    pub(crate) labels: Image<Label>,
    pub(crate) object: MaskCounts,
    pub(crate) manipulator: MaskCounts,
}

/// Depths whose difference is larger lie on different surfaces [m].
pub(crate) fn edge_m(depth_m: f32, intrinsics: &Intrinsics, settings: &MaskSettings) -> f32 {
    let pixel_m = f64::from(depth_m) / intrinsics.fx.min(intrinsics.fy).abs().max(1e-6);
    (settings.edge_m + settings.edge_slope * pixel_m) as f32
}

/// Cleans the masks of a frame. A pixel in both masks belongs to the manipulator, which is in front
/// of what it holds.
pub(crate) fn clean(
    depth: &DepthImage,
    object: Option<&Mask>,
    manipulator: Option<&Mask>,
    intrinsics: &Intrinsics,
    settings: &MaskSettings,
) -> CleanMasks {
    let mut cleaner = Cleaner {
        depth,
        intrinsics,
        settings,
        labels: Image::filled(depth.width, depth.height, Label::None),
    };
    let mut counts = [MaskCounts::default(), MaskCounts::default()];
    let order = [(Label::Object, object), (Label::Manipulator, manipulator)];
    for ((label, mask), counts) in order.into_iter().zip(&mut counts) {
        if let Some(mask) = mask {
            cleaner.draw(mask, label, counts);
        }
    }
    // What the hand covers is no longer the object's.
    if let (Some(a), Some(b)) = (object, manipulator) {
        let both = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| **a && **b).count() as u64;
        counts[0].pixels = counts[0].pixels.saturating_sub(both);
    }
    for ((label, mask), counts) in order.into_iter().zip(&mut counts) {
        if mask.is_some() {
            counts.flying = cleaner.drop_flying(label);
            counts.specks = cleaner.drop_specks(label);
        }
    }
    if object.is_some() && manipulator.is_some() && settings.contact_m > 0.0 {
        let [o, m] = cleaner.drop_contact();
        (counts[0].contact, counts[1].contact) = (o, m);
    }
    for ((label, _), counts) in order.into_iter().zip(&mut counts) {
        counts.kept = cleaner.labels.pixels.iter().filter(|l| **l == label).count() as u64;
        counts.no_depth = counts
            .pixels
            .saturating_sub(counts.flying + counts.specks + counts.contact + counts.kept);
    }
    let [object, manipulator] = counts;
    CleanMasks { labels: cleaner.labels, object, manipulator }
}

struct Cleaner<'a> {
    depth: &'a DepthImage,
    intrinsics: &'a Intrinsics,
    settings: &'a MaskSettings,
    labels: Image<Label>,
}

impl Cleaner<'_> {
    fn draw(&mut self, mask: &Mask, label: Label, counts: &mut MaskCounts) {
        let (near, far) = (self.settings.nearest_m as f32, self.settings.farthest_m as f32);
        let depths = self.depth.pixels.iter();
        let mut inside = 0;
        for ((l, m), z) in self.labels.pixels.iter_mut().zip(&mask.pixels).zip(depths) {
            if *m {
                inside += 1;
                // A hole in the depth of a hand hides the object all the same.
                *l = if *z > 0.0 && *z >= near && *z <= far { label } else { Label::None };
            }
        }
        counts.frames = 1;
        counts.empty_frames = u64::from(inside == 0);
        counts.pixels = inside;
    }

    /// Drops pixels with few neighbours on their own surface among the 24 around them.
    fn drop_flying(&mut self, label: Label) -> u64 {
        let (width, height) = (self.depth.width, self.depth.height);
        let mut gone = Vec::new();
        for (at, _) in self.labels.pixels.iter().enumerate().filter(|(_, l)| **l == label) {
            let (x, y) = (at % width, at / width);
            let z = self.depth.pixels[at];
            let edge = edge_m(z, self.intrinsics, self.settings);
            let mut near = 0;
            for row in y.saturating_sub(2)..(y + 3).min(height) {
                for column in x.saturating_sub(2)..(x + 3).min(width) {
                    let other = row * width + column;
                    let same = self.labels.pixels[other] == label
                        && (self.depth.pixels[other] - z).abs() <= edge;
                    near += u32::from(same && other != at);
                }
            }
            if near < self.settings.min_neighbours {
                gone.push(at);
            }
        }
        self.erase(&gone)
    }

    /// Drops small parts that are far from larger ones; two pixels are of one part if they touch
    /// and lie on one surface.
    fn drop_specks(&mut self, label: Label) -> u64 {
        let (width, height) = (self.depth.width, self.depth.height);
        let mut part_of = vec![0u32; self.labels.pixels.len()];
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for seed in 0..part_of.len() {
            if self.labels.pixels[seed] != label || part_of[seed] != 0 {
                continue;
            }
            let number = parts.len() as u32 + 1;
            part_of[seed] = number;
            let mut part = vec![seed];
            let mut next = 0;
            while let Some(&at) = part.get(next) {
                next += 1;
                let (x, y, z) = (at % width, at / width, self.depth.pixels[at]);
                let edge = edge_m(z, self.intrinsics, self.settings);
                let around = [
                    (x > 0).then(|| at - 1),
                    (x + 1 < width).then_some(at + 1),
                    (y > 0).then(|| at - width),
                    (y + 1 < height).then_some(at + width),
                ];
                for other in around.into_iter().flatten() {
                    if part_of[other] == 0
                        && self.labels.pixels[other] == label
                        && (self.depth.pixels[other] - z).abs() <= edge
                    {
                        part_of[other] = number;
                        part.push(other);
                    }
                }
            }
            parts.push(part);
        }
        let largest = parts.iter().map(Vec::len).max().unwrap_or(0);
        let least = self.settings.min_component * largest as f64;
        let (small, large): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|p| (p.len() as f64) < least);
        if small.is_empty() {
            return 0;
        }
        // A finger may cut a small part off: it is near the rest. What is far from it is
        // background.
        let kept: Vec<usize> = large.into_iter().flatten().collect();
        let stride = kept.len().div_ceil(MAX_MEASURED_PIXELS).max(1);
        let gap_m = self.settings.speck_gap_m;
        let rest = PointTree::new(kept.iter().step_by(stride).map(|i| self.place(*i)));
        let far = |p: &Vec<usize>| !rest.any_within(self.place(p[p.len() / 2]), gap_m);
        let gone: Vec<usize> = small.into_iter().filter(far).flatten().collect();
        self.erase(&gone)
    }

    /// Drops pixels that have more neighbours in space of the other label than of theirs: where
    /// masks bleed into each other. Returns the numbers dropped of the object and of the
    /// manipulator.
    fn drop_contact(&mut self) -> [u64; 2] {
        let (width, height) = (self.depth.width, self.depth.height);
        let mut gone = [Vec::new(), Vec::new()];
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                let label = self.labels.pixels[at];
                if label == Label::None {
                    continue;
                }
                let z = self.depth.pixels[at];
                let reach_px = self.settings.contact_m * self.intrinsics.fx.abs() / f64::from(z);
                // Far beyond a few pixels the test says nothing more, and costs much.
                let reach = (reach_px.ceil() as usize).clamp(1, 6);
                if !self.touches_other(x, y, reach, label) {
                    continue;
                }
                let [mut own, mut other] = [0u32; 2];
                for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                    for column in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                        let there = row * width + column;
                        let l = self.labels.pixels[there];
                        if l == Label::None || !self.within_contact(at, there) {
                            continue;
                        }
                        own += u32::from(l == label);
                        other += u32::from(l != label);
                    }
                }
                if other > own {
                    gone[usize::from(label == Label::Manipulator)].push(at);
                }
            }
        }
        let [object, manipulator] = gone;
        [self.erase(&object), self.erase(&manipulator)]
    }

    /// True if the other label occurs in the window at all: inside a surface it does not, and
    /// counting is saved.
    fn touches_other(&self, x: usize, y: usize, reach: usize, label: Label) -> bool {
        let (width, height) = (self.depth.width, self.depth.height);
        let other = |l: Label| l != Label::None && l != label;
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
        rows.into_iter().any(|row| {
            let from = row * width + x.saturating_sub(reach);
            let to = row * width + (x + reach + 1).min(width);
            self.labels.pixels[from..to].iter().any(|l| other(*l))
        })
    }

    fn within_contact(&self, a: usize, b: usize) -> bool {
        distance(self.place(a), self.place(b)) <= self.settings.contact_m
    }

    /// A pixel in space, in the camera's axes; lens distortion does not matter over such distances
    /// [m].
    fn place(&self, at: usize) -> Point {
        let (z, i) = (f64::from(self.depth.pixels[at]), self.intrinsics);
        let x = ((at % self.depth.width) as f64 - i.cx) / i.fx * z;
        let y = ((at / self.depth.width) as f64 - i.cy) / i.fy * z;
        [x as f32, y as f32, z as f32]
    }

    fn erase(&mut self, pixels: &[usize]) -> u64 {
        for at in pixels {
            self.labels.pixels[*at] = Label::None;
        }
        pixels.len() as u64
    }
}

#[cfg(test)]
mod tests;

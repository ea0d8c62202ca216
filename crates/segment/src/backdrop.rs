//! The backdrop of a standing camera: what it sees behind everything that moves, pixel by pixel, from
//! some frames of the whole recording.

use bendtwin_capture::raw::Frames;

use crate::{
    Error,
    view::{Lens, View, color_square},
};

/// Frames by which a backdrop is known at most; they lie evenly in the recording.
const MOST_FRAMES: usize = 12;
/// Bytes that the samples of a camera may take.
const MOST_BYTES: usize = 256 << 20;
/// Bytes of a sample: depth and colour.
const SAMPLE_BYTES: usize = 5;
/// Depths within this belong to one surface [m], and as a share of the depth's square [1/m]: the noise
/// of stereo cameras grows with it.
const SAME_M: f32 = 0.006;
const SAME_PER_M: f32 = 0.006;
/// Colours of a standing surface differ by no more in two frames, of 255.
const SAME_COLOR: f32 = 28.0;

/// Depth of a backdrop that is too far away to be measured, or too dark.
const VOID: f32 = -1.0;

/// What lies behind everything that moves.
pub(crate) struct Backdrop {
    /// Depth [m], 0 where it is not known, [`VOID`] where it cannot be measured. Shape
    /// [height, width].
    depths: Vec<f32>,
    colors: Vec<[u8; 3]>,
    /// `true` where the backdrop is known to be neither object nor hand.
    settled: Vec<bool>,
}

/// How a pixel's content compares with the backdrop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Against {
    /// The backdrop is not known, or the depth not measured and the colour another.
    Unknown,
    /// Something in front of the backdrop.
    Before,
    /// The backdrop by depth, or by colour where no depth was measured.
    Same,
    /// The backdrop's depth in another colour.
    Recoloured,
    /// Same, where the backdrop is known to be neither object nor hand.
    Settled,
}

/// Depths that differ by more lie on different surfaces [m].
pub(crate) fn same_m(depth_m: f32) -> f32 {
    SAME_M + SAME_PER_M * depth_m * depth_m
}

impl Backdrop {
    /// Nothing is known: of a camera that moves.
    pub(crate) fn unknown(lens: &Lens<'_>) -> Self {
        let n = lens.len();
        Self { depths: vec![0.0; n], colors: vec![[0; 3]; n], settled: vec![false; n] }
    }

    /// Reads frames of a camera that stands.
    pub(crate) fn read(
        lens: &Lens<'_>,
        frames: &mut dyn Frames,
        frame_count: usize,
        is_cancelled: &dyn Fn() -> bool,
    ) -> Result<Self, Error> {
        let n = lens.len();
        let most = (MOST_BYTES / (SAMPLE_BYTES * n.max(1))).clamp(3, MOST_FRAMES);
        let count = most.min(frame_count);
        let mut views: Vec<(Vec<u16>, Vec<[u8; 3]>)> = Vec::new();
        for k in 0..count {
            if is_cancelled() {
                return Err(Error::Cancelled);
            }
            let frame = k * frame_count.saturating_sub(1) / count.saturating_sub(1).max(1);
            if let Some(View { colors, depths, .. }) = lens.read(frames, frame)? {
                let depths = depths.iter().map(|d| (1000.0 * d).round() as u16).collect();
                views.push((depths, colors));
            }
        }
        let mut backdrop = Self::unknown(lens);
        let (mut measured, mut colors) = (Vec::new(), Vec::new());
        for at in 0..n {
            measured.clear();
            colors.clear();
            for (of_depth, of_color) in &views {
                match of_depth[at] {
                    0 => colors.push(of_color[at]),
                    mm => measured.push((f32::from(mm) / 1000.0, of_color[at])),
                }
            }
            let farthest = farthest(&mut measured);
            let far = void(&colors)
                .filter(|(count, _)| farthest.is_none_or(|(support, ..)| *count > support));
            (backdrop.depths[at], backdrop.colors[at]) = match (far, farthest) {
                (Some((_, color)), _) => (VOID, color),
                (None, Some((_, depth, color))) => (depth, color),
                (None, None) => continue,
            };
        }
        Ok(backdrop)
    }

    /// Depth of the backdrop [m], 0 where it is not known or cannot be measured.
    pub(crate) fn depth(&self, at: usize) -> f32 {
        self.depths[at].max(0.0)
    }

    /// Colour of the backdrop, if it is known.
    pub(crate) fn color(&self, at: usize) -> Option<[u8; 3]> {
        (self.depths[at] != 0.0).then(|| self.colors[at])
    }

    /// Says that the backdrop is neither object nor hand there.
    pub(crate) fn settle(&mut self, at: usize) {
        self.settled[at] = self.depths[at] != 0.0;
    }

    /// Compares a pixel with the backdrop.
    pub(crate) fn compare(&self, at: usize, depth: f32, color: [u8; 3]) -> Against {
        let behind = self.depths[at];
        if behind == 0.0 {
            return Against::Unknown;
        }
        let is_recoloured = color_square(color, self.colors[at]) > SAME_COLOR * SAME_COLOR;
        let near = depth > 0.0 && (behind == VOID || depth < behind - same_m(behind));
        match (near, depth > 0.0, is_recoloured) {
            (true, ..) => Against::Before,
            (_, false, true) => Against::Unknown,
            (_, true, true) => Against::Recoloured,
            (_, _, false) if self.settled[at] => Against::Settled,
            (_, _, false) => Against::Same,
        }
    }
}

/// The farthest depth that two samples agree on with their number, and the mean colour there; that of
/// the only sample if there is one.
fn farthest(samples: &mut [(f32, [u8; 3])]) -> Option<(usize, f32, [u8; 3])> {
    samples.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let agreeing = |first: usize| {
        let depth = samples[first].0;
        let end = samples[first..].iter().position(|s| s.0 < depth - same_m(depth));
        first..end.map_or(samples.len(), |end| first + end)
    };
    let lone = (!samples.is_empty()).then_some(0..1);
    let range = (0..samples.len()).map(agreeing).find(|range| range.len() > 1).or(lone)?;
    let same = &samples[range];
    let depth = same.iter().map(|s| s.0).sum::<f32>() / same.len() as f32;
    Some((same.len(), depth, mean(same.iter().map(|s| s.1))))
}

/// The colour that at least two samples without depth agree on, with their number.
fn void(colors: &[[u8; 3]]) -> Option<(usize, [u8; 3])> {
    let alike = |color: [u8; 3]| {
        let same =
            colors.iter().filter(move |c| color_square(**c, color) <= SAME_COLOR * SAME_COLOR);
        same.copied()
    };
    let most = colors.iter().copied().max_by_key(|color| alike(*color).count())?;
    let count = alike(most).count();
    (count > 1).then(|| (count, mean(alike(most))))
}

/// Mean of colours.
fn mean(colors: impl Iterator<Item = [u8; 3]>) -> [u8; 3] {
    let (mut sum, mut count) = ([0_u32; 3], 0);
    for color in colors {
        (0..3).for_each(|k| sum[k] += u32::from(color[k]));
        count += 1;
    }
    sum.map(|s| (s / count.max(1)) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_depth_that_repeats_is_the_backdrop() {
        let gray = |d: f32| (d, [100; 3]);
        // A hand at 0.5 m, a table at 0.8 m, and one outlier behind it.
        let mut samples = [gray(0.5), gray(0.801), gray(1.9), gray(0.502), gray(0.799)];
        let (count, depth, _) = farthest(&mut samples).unwrap();
        assert!(count == 2 && (depth - 0.8).abs() < 1e-3, "{depth}");
        assert_eq!(farthest(&mut [gray(0.7)]).unwrap().1, 0.7);
        assert_eq!(farthest(&mut []), None);
    }

    #[test]
    fn a_colour_that_repeats_without_depth_is_a_void() {
        assert_eq!(void(&[[200; 3], [10; 3], [202; 3], [90; 3]]), Some((2, [201; 3])));
        assert_eq!(void(&[[200; 3], [10; 3]]), None);
        assert_eq!(void(&[]), None);
    }
}

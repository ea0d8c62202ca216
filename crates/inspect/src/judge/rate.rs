//! Rates of cameras that are slower than the recording: their images come at regular gaps, which are no
//! dropped frames.

use crate::thresholds::TimingThresholds;

/// The rate of a camera that is slower than the recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OwnRate {
    /// Frames of the recording for each of its images.
    pub(super) frames_per_image: f64,
    /// Frames in which it should have an image, and has none.
    pub(super) dropped: Vec<usize>,
}

/// The rate of a camera with images in these frames of `all`, if it is slower than the recording;
/// `declared` are the frames for each image as the recording declares them.
pub(super) fn own_rate(
    present: &[usize],
    all: usize,
    declared: Option<f64>,
    limits: &TimingThresholds,
) -> Option<OwnRate> {
    let gaps = || present.windows(2).filter_map(|w| w[1].checked_sub(w[0]));
    let frames_per_image = match declared {
        Some(declared) => declared,
        None => {
            let mut sorted: Vec<usize> = gaps().collect();
            sorted.sort_unstable();
            let usual = sorted.get(sorted.len() / 2).copied()?;
            // A rate that is no whole share of the recording's has gaps of two lengths.
            let is_regular = |gap: &usize| *gap == usual || *gap == usual + 1;
            let regular: Vec<usize> = sorted.iter().copied().filter(is_regular).collect();
            let share = regular.len() as f64 / sorted.len() as f64;
            if usual < 2
                || sorted.len() < limits.min_regular_gaps
                || share < limits.min_regular_share
            {
                return None;
            }
            regular.iter().sum::<usize>() as f64 / regular.len() as f64
        }
    };
    // Before the first image, between two, and after the last.
    let first = present.first().copied()?;
    let last = present.last().copied()?;
    let mut dropped: Vec<usize> = Vec::new();
    let mut between = |from: f64, gap: f64, whole: bool| {
        let images = if whole {
            (gap / frames_per_image).round() - 1.0
        } else {
            (gap / frames_per_image).floor()
        };
        dropped.extend((1..=images.max(0.0) as usize).map(|i| {
            let step = if whole { gap / (images + 1.0) } else { frames_per_image };
            (from + i as f64 * step).round() as usize
        }));
    };
    between(
        first as f64
            - (first as f64 / frames_per_image).floor() * frames_per_image
            - frames_per_image,
        first as f64,
        false,
    );
    for pair in present.windows(2) {
        between(pair[0] as f64, pair[1].saturating_sub(pair[0]) as f64, true);
    }
    between(last as f64, all.saturating_sub(1).saturating_sub(last) as f64, false);
    Some(OwnRate { frames_per_image, dropped })
}

/// Whole ratio of the frames to the images of a camera that ends early, if it has as many images as a
/// camera of a fraction of the rate that numbers them one after another.
pub(super) fn closed_up(present: &[usize], all: usize, limits: &TimingThresholds) -> Option<f64> {
    let (first, last) = (*present.first()?, *present.last()?);
    let span = last - first + 1;
    let ratio = all as f64 / span as f64;
    let is_whole = (ratio / ratio.round() - 1.0).abs() < limits.max_closed_up_error;
    (first == 0 && (2.0..=limits.max_closed_up).contains(&ratio.round()) && is_whole)
        .then_some(ratio.round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(present: &[usize], all: usize) -> Option<OwnRate> {
        own_rate(present, all, None, &TimingThresholds::default())
    }

    #[test]
    fn regular_gaps_are_a_rate() {
        let half: Vec<usize> = (0..40).step_by(2).collect();
        assert_eq!(rate(&half, 40), Some(OwnRate { frames_per_image: 2.0, dropped: Vec::new() }));
        let with_drops: Vec<usize> =
            half.iter().copied().filter(|f| ![10, 24, 26].contains(f)).collect();
        assert_eq!(rate(&with_drops, 40).unwrap().dropped, [10, 24, 26]);
        let cut: Vec<usize> = half.iter().copied().filter(|f| *f < 30).collect();
        assert_eq!(rate(&cut, 40).unwrap().dropped, [30, 32, 34, 36, 38]);
        let late: Vec<usize> = half.iter().copied().filter(|f| *f >= 6).collect();
        assert_eq!(rate(&late, 40).unwrap().dropped, [0, 2, 4]);
        let odd: Vec<usize> = (0..20).map(|i| (f64::from(i) * 2.4).round() as usize).collect();
        let found = rate(&odd, 48).unwrap();
        assert!(
            (found.frames_per_image - 2.4).abs() < 0.1 && found.dropped.is_empty(),
            "{found:?}"
        );
    }

    #[test]
    fn dropped_frames_are_no_rate() {
        assert_eq!(rate(&(0..40).collect::<Vec<_>>(), 40), None);
        let quarter: Vec<usize> = (0..40).filter(|f| f % 4 != 2).collect();
        assert_eq!(rate(&quarter, 40), None);
        // Two of three gone at random.
        let random = [0, 1, 5, 6, 7, 13, 14, 20, 21, 22, 30, 38];
        assert_eq!(rate(&random, 40), None);
        assert_eq!(rate(&[0, 2, 4], 40), None, "three images say nothing");
        assert_eq!(rate(&[], 40), None);
    }

    #[test]
    fn a_camera_that_ends_at_half_may_have_half_the_rate() {
        let limits = TimingThresholds::default();
        let to = |end: usize| closed_up(&(0..end).collect::<Vec<_>>(), 100, &limits);
        assert_eq!((to(50), to(51), to(33), to(25)), (Some(2.0), Some(2.0), Some(3.0), Some(4.0)));
        assert_eq!((to(100), to(90), to(70), to(40), to(3)), (None, None, None, None, None));
    }
}

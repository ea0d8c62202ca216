//! A camera of a lower rate whose images are numbered one after another: it seems to end early, and to
//! run ahead of the others until then.

use super::super::{Context, named};
use crate::{
    Code, Finding,
    scan::{CameraScan, FrameStats},
    thresholds::TimingThresholds,
};

/// The finding of a camera whose images end at a whole share of the recording, while another camera has
/// nearly all.
pub(super) fn judge(context: &Context<'_>, index: usize) -> Option<Finding> {
    let limits = &context.thresholds.timing;
    let scan = context.scans.get(index)?;
    let all = scan.frames.len();
    let is_full =
        |other: &CameraScan| present(other).count() as f64 >= limits.min_full_share * all as f64;
    let others = context.scans.iter().enumerate().filter(|(other, _)| *other != index);
    let ratio = ratio(present(scan), all, limits)?;
    if !others.into_iter().any(|(_, other)| is_full(other)) {
        return None;
    }
    let fps = (100.0 * context.recording.fps / ratio).round() / 100.0;
    let message = format!(
        "{} has {} images and the recording {all} frames: it stopped, or is one of {fps} fps whose images are numbered one \
         after another",
        named(context.recording, index),
        present(scan).count(),
    );
    let finding = Finding::error(Code::CameraRateUnclear, message).cameras([index]);
    Some(finding.number("camera_fps", fps))
}

/// Frames in which a camera has colour and depth, or files that are damaged.
fn present(scan: &CameraScan) -> impl Iterator<Item = usize> {
    let frames = scan.frames.iter().enumerate();
    let is_there = |(frame, g): (usize, &FrameStats)| {
        let whole = g.color.is_some() && g.depth.is_some();
        (whole || scan.is_damaged(frame)).then_some(frame)
    };
    frames.filter_map(is_there)
}

/// Whole ratio of the frames to the images of a camera that has them from the first frame on, with few
/// gaps.
fn ratio(
    present: impl Iterator<Item = usize>,
    all: usize,
    limits: &TimingThresholds,
) -> Option<f64> {
    let (mut count, mut last) = (0_usize, 0);
    for frame in present {
        if count == 0 && frame != 0 {
            return None;
        }
        (count, last) = (count + 1, frame);
    }
    let ratio = all as f64 / (last + 1) as f64;
    let is_dense = count as f64 >= limits.min_dense_share * (last + 1) as f64;
    let is_whole = (ratio / ratio.round() - 1.0).abs() < limits.max_closed_up_error;
    let is_rate = (2.0..=limits.max_closed_up).contains(&ratio.round());
    (count > 0 && is_dense && is_rate && is_whole).then_some(ratio.round())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_ends_at_half_may_have_half_the_rate() {
        let limits = TimingThresholds::default();
        let to = |end: usize| ratio(0..end, 100, &limits);
        assert_eq!((to(50), to(51), to(33), to(25)), (Some(2.0), Some(2.0), Some(3.0), Some(4.0)));
        assert_eq!(
            (to(100), to(90), to(70), to(40), to(3), to(0)),
            (None, None, None, None, None, None)
        );
        assert_eq!(ratio((0..50).filter(|f| f % 2 == 0), 100, &limits), None, "gaps all over");
        assert_eq!(ratio(50..100, 100, &limits), None, "it began late");
    }
}

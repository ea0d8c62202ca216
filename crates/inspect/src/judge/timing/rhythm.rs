//! The rhythm of frames: a camera whose frames come at a lower rate than the recording's leaves out
//! the same share of them throughout. Dropped frames come by chance, or leave rates that no camera
//! has.

use crate::thresholds::TimingThresholds;

/// Frame rates at which cameras record [1/s].
const USUAL_FPS: [f64; 9] = [6.0, 10.0, 12.5, 15.0, 20.0, 24.0, 25.0, 50.0, 60.0];
/// Most frames of a recording from one of a camera to the next.
const LONGEST_STEP: u32 = 12;
/// Times by which a camera's frames may lie beside the recording's [frames].
const PHASES: [f64; 3] = [0.0, 0.25, -0.25];

/// Even steps through the frames of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rhythm {
    /// Frames per second.
    pub(super) fps: f64,
    /// Frames of the recording from one frame of the camera to the next; more than 1.
    step: f64,
    /// The camera's first frame, and its own time there [frames].
    first: usize,
    phase: f64,
}

impl Rhythm {
    /// The rhythm in which frames are there, if they keep to one that is slower than the recording's:
    /// every second, third, ... frame, or a rate that cameras have.
    pub(super) fn of(there: &[bool], fps: f64, limits: &TimingThresholds) -> Option<Self> {
        let frames: Vec<usize> = (0..there.len()).filter(|f| there[*f]).collect();
        let (first, last) = (*frames.first()?, *frames.last()?);
        if frames.len() < limits.min_rhythm_frames || !(fps.is_finite() && fps > 0.0) {
            return None;
        }
        // What is missing before or after the stream is missing for another reason.
        let is_whole =
            |step: f64| (first as f64) < step && ((there.len() - 1 - last) as f64) < step + 1.0;
        // Frames that are missing or too many, if they are few.
        let misses = |rhythm: Self| {
            let due: Vec<usize> = (first..there.len()).filter(|f| rhythm.is_due(*f)).collect();
            let met = due.iter().filter(|f| there[**f]).count();
            let outside = frames.len() - met;
            let is_met = outside as f64 <= limits.max_off_beat_share * frames.len() as f64
                && met as f64 >= limits.min_kept_share * due.len() as f64;
            is_met.then_some((outside + due.len() - met, rhythm))
        };
        let even = (2..=LONGEST_STEP).map(f64::from);
        let odd = USUAL_FPS.into_iter().map(|rate| fps / rate).filter(|step| *step > 1.05);
        let rhythms = even
            .chain(odd)
            .filter(|step| is_whole(*step))
            .flat_map(|step| PHASES.map(|phase| Self { fps: fps / step, step, first, phase }));
        let best = rhythms.filter_map(misses).min_by_key(|(misses, _)| *misses);
        best.map(|(_, rhythm)| rhythm)
    }

    /// The rhythm of a camera whose rate the recording declares, and whose frames may be few.
    pub(super) fn declared(there: &[bool], fps: f64, own: f64) -> Option<Self> {
        let step = fps / own;
        let first = there.iter().position(|there| *there)?;
        (step > 1.0 && step.is_finite()).then_some(Self { fps: own, step, first, phase: 0.0 })
    }

    /// True if the camera gives a frame for this frame of the recording.
    pub(super) fn is_due(&self, frame: usize) -> bool {
        let Some(since) = frame.checked_sub(self.first) else { return false };
        // The frame nearest to one of the camera's.
        let nearest = ((since as f64 - self.phase) / self.step).round();
        (nearest * self.step + self.phase).round() == since as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rhythm(fps: f64, there: impl Fn(usize) -> bool) -> Option<f64> {
        let there: Vec<bool> = (0..60).map(there).collect();
        Rhythm::of(&there, fps, &TimingThresholds::default()).map(|rhythm| rhythm.fps)
    }

    #[test]
    fn a_declared_rate_needs_no_evidence() {
        let there = [false, true, false, false, false, true];
        let rhythm = Rhythm::declared(&there, 30.0, 15.0).unwrap();
        let due: Vec<usize> = (0..6).filter(|f| rhythm.is_due(*f)).collect();
        assert_eq!(due, [1, 3, 5]);
        assert_eq!(Rhythm::declared(&there, 30.0, 30.0), None);
        assert_eq!(Rhythm::declared(&[false; 6], 30.0, 15.0), None);
    }

    #[test]
    fn a_slower_camera_is_told_from_one_that_drops_frames() {
        assert_eq!(rhythm(30.0, |f| f % 2 == 0), Some(15.0));
        assert_eq!(rhythm(30.0, |f| f % 2 == 1), Some(15.0));
        assert_eq!(rhythm(30.0, |f| f % 5 == 0), Some(6.0));
        assert_eq!(rhythm(60.0, |f| f % 2 == 0), Some(30.0));
        // Two of three, at the frames nearest to its own.
        assert_eq!(rhythm(30.0, |f| f % 3 != 1), Some(20.0));
        assert_eq!(rhythm(30.0, |f| f % 3 != 2), Some(20.0));
        assert_eq!(rhythm(29.97, |f| f % 2 == 0), Some(29.97 / 2.0));
        // A slower camera drops frames, too.
        assert_eq!(rhythm(30.0, |f| f % 2 == 0 && f % 20 != 8), Some(15.0));
        // All frames, a quarter dropped, half of them by chance, the second half missing.
        assert_eq!(rhythm(30.0, |_| true), None);
        assert_eq!(rhythm(30.0, |f| f % 4 != 2), None);
        assert_eq!(rhythm(30.0, |f| f * f % 7 < 3), None);
        assert_eq!(rhythm(30.0, |f| f < 30), None);
        assert_eq!(rhythm(30.0, |f| f >= 12), None);
    }
}

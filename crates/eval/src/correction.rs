//! Predictions from corrected states: the running simulation is corrected by the observation of a
//! frame, and perhaps of frames before it, and the frames after it are predicted from there, beside
//! the prediction that continues uncorrected. No later frame is used.

mod follow;
mod run;

use std::sync::Arc;

use bendtwin_core::{CancelToken, Capture, Sequence, Twin, quality::ErrorSummary};
use bendtwin_engine::{Backend, Model};
use bendtwin_register::CorrectOptions;

use self::{follow::follow, run::Run};
use crate::{Error, metrics::ErrorSums, trajectory::check};

/// Frames and observations of a comparison.
#[derive(Clone, Debug)]
pub struct CorrectionPlan {
    /// Frames from which the motion is predicted; the state is corrected in each.
    pub frames: Vec<usize>,
    /// Number of frames predicted from each.
    pub horizon: usize,
    /// Shares of the visible points that are observed, each a separate comparison, 0..=1.
    pub shares: Vec<f64>,
    /// Frames between corrections: in the frame predicted from, and in frames before it at this
    /// distance, from the start on; 0 corrects in the one frame alone.
    pub every: usize,
    /// Frames back to which the velocities of points are measured; 0 observes none.
    pub velocity_frames: usize,
    /// Share of each correction that the rest shape takes, 0..=1, where the points are far beyond
    /// their noise ([`bendtwin_register::Corrected::beyond_noise`]); 0 leaves the twin unchanged.
    pub carry: f64,
    /// Options of the corrections.
    pub options: CorrectOptions,
}

/// Errors over the frames after a correction, means over frames and sequences.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CorrectionScore {
    /// Frame at which the state was corrected.
    pub frame: usize,
    /// Share of the visible points that were observed.
    pub share: f64,
    /// Number of them, mean over sequences.
    pub points: f64,
    /// Sequences that were compared.
    pub sequences: usize,
    /// Corrections that were refused; the simulation continues uncorrected there.
    pub refused: usize,
    /// Median distance of the observed points before and after the correction in that frame [mm],
    /// mean over sequences.
    pub residual_mm: [f64; 2],
    /// Errors without correction. Tracks are measured against the place between nodes that they had
    /// in the start frame.
    pub open_loop: ErrorSummary,
    /// Errors without correction, less those in the corrected frame; tracks alone.
    pub last_residual: ErrorSummary,
    /// Errors from the corrected state.
    pub corrected: ErrorSummary,
}

/// Compares predictions from corrected states with uncorrected ones, on the sequences that are held
/// out of fitting if there are any.
///
/// # Errors
/// If the twin does not fit the capture, if a frame has no frames before or after it, on
/// cancellation, or if the backend fails.
pub fn corrections(
    backend: &dyn Backend,
    twin: &Twin,
    capture: &Capture,
    plan: &CorrectionPlan,
    cancel: &CancelToken,
) -> Result<Vec<CorrectionScore>, Error> {
    check(twin, capture)?;
    let loaded = backend.load(Arc::new(Model::from(twin)))?;
    let held_out = capture.sequences.iter().any(Sequence::is_held_out);
    let chosen: Vec<&Sequence> =
        capture.sequences.iter().filter(|s| s.is_held_out() == held_out).collect();
    let mut scores = Vec::new();
    for &frame in &plan.frames {
        let mut runs = Vec::with_capacity(chosen.len());
        for &sequence in &chosen {
            if frame <= sequence.start_frame() || frame + 1 >= sequence.frame_count {
                return Err(Error::Mismatch(format!(
                    "sequence `{}` has frames {} to {}, and none to predict after frame {frame}",
                    sequence.name,
                    sequence.start_frame(),
                    sequence.frame_count - 1
                )));
            }
            runs.push(Run::new(backend, &loaded, capture, sequence, frame, plan.horizon, cancel)?);
        }
        for &share in &plan.shares {
            scores.push(compare(backend, &runs, plan, share, cancel)?);
        }
    }
    Ok(scores)
}

fn compare(
    backend: &dyn Backend,
    runs: &[Run<'_>],
    plan: &CorrectionPlan,
    share: f64,
    cancel: &CancelToken,
) -> Result<CorrectionScore, Error> {
    let mut score = CorrectionScore { share, sequences: runs.len(), ..CorrectionScore::default() };
    let mut sums = [(); 3].map(|()| ErrorSums::default());
    let each = 1.0 / runs.len().max(1) as f64;
    for run in runs {
        score.frame = run.frame;
        let followed = follow(backend, run, plan, share, cancel)?;
        score.points += each * followed.points as f64;
        score.refused += followed.refused;
        for (mean, one) in score.residual_mm.iter_mut().zip(followed.residual_mm) {
            *mean += each * one;
        }
        let predicted = &followed.predicted;
        let frames = run.after.len();
        for (sum, (nodes, held)) in
            sums.iter_mut().zip([(&run.after, false), (&run.after, true), (predicted, false)])
        {
            sum.add(&run.errors(nodes, held), frames);
        }
    }
    score.open_loop = sums[0].summary();
    score.last_residual = sums[1].summary();
    score.corrected = sums[2].summary();
    Ok(score)
}

#[cfg(test)]
mod tests;

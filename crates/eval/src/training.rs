//! Errors over training frames alone, for a fit that runs: those of the quality table, in the measure
//! that the twin will be judged by, without frames that the fit must not see.

use std::ops::Range;

use bendtwin_core::{
    Capture, Sequence, Twin,
    quality::{ErrorSummary, Measure},
};

use crate::{
    Trajectory,
    baselines::standing_still,
    metrics::{ErrorSums, Reference},
    surface::Surface,
};

/// Errors of predictions over training frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingErrors {
    /// The kind of error.
    pub measure: Measure,
    /// Over the training frames before those that are held back [m].
    pub error_m: f64,
    /// Over the training frames that are held back [m]; none without any.
    pub held_back_m: Option<f64>,
}

/// Errors of predictions that [`predict`](crate::predict) made, at the twin's skin. `held_back` gives
/// the number of frames at the end of a sequence's training frames that count apart; `None` if no
/// training frame shows anything.
pub fn training_errors(
    twin: &Twin,
    predictions: &[Trajectory],
    capture: &Capture,
    held_back: impl Fn(usize) -> usize,
) -> Option<TrainingErrors> {
    // The nearest points of all frames are searched only where nothing else is known.
    [false, true].into_iter().find_map(|searches| {
        let (mut kept, mut apart) = (ErrorSums::default(), ErrorSums::default());
        let surface = Surface::of_skin(&twin.graph, &twin.skin);
        for (index, (sequence, prediction)) in capture.sequences.iter().zip(predictions).enumerate()
        {
            let first = sequence.start_frame() + 1;
            let end = sequence.train_frame_count.max(first);
            let between = end.saturating_sub(held_back(index)).max(first);
            if end == first {
                continue;
            }
            let placed = prediction.at_skin(&twin.skin);
            let Some(start) = placed.at(sequence.start_frame()) else { continue };
            let reference = Reference::new(capture, sequence, &surface, start);
            let errors = |frames: Range<usize>| -> Vec<ErrorSummary> {
                let measure = |frame, at| match searches {
                    true => reference.measure(frame, at),
                    false => reference.measure_pairs(frame, at),
                };
                frames.filter_map(|f| Some(measure(f, placed.at(f)?))).collect()
            };
            let own = errors(first..between);
            kept.add(&own, divisor(sequence, own.len()));
            let own = errors(between..end);
            apart.add(&own, own.len());
        }
        let (measure, error_m) = kept.summary().headline()?;
        let held_back_m = measure.of(&apart.summary());
        Some(TrainingErrors { measure, error_m, held_back_m })
    })
}

/// Frames by which the sums of motion capture are divided: all of a sequence that is not split, as in
/// the quality table.
fn divisor(sequence: &Sequence, frames: usize) -> usize {
    let all = sequence.start_frame() + 1 + frames == sequence.frame_count;
    if all { sequence.frame_count } else { frames }
}

/// Predictions of the object standing still from where other predictions start, by sequence.
pub fn stand_still(twin: &Twin, predictions: &[Trajectory], capture: &Capture) -> Vec<Trajectory> {
    let still = |(sequence, prediction): (&Sequence, &Trajectory)| {
        let start = &prediction.positions[..prediction.node_count];
        standing_still(&twin.graph, sequence, start)
    };
    capture.sequences.iter().zip(predictions).map(still).collect()
}

#[cfg(test)]
mod tests;

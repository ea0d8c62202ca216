//! Previews of what a fit has so far, for people who watch it: the motion that the best parameters
//! predict, and its error in metres.
//!
//! A preview simulates the reference once, beside the work of the fit, whose result does not depend on
//! it. Previews take at most [`SHARE`] of the time of a fit: after the first one the next waits until
//! that has passed, so they are seldom where a simulation takes long.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use bendtwin_core::{Capture, Preview, PreviewErrors, Sequence, Stage, Twin};
use bendtwin_eval::{TrainingErrors, Trajectory, predict, stand_still, training_errors};

use super::Run;
use crate::refine::{OptimizerRun, Refinement};

/// Largest share of the time of a fit that its previews take.
const SHARE: f64 = 0.05;
/// Least time between two previews.
const INTERVAL: Duration = Duration::from_secs(1);

/// The previews that were made.
pub(super) struct Previews {
    are_wanted: bool,
    /// Largest share of the time that they take, and least time between two.
    share: f64,
    interval: Duration,
    began: Instant,
    /// Time that all of them took, and that the last one took.
    spent: Duration,
    last: Option<(Instant, Duration)>,
    /// What the last one was of: the stage, whether frames were held back, and the loss.
    shown: Option<(Stage, bool, f64)>,
    /// Error of standing still [m], and whether frames were held back from it.
    baseline: Option<(bool, f64)>,
}

impl Previews {
    pub(super) fn new(are_wanted: bool) -> Self {
        let (began, spent) = (Instant::now(), Duration::ZERO);
        let (last, shown, baseline) = (None, None, None);
        let (share, interval) = (SHARE, INTERVAL);
        Self { are_wanted, share, interval, began, spent, last, shown, baseline }
    }

    /// True if there is time for one now.
    fn is_due(&self, is_last: bool) -> bool {
        let Some((ended, took)) = self.last else { return self.are_wanted };
        let spent = (self.spent + took).as_secs_f64();
        let may = spent <= self.share * self.began.elapsed().as_secs_f64();
        self.are_wanted && may && (is_last || ended.elapsed() >= self.interval)
    }

    /// True if parameters of this loss were not shown before.
    fn is_new(&self, stage: Stage, holds_back: bool, loss: f64) -> bool {
        let before = self.shown.filter(|(s, h, _)| (*s, *h) == (stage, holds_back));
        loss.is_finite() && before.is_none_or(|(.., before)| loss < before)
    }
}

/// Parameters of a model to be shown.
struct Subject {
    twin: Twin,
    stage: Stage,
    /// Name of the model.
    variant: String,
    iteration: u32,
    loss: f64,
}

impl Run<'_> {
    /// A preview of the best candidate of the search of the twin's own model, if one is due.
    pub(super) fn preview_search(&mut self) -> Option<Arc<Preview>> {
        if !self.previews.is_due(false) {
            return None;
        }
        let bending = self.models.first()?.bending;
        let own = self.models.iter().filter(|model| model.bending == bending);
        let searched = own.filter_map(|model| Some((model, model.search()?)));
        let best = searched.filter_map(|(model, s)| Some((model, s, s.best()?.loss)));
        let (model, search, loss) = best.min_by(|a, b| a.2.total_cmp(&b.2))?;
        if !self.previews.is_new(Stage::Search, self.holds_back(), loss) {
            return None;
        }
        let began = Instant::now();
        let subject = Subject {
            twin: model.searched(self.job, self.current_task())?,
            stage: Stage::Search,
            variant: model.name.clone(),
            iteration: search.generation() as u32,
            loss,
        };
        self.preview(subject, began)
    }

    /// A preview of the best parameters of the twin's own model in the refinement, if one is due.
    pub(super) fn preview_refinement(
        &mut self,
        refinement: &Refinement<'_>,
        iteration: u32,
    ) -> Option<Arc<Preview>> {
        let is_last = refinement.runs.iter().all(|run| run.state.is_done());
        if !self.previews.is_due(is_last) {
            return None;
        }
        let bending = self.models.first()?.bending;
        let is_own = |run: &&OptimizerRun<'_>| self.models[run.model].bending == bending;
        let loss = |run: &OptimizerRun<'_>| run.state.best.loss;
        let own = refinement.runs.iter().filter(is_own);
        let run = own.min_by(|a, b| loss(a).total_cmp(&loss(b)))?;
        if !self.previews.is_new(Stage::Refine, self.holds_back(), loss(run)) {
            return None;
        }
        let (began, model) = (Instant::now(), &self.models[run.model]);
        let subject = Subject {
            twin: self.twin_of(model, self.current_task(), run).ok()?,
            stage: Stage::Refine,
            variant: model.name.clone(),
            iteration,
            loss: loss(run),
        };
        self.preview(subject, began)
    }

    /// True while training frames are held back.
    fn holds_back(&self) -> bool {
        self.validation.is_some() && self.chosen.is_empty()
    }

    /// Frames that are held back at the end of the training frames of a sequence of the reference.
    fn held_back(&self, sequence: &Sequence) -> usize {
        let validation = self.validation.filter(|_| self.holds_back());
        let pairs = validation.map(|v| self.task.training.iter().zip(&v.shorter.training));
        let own = |source: &Sequence| std::ptr::eq(source, sequence);
        let of = pairs.and_then(|mut pairs| pairs.find(|(all, _)| own(all.source.sequence)));
        of.map_or(0, |(all, kept)| all.frames - kept.frames)
    }

    /// The preview of a model. One that cannot be made is left out: the fit reports what is wrong.
    fn preview(&mut self, subject: Subject, began: Instant) -> Option<Arc<Preview>> {
        let preview = self.measure(&subject);
        let took = began.elapsed();
        self.previews.spent += took;
        self.previews.last = Some((Instant::now(), took));
        self.previews.shown = Some((subject.stage, self.holds_back(), subject.loss));
        preview.map(Arc::new)
    }

    fn measure(&mut self, subject: &Subject) -> Option<Preview> {
        let (twin, capture) = (&subject.twin, self.job.capture);
        let predictions = predict(&*self.job.backend, twin, capture, self.cancel).ok()?;
        let held_back = |index: usize| self.held_back(&capture.sequences[index]);
        let errors = training_errors(twin, &predictions, capture, held_back)?;
        let TrainingErrors { measure, error_m, held_back_m } = errors;
        let baseline_m = match self.previews.baseline {
            Some((holds_back, baseline_m)) if holds_back == self.holds_back() => baseline_m,
            _ => {
                let still = stand_still(twin, &predictions, capture);
                training_errors(twin, &still, capture, held_back)?.error_m
            }
        };
        self.previews.baseline = Some((self.holds_back(), baseline_m));
        let errors = PreviewErrors { measure, error_m, held_back_m, baseline_m };
        let (sequence, frames, positions) = picture(twin, &predictions, capture)?;
        let (stage, variant) = (subject.stage, subject.variant.clone());
        let iteration = subject.iteration;
        let all = positions.iter().flatten().all(|x| x.is_finite());
        (all && error_m.is_finite()).then_some(Preview {
            stage,
            variant,
            iteration,
            sequence,
            frames,
            positions,
            errors,
        })
    }
}

/// The first sequence with training frames: its index, the frames that are shown, and points of the
/// skin in these [m], shape [F, P, 3].
fn picture(
    twin: &Twin,
    predictions: &[Trajectory],
    capture: &Capture,
) -> Option<(u32, Vec<u32>, Vec<[f32; 3]>)> {
    let index = capture.sequences.iter().position(|s| s.train_frame_count > s.start_frame() + 1)?;
    let (sequence, prediction) = (&capture.sequences[index], predictions.get(index)?);
    let start = sequence.start_frame();
    let shown = spread(sequence.frame_count - start, Preview::MOST_FRAMES);
    let frames: Vec<u32> = shown.iter().map(|frame| (start + frame) as u32).collect();
    let points = spread(twin.skin.len(), Preview::MOST_POINTS);
    let mut positions = Vec::with_capacity(frames.len() * points.len());
    for frame in &frames {
        let placed = twin.skin.positions(prediction.at(*frame as usize)?);
        positions.extend(points.iter().map(|&point| placed[point]));
    }
    (!positions.is_empty()).then_some((index as u32, frames, positions))
}

/// At most `most` of `count` numbers from 0, evenly spread, the first and the last among them.
fn spread(count: usize, most: usize) -> Vec<usize> {
    let taken = count.min(most);
    let steps = taken.saturating_sub(1).max(1);
    (0..taken).map(|i| i * (count - 1) / steps).collect()
}

#[cfg(test)]
mod tests;

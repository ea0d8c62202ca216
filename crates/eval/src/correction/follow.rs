//! A simulation that is corrected again and again, up to the frame that is predicted from.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Point};
use bendtwin_engine::{Backend, Loaded, model::State};
use bendtwin_register::{Around, Corrected, Error as Refused, carried, correct};

use super::{
    CorrectionPlan,
    run::{Run, roll},
};
use crate::Error;

/// A prediction from a corrected state.
#[derive(Debug, Default)]
pub(super) struct Prediction {
    /// Node positions of the predicted frames.
    pub(super) predicted: Vec<Vec<Point>>,
    /// Points observed in the last corrected frame.
    pub(super) points: usize,
    /// Median distance of the observed points before and after the last correction [mm].
    pub(super) residual_mm: [f64; 2],
    /// Corrections that were refused.
    pub(super) refused: usize,
}

/// The running simulation, and where its nodes were.
struct Simulation {
    loaded: Loaded,
    state: Arc<State>,
    frame: usize,
    /// Node positions of the frames from the start on, after their corrections.
    rows: Vec<Vec<Point>>,
}

/// Corrects a simulation in the frames of a plan and predicts from the last of them.
pub(super) fn follow(
    backend: &dyn Backend,
    run: &Run<'_>,
    plan: &CorrectionPlan,
    share: f64,
    cancel: &CancelToken,
) -> Result<Prediction, Error> {
    let mut running = Simulation {
        loaded: run.loaded.clone(),
        state: Arc::clone(&run.start),
        frame: run.sequence.start_frame(),
        rows: vec![run.start.positions.clone()],
    };
    let mut followed = Prediction::default();
    for frame in frames(running.frame, run.frame, plan.every) {
        let span = [running.frame, frame];
        let from = &running.state;
        let (rows, state) = roll(backend, &running.loaded, run.sequence, from, span, cancel)?;
        running.rows.extend(rows);
        running.frame = frame;
        running.state = Arc::new(state);
        let seen = run.observe(plan, share, frame, &running.state, &running.rows)?;
        let (model, controls) = (running.loaded.model(), run.sequence.controls_at(frame));
        followed.points = seen.points.len();
        match correct(
            model,
            &running.state,
            controls,
            &Around::default(),
            &seen,
            &plan.options,
            cancel,
        ) {
            Ok(corrected) => {
                followed.residual_mm = [corrected.before.median_mm, corrected.after.median_mm];
                running.take(backend, run, plan, corrected)?;
            }
            Err(Refused::NotExplained { .. }) => followed.refused += 1,
            Err(other) => return Err(other.into()),
        }
    }
    let span = [run.frame, run.frame + run.after.len()];
    let from = &running.state;
    followed.predicted = roll(backend, &running.loaded, run.sequence, from, span, cancel)?.0;
    Ok(followed)
}

impl Simulation {
    /// Continues from a corrected state, with the part of the correction that lasts.
    fn take(
        &mut self,
        backend: &dyn Backend,
        run: &Run<'_>,
        plan: &CorrectionPlan,
        corrected: Corrected,
    ) -> Result<(), Error> {
        let share = plan.carry * corrected.beyond_noise(plan.options.noise_m);
        if share > 0.0 {
            let controls = run.sequence.controls_at(self.frame);
            let (model, own) = (self.loaded.model(), &run.loaded.model().params);
            let params = carried(model, own, &self.state, &corrected.state, controls, share);
            self.loaded = backend.with_params(&self.loaded, params)?;
        }
        self.state = Arc::new(corrected.state);
        if let Some(row) = self.rows.last_mut() {
            row.clone_from(&self.state.positions);
        }
        Ok(())
    }
}

/// Frames after `first` in which the simulation is corrected, `last` among them.
fn frames(first: usize, last: usize, every: usize) -> Vec<usize> {
    let step = if every == 0 { last - first } else { every };
    let mut frames: Vec<usize> = (first + 1..=last).rev().step_by(step).collect();
    frames.reverse();
    frames
}

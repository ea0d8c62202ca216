//! Controls and objective of each window of the training frames, built once: a backend that caches
//! what it derives from them finds the same ones in every pass.

use std::{collections::HashMap, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{Loaded, Objective, backend::Instance, model::State};

use crate::task::Task;

/// Frames of a training sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Window {
    /// Index of the sequence in the task.
    pub(crate) sequence: usize,
    /// First frame after the sequence's start.
    pub(crate) first: usize,
    /// Number of frames.
    pub(crate) count: usize,
}

/// Cache of the controls and objectives of windows.
#[derive(Default)]
pub(crate) struct Windows {
    made: HashMap<Window, (Arc<Vec<Point>>, Objective)>,
}

impl Windows {
    /// A rollout of a window from a state at its start.
    pub(crate) fn instance(
        &mut self,
        task: &Task<'_>,
        model: &Loaded,
        window: &Window,
        initial: Arc<State>,
    ) -> Instance {
        let training = &task.training[window.sequence];
        let (controls, objective) = self.made.entry(*window).or_insert_with(|| {
            if window.count == training.frames {
                (training.controls.clone(), training.objective.clone())
            } else {
                let controls = training.controls_of(window.first, window.count);
                (Arc::new(controls), training.window(window.first, window.count))
            }
        });
        Instance {
            model: model.clone(),
            initial,
            controls: controls.clone(),
            frames: window.count,
            objective: objective.clone(),
            world: Arc::default(),
            motion: Arc::default(),
        }
    }
}

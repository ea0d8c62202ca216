//! Controls, objective and surroundings of each window of the training frames, built once: a backend that caches
//! what it derives from them finds the same ones in every pass.

use std::{collections::HashMap, sync::Arc};

use bendtwin_core::Point;
use bendtwin_engine::{Loaded, Motion, Objective, backend::Instance, model::State};

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

/// Controls, objective and surroundings of a window.
type WindowData = (Arc<Vec<Point>>, Objective, Arc<Motion>);

/// Cache of the controls, objectives and surroundings of windows.
#[derive(Default)]
pub(crate) struct Windows {
    made: HashMap<Window, WindowData>,
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
        let source = &training.source;
        let (controls, objective, motion) = self.made.entry(*window).or_insert_with(|| {
            if window.count == training.frames {
                (training.controls.clone(), training.objective.clone(), training.motion.clone())
            } else {
                let controls = source.controls(window.first, window.count);
                let objective = training.window(window.first, window.count);
                (Arc::new(controls), objective, Arc::new(source.motion_of(window.count)))
            }
        });
        Instance {
            model: model.clone(),
            initial,
            controls: controls.clone(),
            frames: window.count,
            objective: objective.clone(),
            world: source.world.clone(),
            motion: motion.clone(),
        }
    }
}

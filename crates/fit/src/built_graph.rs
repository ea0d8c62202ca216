//! From a candidate to a model on the device: its graph (cached, since candidates often share one),
//! its substeps, its parameters.

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Environment, Graph, Params, Timing, capture::Subject, settings::Substeps,
};
use bendtwin_engine::{Backend, Loaded, Model, backend, enough_substeps, stable_substeps};
use bendtwin_graph::{Connectivity, MIN_REST_LENGTH_M, Notes, connect_with_notes, rest_geometry};
use rayon::prelude::*;

use crate::{Error, task::Task};

/// Number of cached graphs: as many as two generations of candidates need.
const CACHE_SIZE: usize = 32;

/// A graph with its rest geometry.
#[derive(Debug)]
pub(crate) struct BuiltGraph {
    pub(crate) graph: Arc<Graph>,
    pub(crate) rest_lengths_m: Vec<f32>,
    pub(crate) rest_angles_rad: Vec<f32>,
    pub(crate) notes: Notes,
}

impl BuiltGraph {
    /// Builds the graph of a connectivity.
    pub(crate) fn new(task: &Task<'_>, connectivity: &Connectivity) -> Self {
        let (mut graph, notes) = connect_with_notes(&task.sample, connectivity);
        let (mut rest_lengths_m, rest_angles_rad) = rest_geometry(&graph, &task.sample);
        if task.subject() == Subject::Cable {
            measure_lengths(task, &graph, &mut rest_lengths_m);
        }
        let control_rest = task.control_rest();
        task.others.attach(connectivity, control_rest, &mut graph, &mut rest_lengths_m);
        Self { graph: Arc::new(graph), rest_lengths_m, rest_angles_rad, notes }
    }
}

/// Graphs by connectivity; the least recently built are dropped first.
#[derive(Default)]
pub(crate) struct GraphCache {
    kept: Vec<(Connectivity, Arc<BuiltGraph>)>,
}

impl GraphCache {
    /// The graphs of these connectivities, in their order. Missing ones are built in parallel, each
    /// once.
    pub(crate) fn all(
        &mut self,
        task: &Task<'_>,
        wanted: &[Connectivity],
        cancel: &CancelToken,
    ) -> Result<Vec<Arc<BuiltGraph>>, backend::Error> {
        let mut missing: Vec<Connectivity> = Vec::new();
        for connectivity in wanted {
            let is_kept = self.kept.iter().any(|(c, _)| c == connectivity);
            if !is_kept && !missing.contains(connectivity) {
                missing.push(*connectivity);
            }
        }
        let make = |connectivity: Connectivity| {
            if cancel.is_cancelled() {
                return Err(backend::Error::Cancelled);
            }
            Ok((connectivity, Arc::new(BuiltGraph::new(task, &connectivity))))
        };
        let made = missing.into_par_iter().map(make).collect::<Result<Vec<_>, _>>()?;
        self.kept.extend(made);
        let find = |wanted: &Connectivity| self.kept.iter().find(|(c, _)| c == wanted);
        let found = wanted.iter().filter_map(find).map(|(_, built)| built.clone()).collect();
        self.kept.drain(..self.kept.len().saturating_sub(CACHE_SIZE));
        Ok(found)
    }
}

/// Sets the rest lengths of a cable's edges to their mean observed length over the training frames.
/// A cable hardly stretches, and the mean is more accurate than one measurement of the undeformed
/// cable.
fn measure_lengths(task: &Task<'_>, graph: &Graph, lengths_m: &mut [f32]) {
    let n = graph.node_count();
    let springs = graph.springs.iter().zip(lengths_m);
    for ([a, b], length) in springs.filter(|(s, _)| (s[1] as usize) < n) {
        let points = [a, b].map(|&e| graph.observed_points[e as usize] as usize);
        let (mut sum, mut count) = (0.0, 0_usize);
        for t in &task.training {
            let sequence = t.source.sequence;
            let first = sequence.start_frame();
            for frame in first..=first + t.frames {
                let (at, seen) = (sequence.points_at(frame), sequence.visible_at(frame));
                if points.iter().all(|&p| seen.get(p) == Some(&true)) {
                    let [p, q] = points.map(|p| at[p].map(f64::from));
                    let apart: f64 = p.iter().zip(q).map(|(x, y)| (x - y) * (x - y)).sum();
                    if apart.is_finite() {
                        sum += apart.sqrt();
                        count += 1;
                    }
                }
            }
        }
        if count > 0 {
            *length = ((sum / count as f64) as f32).max(MIN_REST_LENGTH_M);
        }
    }
}

/// The reason why a model cannot be simulated.
#[derive(Debug)]
pub(crate) enum LoadError {
    /// Needs this many substeps, more than the settings allow.
    TooStiff(u32),
    /// The backend failed.
    Backend(backend::Error),
}

impl From<backend::Error> for LoadError {
    fn from(error: backend::Error) -> Self {
        match error {
            backend::Error::Unstable { needed, .. } => Self::TooStiff(needed),
            other => Self::Backend(other),
        }
    }
}

impl From<LoadError> for Error {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::TooStiff(needed) => {
                Self::NothingStable(format!("the found parameters need {needed} substeps a frame"))
            }
            LoadError::Backend(error) => Self::Backend(error),
        }
    }
}

/// A model of a graph with these parameters and as many substeps as it needs.
pub(crate) fn build_model(
    task: &Task<'_>,
    graph: &Arc<Graph>,
    params: Params,
    environment: Environment,
) -> Result<Model, LoadError> {
    let mut model = Model {
        graph: graph.clone(),
        skin: task.skin.clone(),
        params,
        environment,
        timing: Timing { fps: task.capture.fps, substeps: 1 },
        control_velocity: task.settings.control_velocity,
    };
    model.timing.substeps = substeps(&model, task.settings.substeps)?;
    Ok(model)
}

/// Substeps that a model should have.
pub(crate) fn substeps(model: &Model, setting: Substeps) -> Result<u32, LoadError> {
    match setting {
        Substeps::Fixed(n) => match enough_substeps(model, n) {
            Ok(()) => Ok(n),
            Err(needs) => Err(LoadError::TooStiff(needs.needed)),
        },
        Substeps::Auto { safety, .. } => match stable_substeps(model).needed {
            // The margin is cut at the limit; stability itself is required.
            needed if needed <= setting.most() => {
                Ok(((f64::from(needed) * safety).ceil() as u32).clamp(1, setting.most()))
            }
            needed => Err(LoadError::TooStiff(needed)),
        },
    }
}

/// Loads a model. One that the backend finds unstable is refused like one that needs too many
/// substeps.
pub(crate) fn load(backend: &dyn Backend, model: Model) -> Result<Loaded, LoadError> {
    Ok(backend.load(Arc::new(model))?)
}

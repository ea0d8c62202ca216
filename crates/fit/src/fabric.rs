//! From a candidate to a model on the device: its graph (kept, since candidates often share one), its
//! substeps, its parameters.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Environment, Graph, Params, Timing, settings::Substeps};
use bendtwin_engine::{Backend, Loaded, Model, backend, enough_substeps, stable_substeps};
use bendtwin_graph::{Connectivity, MIN_REST_LENGTH_M, Notes, connect_with_notes, rest_geometry};
use rayon::prelude::*;

use crate::task::Task;

/// Graphs kept at a time: as many as two generations of candidates need.
const KEPT: usize = 32;

/// A graph with its rest geometry.
#[derive(Debug)]
pub(crate) struct Fabric {
    pub(crate) graph: Arc<Graph>,
    pub(crate) rest_lengths_m: Vec<f32>,
    pub(crate) rest_angles_rad: Vec<f32>,
    pub(crate) notes: Notes,
}

impl Fabric {
    /// The graph of a connectivity.
    pub(crate) fn new(task: &Task<'_>, connectivity: &Connectivity) -> Self {
        let (graph, notes) = connect_with_notes(&task.sample, connectivity);
        let (mut rest_lengths_m, rest_angles_rad) = rest_geometry(&graph, &task.sample);
        if task.sample.edges.is_some() {
            measure_lengths(task, &graph, &mut rest_lengths_m);
        }
        Self { graph: Arc::new(graph), rest_lengths_m, rest_angles_rad, notes }
    }
}

/// Graphs by connectivity, the least recently made forgotten first.
#[derive(Default)]
pub(crate) struct Fabrics {
    kept: Vec<(Connectivity, Arc<Fabric>)>,
}

impl Fabrics {
    /// The fabrics of these connectivities, in their order. Those that are not kept yet are made side by
    /// side, each once.
    pub(crate) fn all(
        &mut self,
        task: &Task<'_>,
        wanted: &[Connectivity],
        cancel: &CancelToken,
    ) -> Result<Vec<Arc<Fabric>>, backend::Error> {
        let mut missing: Vec<Connectivity> = Vec::new();
        for connectivity in wanted {
            let is_kept = self.kept.iter().any(|(c, _)| c == connectivity);
            if !is_kept && !missing.contains(connectivity) {
                missing.push(*connectivity);
            }
        }
        let make = |connectivity: Connectivity| match cancel.is_cancelled() {
            true => Err(backend::Error::Cancelled),
            false => Ok((connectivity, Arc::new(Fabric::new(task, &connectivity)))),
        };
        let made = missing.into_par_iter().map(make).collect::<Result<Vec<_>, _>>()?;
        self.kept.extend(made);
        let find = |wanted: &Connectivity| self.kept.iter().find(|(c, _)| c == wanted);
        let found = wanted.iter().filter_map(find).map(|(_, fabric)| fabric.clone()).collect();
        self.kept.drain(..self.kept.len().saturating_sub(KEPT));
        Ok(found)
    }
}

/// A cable hardly stretches: its edges are as long as they were seen to be, on average over the
/// training frames, which knows more than one measurement of the undeformed cable.
fn measure_lengths(task: &Task<'_>, graph: &Graph, lengths_m: &mut [f32]) {
    let n = graph.node_count();
    let springs = graph.springs.iter().zip(lengths_m);
    for ([a, b], length) in springs.filter(|(s, _)| (s[1] as usize) < n) {
        let points = [a, b].map(|&e| graph.observed_points[e as usize] as usize);
        let (mut sum, mut count) = (0.0, 0_usize);
        for t in &task.training {
            let first = t.sequence.start_frame();
            for frame in first..=first + t.frames {
                let (at, seen) = (t.sequence.points_at(frame), t.sequence.visible_at(frame));
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

/// Why a candidate cannot be simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// It needs so many substeps, more than the settings allow.
    TooStiff(u32),
}

/// The model of a graph with parameters, with as many substeps as it needs.
pub(crate) fn model(
    task: &Task<'_>,
    graph: &Arc<Graph>,
    params: Params,
    environment: Environment,
) -> Result<Model, Refusal> {
    let mut model = Model {
        graph: graph.clone(),
        params,
        environment,
        timing: Timing { fps: task.capture.fps, substeps: 1 },
        control_velocity: task.settings.control_velocity,
    };
    model.timing.substeps = substeps(&model, task.settings.substeps)?;
    Ok(model)
}

/// Substeps that a model should have.
pub(crate) fn substeps(model: &Model, setting: Substeps) -> Result<u32, Refusal> {
    match setting {
        Substeps::Fixed(n) => match enough_substeps(model, n) {
            Ok(()) => Ok(n),
            Err(needs) => Err(Refusal::TooStiff(needs.needed)),
        },
        Substeps::Auto { safety, max } => match stable_substeps(model).needed {
            // Up to the limit the margin is a wish; the stability itself is not.
            needed if needed <= max => {
                Ok(((f64::from(needed) * safety).ceil() as u32).clamp(1, max))
            }
            needed => Err(Refusal::TooStiff(needed)),
        },
    }
}

/// Loads a model; one that the backend finds unstable is refused like one that needs too many substeps.
pub(crate) fn load(
    backend: &dyn Backend,
    model: Model,
) -> Result<Result<Loaded, Refusal>, backend::Error> {
    match backend.load(Arc::new(model)) {
        Ok(loaded) => Ok(Ok(loaded)),
        Err(backend::Error::Unstable { needed, .. }) => Ok(Err(Refusal::TooStiff(needed))),
        Err(e) => Err(e),
    }
}

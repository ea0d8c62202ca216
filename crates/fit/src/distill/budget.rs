//! A budget of time selects the size of a planner's twin on the device where plans are made.

use std::{sync::Arc, time::Instant};

use bendtwin_core::{CancelToken, Twin};
use bendtwin_engine::{
    Backend, Model, Objective, PointLoss, PointSet, Term, backend::Instance, model::State,
    objective::WeightedTerm,
};

use super::thin::{softened, thin};
use crate::Error;

/// Nodes and substeps that are tried, the finest first.
const SIZES: [(usize, u32); 6] = [(120, 60), (120, 40), (100, 40), (80, 32), (80, 24), (60, 16)];
/// Share of the time of a plan that its rollouts may take: the rest is for the planner and the wire.
const SHARE: f64 = 0.8;
/// Calls that are timed; the best counts.
const REPEATS: usize = 3;

/// Rollouts of a plan, and how often one is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Rollouts of a plan that run together.
    pub samples: usize,
    /// Frames of each.
    pub frames: usize,
    /// Plans a second.
    pub per_second: f64,
}

/// The size that a budget selects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Number of nodes.
    pub nodes: usize,
    /// Substeps per frame.
    pub substeps: u32,
    /// Time of the rollouts of a plan, as measured [s].
    pub measured_s: f64,
    /// False if not even the smallest size is fast enough.
    pub fits: bool,
}

impl Budget {
    /// Measures short rollouts on a device, and selects the finest planner's twin of a twin whose
    /// rollouts take no more than their share of the time; the smallest one if none does.
    ///
    /// # Errors
    /// If the backend fails, or on cancellation.
    pub fn choose(
        &self,
        twin: &Twin,
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Choice, Error> {
        let allowed_s = SHARE / self.per_second;
        let mut last = None;
        for (nodes, substeps) in SIZES {
            let small = softened(&thin(twin, nodes), 1.0, substeps);
            let measured_s = self.time(&small.twin, backend, cancel)?;
            let substeps = small.twin.timing.substeps;
            let choice = Choice { nodes, substeps, measured_s, fits: measured_s <= allowed_s };
            if choice.fits {
                return Ok(choice);
            }
            last = Some(choice);
        }
        Ok(last.unwrap_or(Choice { nodes: 60, substeps: 16, measured_s: 0.0, fits: false }))
    }

    /// Time of the rollouts of a plan [s]: from rest, held still, with a cost in the last frame.
    pub(super) fn time(
        &self,
        twin: &Twin,
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<f64, Error> {
        let model = backend.load(Arc::new(Model::from(twin)))?;
        let graph = &twin.graph;
        let controls = std::iter::repeat_n(&graph.control_rest, self.frames + 1);
        let term = Term::Track {
            of: PointSet::Nodes,
            points: (0..graph.node_count() as u32).collect(),
            targets: graph.rest_positions.clone(),
            loss: PointLoss::Distance,
        };
        let term = WeightedTerm { frame: self.frames, weight: 1.0, group: 0, term };
        let instance = Instance {
            model,
            initial: Arc::new(State::rest(graph)),
            controls: Arc::new(controls.flatten().copied().collect()),
            frames: self.frames,
            objective: Objective { groups: vec!["distance".into()], terms: Arc::new(vec![term]) },
            world: Arc::default(),
            motion: Arc::default(),
        };
        let batch = vec![instance; self.samples];
        let mut best_s = f64::INFINITY;
        for _ in 0..=REPEATS {
            let began = Instant::now();
            backend.losses(&batch, cancel)?;
            best_s = best_s.min(began.elapsed().as_secs_f64());
        }
        Ok(best_s)
    }
}

impl std::str::FromStr for Budget {
    type Err = String;

    /// Reads `48x15@10`: samples, frames, plans a second.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!("`{text}` is no budget: write samples x frames @ plans a second, as 48x15@10")
        };
        let (size, rate) = text.split_once('@').ok_or_else(wrong)?;
        let (samples, frames) = size.split_once('x').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse().ok().filter(|n| (1..=100_000).contains(n));
        let samples = number(samples).ok_or_else(wrong)?;
        let frames = number(frames).ok_or_else(wrong)?;
        let rate = rate.trim().trim_end_matches("Hz").trim().parse();
        let per_second = rate.ok().filter(|r: &f64| (0.01..=1e4).contains(r)).ok_or_else(wrong)?;
        Ok(Self { samples, frames, per_second })
    }
}

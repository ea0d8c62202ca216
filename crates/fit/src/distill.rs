//! The planner's twin of a twin: a thin graph with few substeps, distilled from the twin's own motion.
//!
//! The twin follows actions that are sampled around its hands ([`actions`]), exactly; its nodes are
//! thinned ([`thin`]), and what is left is softened until few substeps are stable. Then the stage that
//! refines every fit refines it, with the twin's motion in the place of a recording: all points seen,
//! without noise, as many as wanted. Its deviation is measured under actions that it was not
//! refined on. The same twin, settings, build and device give the same planner's twin.

mod actions;
mod budget;
mod motion;
mod thin;

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, FitSettings, Graph, PlannerQuality, PlannersTwin, Point, Sequence, Skin,
    Twin,
    capture::Object,
    settings::{RefineSettings, SearchSettings, Substeps},
};
use bendtwin_engine::{Backend, planner::thinned};
use bendtwin_graph::farthest_points;

pub use self::budget::{Budget, Choice};
use self::{
    actions::Hands,
    motion::{Window, deviation, follow},
};
use crate::{Error, FitJob, job::device_kind, task::Task};

/// Actions that it is refined on, and that its deviation is measured on.
const TRAINING: usize = 12;
const HELD_OUT: usize = 8;
/// Points whose motion is refined, at most.
const TRACKED: usize = 200;
/// Passes of the refinement, windows of a step, and length of the steps in logarithms.
const PASSES: u32 = 40;
const BATCH: usize = 8;
const LEARNING_RATE: f64 = 0.1;
/// Shares of the damping that it may begin with.
const DAMPING: [f32; 4] = [1.0, 0.5, 0.2, 0.05];
/// Margin of stability that is left for the refinement, and the one that it may use up to.
const SOFTENED: f64 = 1.25;
const SAFETY: f64 = 1.1;

/// The planner's twin that is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Distillation {
    /// Number of nodes; a twin that has fewer keeps them all, and so does one with rods.
    pub nodes: usize,
    /// Substeps per frame, at most; more where even a soft graph needs more.
    pub substeps: u32,
    /// Seed of the actions.
    pub seed: u64,
}

impl Distillation {
    /// A twin with its planner's twin, in the place of one that it may have. Actions are as fast and as
    /// large as in the capture that the twin was fitted to, if that is given.
    ///
    /// # Errors
    /// If the twin has no control points or diverges under the actions, if the backend fails, or on
    /// cancellation.
    pub fn of(
        &self,
        twin: &Twin,
        capture: Option<&Capture>,
        backend: &Arc<dyn Backend>,
        cancel: &CancelToken,
    ) -> Result<Twin, Error> {
        if twin.graph.control_count() == 0 {
            let why = "the twin has no control points that a plan could move";
            return Err(Error::Planner(why.into()));
        }
        let hands = Hands::new(twin, capture);
        let training = follow(&**backend, twin, &hands.actions(TRAINING, self.seed, 0), cancel)?;
        let held_out = follow(&**backend, twin, &hands.actions(HELD_OUT, self.seed, 1), cancel)?;
        if training.is_empty() || held_out.is_empty() {
            let why = "the twin diverges under actions like those of its capture";
            return Err(Error::Planner(why.into()));
        }
        let mut planner = self.softened(twin, &training, &**backend, cancel)?;
        refine(&mut planner, twin, &training, self.seed, (backend, cancel))?;
        let [mean_m, max_m, travel_m] = deviation(&**backend, &planner, twin, &held_out, cancel)?;
        if ![mean_m, max_m, travel_m].iter().all(|x| x.is_finite()) {
            let why = "it diverges under actions that it was not refined on";
            return Err(Error::Planner(why.into()));
        }
        let graph = &planner.twin.graph;
        let figures = PlannerQuality {
            nodes: graph.node_count() as u32,
            springs: graph.springs.len() as u32,
            triplets: graph.triplets.len() as u32,
            substeps: planner.twin.timing.substeps,
            mean_deviation_m: mean_m,
            max_deviation_m: max_m,
            mean_travel_m: travel_m,
            frames: motion::FRAMES as u32,
            actions: held_out.len() as u32,
        };
        let mut twin = twin.clone();
        twin.quality.planner = Some(figures);
        twin.planner = Some(planner);
        Ok(twin)
    }
}

impl Distillation {
    /// The planner's twin before it is refined: the one nearest to the twin among those with shares
    /// of the damping. Damping limits the step of most twins; stiffness need not give up what
    /// damping does.
    fn softened(
        &self,
        twin: &Twin,
        training: &[Window],
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<PlannersTwin, Error> {
        let thin = thin::thin(twin, self.nodes);
        let mut best: Option<(f64, PlannersTwin)> = None;
        for damping in DAMPING {
            let softened = thin::softened(&thin, damping, self.substeps);
            let [mean_m, ..] = deviation(backend, &softened, twin, training, cancel)?;
            if best.as_ref().is_none_or(|(least_m, _)| mean_m < *least_m) {
                best = Some((mean_m, softened));
            }
        }
        Ok(best.map_or(thin, |(_, softened)| softened))
    }
}

/// Refines the parameters of a planner's twin of `of` over windows of the twin's motion.
fn refine(
    planner: &mut PlannersTwin,
    of: &Twin,
    windows: &[Window],
    seed: u64,
    (backend, cancel): (&Arc<dyn Backend>, &CancelToken),
) -> Result<(), Error> {
    let tracked = tracked(planner);
    let large = large_skin(of).select(&tracked);
    let capture = recorded(of, &large, windows);
    let mut small = Twin::clone(&planner.twin);
    small.skin = planner.twin.skin.select(&tracked);
    small.skin.observed_points = (0..tracked.len() as u32).collect();
    small.graph.observed_points = vec![Graph::NOT_OBSERVED; small.graph.node_count()];
    let settings = FitSettings {
        seed,
        self_contact: small.params.contact.within_object,
        substeps: Substeps::Auto { safety: SAFETY, max: Some(small.timing.substeps) },
        search: SearchSettings { members: 0, ..SearchSettings::default() },
        refine: RefineSettings {
            passes: Some(PASSES),
            batch: Some(BATCH),
            learning_rate: LEARNING_RATE,
            prior: Some(0.0),
            reach: Some(0),
            ..RefineSettings::default()
        },
        ..FitSettings::default()
    };
    let (capture_digest, look) = (String::new(), None);
    let job =
        FitJob { capture: &capture, capture_digest, settings, backend: backend.clone(), look };
    let starts = windows.iter().map(|window| Arc::new(thinned(planner, &window.start)));
    let task = Task::of_motion(&capture, &job.settings, &small, device_kind(&**backend), cancel)?
        .starting_in(starts.collect());
    let refined = job.refined(&task, cancel)?;
    (planner.twin.params, planner.twin.timing) = (refined.params, refined.timing);
    Ok(())
}

/// Points of the planner's skin that are tracked, spread over the object.
fn tracked(planner: &PlannersTwin) -> Vec<usize> {
    let skin = &planner.twin.skin;
    let at = skin.positions(&planner.twin.graph.rest_positions);
    let all: Vec<usize> = (0..skin.len()).collect();
    let mut chosen = Vec::new();
    farthest_points(&at, &all, &mut chosen, TRACKED, 0);
    chosen.sort_unstable();
    chosen
}

/// The points of the planner's skin as those of the twin: its skin, then its nodes.
fn large_skin(twin: &Twin) -> Skin {
    let mut skin = twin.skin.clone();
    let nodes: Vec<u32> = (0..twin.graph.node_count() as u32).collect();
    skin.append(&Skin::at_nodes(&nodes));
    skin
}

/// The twin's motion as a recording of points of its skin.
fn recorded(twin: &Twin, points: &Skin, windows: &[Window]) -> Capture {
    let n = twin.graph.node_count();
    let sequence = |window: &Window| {
        let frames = window.positions.len() / n.max(1);
        let seen: Vec<Point> =
            window.positions.chunks_exact(n.max(1)).flat_map(|row| points.positions(row)).collect();
        Sequence {
            name: "actions".into(),
            frame_count: frames,
            train_frame_count: frames,
            visible: vec![true; seen.len()],
            motion_valid: vec![true; seen.len()],
            points: seen,
            controls: window.controls.clone(),
            truth_tracks: Vec::new(),
            start_frames: 1,
        }
    };
    Capture {
        name: "planner's twin".into(),
        fps: twin.timing.fps,
        environment: twin.environment,
        source_to_world: twin.provenance.source_to_world,
        object: Object { point_count: points.len(), ..Object::default() },
        sequences: windows.iter().map(sequence).collect(),
        others: Vec::new(),
    }
}

#[cfg(test)]
mod tests;

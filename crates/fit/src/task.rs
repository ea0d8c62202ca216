//! The constant part of a fit: nodes, training sequences, and the objective of each.

use std::sync::Arc;

use bendtwin_core::{
    Capture, FitSettings, Graph, Point, Sequence, Skin,
    capture::Subject,
    settings::{Conditions, DeviceKind, SequenceMean},
};
use bendtwin_engine::{
    Loaded, Objective, PointLoss, PointSet, Term, backend::Instance, model::State,
    objective::WeightedTerm,
};
use bendtwin_eval::initial_state;

use bendtwin_graph::{Connectivity, NodeSample, bind_skin, connect, mean_spacing, sample_nodes};

use crate::{Error, sequences, subject::Defaults};

/// The data of a fit that no iteration changes.
pub(crate) struct Task<'a> {
    pub(crate) capture: &'a Capture,
    /// Settings in force: none is left open that effort, capture or device decide.
    pub(crate) settings: FitSettings,
    pub(crate) sample: NodeSample,
    /// Surface points that the nodes carry, whatever joins them in a candidate: bound along the
    /// springs of the settings' own connectivity.
    pub(crate) skin: Arc<Skin>,
    /// Defaults for the kind of object.
    pub(crate) defaults: Defaults,
    /// Training sequences, in the capture's order.
    pub(crate) training: Vec<Training<'a>>,
    /// Typical distance of neighbouring nodes [m], the length scale of bending.
    pub(crate) spacing_m: f64,
    /// True if an object comes near the ground in the training frames.
    pub(crate) nears_ground: bool,
}

/// The training frames of one sequence.
pub(crate) struct Training<'a> {
    pub(crate) sequence: &'a Sequence,
    /// Frames to simulate from the start frame on.
    pub(crate) frames: usize,
    /// The loss, a mean over these frames.
    pub(crate) objective: Objective,
    /// State of the nodes in the start frame.
    pub(crate) initial: Arc<State>,
    /// Control positions over these frames, shape [frames + 1, C, 3].
    pub(crate) controls: Arc<Vec<Point>>,
}

/// The inputs that all training sequences are built from.
struct Setup<'b> {
    sample: &'b NodeSample,
    skin: &'b Skin,
    settings: &'b FitSettings,
    fps: f64,
    /// The sample's nodes without anything between them.
    nodes: Graph,
}

impl<'b> Setup<'b> {
    fn new(
        capture: &Capture,
        settings: &'b FitSettings,
        sample: &'b NodeSample,
        skin: &'b Skin,
    ) -> Self {
        let nodes = Graph {
            rest_positions: sample.positions.clone(),
            kinds: sample.kinds.clone(),
            observed_points: sample.observed_points.clone(),
            ..Graph::default()
        };
        Self { sample, skin, settings, fps: capture.fps, nodes }
    }
}

/// Names of the groups of the loss in progress and checkpoints.
const GROUPS: [&str; 3] = ["chamfer", "track", "acceleration"];

impl<'a> Task<'a> {
    pub(crate) fn new(
        capture: &'a Capture,
        settings: &FitSettings,
        device: DeviceKind,
    ) -> Result<Self, Error> {
        settings.validate().map_err(Error::Settings)?;
        bendtwin_eval::check_capture(capture)?;
        let subject = capture.object.subject();
        let mut settings = settings.filled(Conditions { subject, device });
        let sample = sample_nodes(capture, &settings.graph, settings.seed)?;
        settings.graph.radius_m = Some(sample.radius_m(&settings.graph));
        let joined = connect(&sample, &Connectivity::from_settings(&settings.graph, false));
        let skin = Arc::new(bind_skin(&joined, &sample.surface));
        let setup = Setup::new(capture, &settings, &sample, &skin);
        let sequences = capture.sequences.iter();
        let training: Vec<_> =
            sequences.filter_map(|s| Training::new(s, s.train_frame_count, &setup)).collect();
        if training.is_empty() {
            return Err(Error::Capture(
                "no sequence has training frames with visible points after its start: \
                 raise the training share of its split"
                    .into(),
            ));
        }
        let spacing_m = spacing(&sample);
        let defaults = Defaults::of(capture.object.subject());
        let nears_ground = nears_ground(capture, &training);
        Ok(Self { capture, settings, sample, skin, defaults, training, spacing_m, nears_ground })
    }

    /// The same task without the last frames of the training sequences, of each this share of its
    /// frames; `None` if that would leave one without anything to train on.
    pub(crate) fn without_last(&self, share: f64) -> Option<Self> {
        let setup = Setup::new(self.capture, &self.settings, &self.sample, &self.skin);
        let shorter = |t: &Training<'a>| {
            let held_back = (share * t.frames as f64).round() as usize;
            Training::new(t.sequence, t.end().checked_sub(held_back)?, &setup)
        };
        Some(Self {
            capture: self.capture,
            settings: self.settings.clone(),
            sample: self.sample.clone(),
            skin: self.skin.clone(),
            defaults: self.defaults,
            training: self.training.iter().map(shorter).collect::<Option<_>>()?,
            spacing_m: self.spacing_m,
            nears_ground: self.nears_ground,
        })
    }

    /// The training sequences of the search: fewer sequences and frames if the settings say so, and
    /// the acceleration term, which only helps to find the right region.
    pub(crate) fn search_set(&self) -> Vec<Training<'a>> {
        let settings = &self.settings.search;
        let limit = |n: usize, most: usize| if most == 0 { n } else { n.min(most) };
        let count = limit(self.training.len(), settings.max_sequences);
        let spread = (0..count).map(|i| i * self.training.len() / count);
        let setup = Setup::new(self.capture, &self.settings, &self.sample, &self.skin);
        let mut set = Vec::with_capacity(count);
        for training in spread.map(|i| &self.training[i]) {
            let sequence = training.sequence;
            let most = limit(
                training.end(),
                settings.max_frames.saturating_add(
                    // 0 keeps meaning "all".
                    if settings.max_frames == 0 { 0 } else { sequence.start_frame() + 1 },
                ),
            );
            // All frames are taken if the first ones show nothing.
            let full = training.end();
            let new = |frames| Training::new(sequence, frames, &setup);
            let Some(mut training) = new(most).or_else(|| new(full)) else { continue };
            training.add_acceleration(self.settings.loss.acceleration_weight);
            set.push(training);
        }
        set
    }

    /// Number of starts of each model. Without a search all would refine the same parameters.
    pub(crate) fn starts(&self) -> u32 {
        if self.generations() == 0 {
            return 1;
        }
        self.settings.search.starts.unwrap_or(1)
    }

    /// Number of generations of a search.
    pub(crate) fn generations(&self) -> u32 {
        self.settings.search.generations.unwrap_or_default()
    }

    /// Number of passes of a refinement.
    pub(crate) fn passes(&self) -> u32 {
        self.settings.refine.passes.unwrap_or_default()
    }

    /// Number of candidates of a generation; 0 leaves it to the search.
    pub(crate) fn population(&self) -> usize {
        self.settings.search.population.unwrap_or_default()
    }

    /// Pull of the search to where it starts.
    pub(crate) fn search_prior(&self) -> f64 {
        self.settings.search.prior.unwrap_or_default()
    }

    /// The mean of the losses of several sequences.
    pub(crate) fn sequence_mean(&self) -> SequenceMean {
        self.settings.loss.sequences.unwrap_or(SequenceMean::Arithmetic)
    }

    /// True if the strength of gravity is searched.
    pub(crate) fn searches_gravity(&self) -> bool {
        self.settings.search.gravity.unwrap_or_default()
    }

    /// The kind of the captured object.
    pub(crate) fn subject(&self) -> Subject {
        self.capture.object.subject()
    }

    /// The loss of parameters, from those of the sequences.
    pub(crate) fn loss(&self, of_sequences: impl IntoIterator<Item = f64>) -> f64 {
        sequences::mean(self.sequence_mean(), of_sequences)
    }

    /// True if a graph of this connectivity has rods that twist.
    pub(crate) fn has_rods(&self, connectivity: &Connectivity) -> bool {
        // Only cables have rods; other graphs need not be built to know.
        connectivity.rods
            && self.subject() == Subject::Cable
            && !connect(&self.sample, connectivity).rods.is_empty()
    }

    /// True if nodes can collide with each other.
    pub(crate) fn has_contact(&self) -> bool {
        self.settings.self_contact || self.sample.object_ids.iter().any(|&o| o != 0)
    }

    /// True if control points hold nodes by springs.
    pub(crate) fn has_control_springs(&self) -> bool {
        let pins = &self.sample.pins;
        (0..self.sample.control_rest.len()).any(|c| !pins.iter().any(|p| p.control as usize == c))
    }
}

impl<'a> Training<'a> {
    /// `None` if no frame after the start shows anything.
    fn new(sequence: &'a Sequence, end: usize, setup: &Setup<'_>) -> Option<Self> {
        let start = sequence.start_frame();
        let frames = end.checked_sub(start + 1).filter(|&n| n > 0)?;
        let objective = objective(sequence, frames, setup);
        if objective.terms.is_empty() {
            return None;
        }
        let initial = Arc::new(initial_state(&setup.nodes, setup.fps, sequence));
        let controls = Arc::new(controls_of(sequence, 0, frames));
        Some(Self { sequence, frames, objective, initial, controls })
    }

    /// The frame of the sequence after the last one.
    pub(crate) fn end(&self) -> usize {
        self.sequence.start_frame() + self.frames + 1
    }

    /// A rollout from the start, measured by the loss.
    pub(crate) fn instance(&self, model: &Loaded) -> Instance {
        Instance {
            model: model.clone(),
            initial: self.initial.clone(),
            controls: self.controls.clone(),
            frames: self.frames,
            objective: self.objective.clone(),
            world: Arc::default(),
            motion: Arc::default(),
        }
    }

    /// Control positions of `count` frames, from `first` frames after the start; shape [count + 1,
    /// C, 3].
    pub(crate) fn controls_of(&self, first: usize, count: usize) -> Vec<Point> {
        controls_of(self.sequence, first, count)
    }

    fn add_acceleration(&mut self, weight: f64) {
        if weight > 0.0 {
            let mut terms = self.objective.terms.as_ref().clone();
            let each = (weight / self.frames as f64) as f32;
            terms.extend((2..=self.frames).map(|frame| WeightedTerm {
                frame,
                weight: each,
                group: 2,
                term: Term::Acceleration,
            }));
            terms.sort_by_key(|t| t.frame);
            self.objective.terms = Arc::new(terms);
        }
    }

    /// The loss of frames after `first` alone, for a rollout from the start; a mean over these
    /// frames.
    pub(crate) fn after(&self, first: usize) -> Objective {
        let scale = self.frames as f32 / self.frames.saturating_sub(first).max(1) as f32;
        let inside = self.objective.terms.iter().filter(|t| t.frame > first);
        let scaled = |t: &WeightedTerm| WeightedTerm { weight: t.weight * scale, ..t.clone() };
        Objective {
            groups: self.objective.groups.clone(),
            terms: Arc::new(inside.map(scaled).collect()),
        }
    }

    /// The loss of frames `first + 1 ..= first + count` alone, for a rollout that starts at the end
    /// of frame `first`; a mean over these frames.
    pub(crate) fn window(&self, first: usize, count: usize) -> Objective {
        let scale = self.frames as f32 / count.max(1) as f32;
        let inside = |t: &&WeightedTerm| t.frame > first && t.frame <= first + count;
        let shifted = |t: &WeightedTerm| WeightedTerm {
            frame: t.frame - first,
            weight: t.weight * scale,
            ..t.clone()
        };
        Objective {
            groups: self.objective.groups.clone(),
            terms: Arc::new(self.objective.terms.iter().filter(inside).map(shifted).collect()),
        }
    }
}

/// True if a point comes near the ground in these frames.
fn nears_ground(capture: &Capture, training: &[Training<'_>]) -> bool {
    const NEAR_M: f32 = 0.05;
    let Some(ground) = capture.environment.ground else { return false };
    training.iter().any(|t| {
        let s = t.sequence;
        (s.start_frame()..t.end()).any(|f| {
            s.points_at(f).iter().zip(s.visible_at(f)).any(|(p, seen)| {
                let height: f32 = p.iter().zip(ground.normal).map(|(x, n)| x * n).sum();
                *seen && height - ground.offset_m < NEAR_M
            })
        })
    })
}

fn controls_of(sequence: &Sequence, first: usize, count: usize) -> Vec<Point> {
    let from = sequence.start_frame() + first;
    (from..=from + count).flat_map(|f| sequence.controls_at(f)).copied().collect()
}

/// Mean over frames of Chamfer distance and tracking loss.
///
/// - Chamfer: visible points against the skin. Left out where every visible point is tracked and
///   has a skin point of its own: then it adds no information.
/// - Track: points whose motion is valid against their own skin points, pinned ones excepted. Smooth L1
///   is scaled by beta (which makes it Huber's loss), so that beta sets where outliers begin
///   without changing the weight against the Chamfer distance.
fn objective(sequence: &Sequence, frames: usize, setup: &Setup<'_>) -> Objective {
    let (sample, loss) = (setup.sample, &setup.settings.loss);
    let start = sequence.start_frame();
    let beta_m = loss.track_beta_m as f32;
    let point_count = sequence.points_at(start).len();
    let (mut is_free, mut has_point) = (vec![true; point_count], vec![false; point_count]);
    for pin in &sample.pins {
        if let Some(free) = is_free.get_mut(sample.observed_points[pin.node as usize] as usize) {
            *free = false;
        }
    }
    let observed: Vec<(u32, usize)> = (0..)
        .zip(&setup.skin.observed_points)
        .filter(|(_, p)| **p != Graph::NOT_OBSERVED)
        .map(|(m, p)| (m, *p as usize))
        .collect();
    observed.iter().for_each(|&(_, p)| has_point[p] = true);
    let tracked: Vec<(u32, usize)> = observed.into_iter().filter(|&(_, p)| is_free[p]).collect();
    let all_tracked = has_point.iter().all(|&has| has) && loss.track_weight > 0.0;

    let mut terms = Vec::new();
    let per_frame = |weight: f64| (weight / frames as f64) as f32;
    for frame in 1..=frames {
        let (points, visible) =
            (sequence.points_at(start + frame), sequence.visible_at(start + frame));
        let valid = sequence.motion_valid_at(start + frame);
        let is_seen = |p: usize| visible[p] && points[p].iter().all(|x| x.is_finite());
        let all_valid = (0..points.len()).all(|p| valid[p] || !is_seen(p));
        if loss.chamfer_weight > 0.0 && !(all_tracked && all_valid) {
            let targets: Vec<_> =
                (0..points.len()).filter(|&p| is_seen(p)).map(|p| points[p]).collect();
            if !targets.is_empty() {
                terms.push(WeightedTerm {
                    frame,
                    weight: per_frame(loss.chamfer_weight),
                    group: 0,
                    term: Term::Chamfer { of: PointSet::Skin, targets },
                });
            }
        }
        if loss.track_weight > 0.0 {
            let (tracks, targets): (Vec<u32>, Vec<_>) = tracked
                .iter()
                .filter(|&&(_, p)| valid[p] && is_seen(p))
                .map(|&(m, p)| (m, points[p]))
                .unzip();
            if !tracks.is_empty() {
                terms.push(WeightedTerm {
                    frame,
                    weight: per_frame(loss.track_weight) * beta_m,
                    group: 1,
                    term: Term::Track {
                        of: PointSet::Skin,
                        points: tracks,
                        targets,
                        loss: PointLoss::SmoothL1 { beta_m },
                    },
                });
            }
        }
    }
    Objective { groups: GROUPS.map(str::to_owned).to_vec(), terms: Arc::new(terms) }
}

/// Mean length of known edges, mean distance of surface nodes otherwise; 1 cm if neither is
/// available.
fn spacing(sample: &NodeSample) -> f64 {
    let points = sample.undeformed();
    let length = |&[a, b]: &[u32; 2]| {
        let (a, b) = (points[a as usize], points[b as usize]);
        a.iter().zip(b).map(|(x, y)| f64::from(x - y).powi(2)).sum::<f64>().sqrt()
    };
    let spacing = match &sample.edges {
        Some(edges) => edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64,
        None => mean_spacing(points),
    };
    if spacing.is_finite() && spacing > 1e-6 { spacing } else { 0.01 }
}

#[cfg(test)]
mod tests;

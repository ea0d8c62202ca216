//! The constant part of a fit: nodes, training sequences, and the objective of each.

mod nodes;
pub(crate) mod others;
pub(crate) mod sequences;
mod source;

use std::sync::Arc;

use bendtwin_core::{
    CancelToken, Capture, Environment, FitSettings, Point, Skin, Twin,
    capture::Subject,
    settings::{Conditions, DeviceKind, SequenceMean},
};
use bendtwin_engine::{
    Loaded, Motion, Objective, Term, backend::Instance, model::State, objective::WeightedTerm,
};
use bendtwin_eval::in_recording;
use bendtwin_graph::{Connectivity, NodeSample, bind_skin, connect, mean_spacing, sample_nodes};

pub(crate) use self::nodes::of_start;
use self::{
    nodes::Nodes,
    others::{OtherControls, join},
    source::{Measure, Source},
};
use crate::Error;

/// The data of a fit that no iteration changes.
pub(crate) struct Task<'a> {
    pub(crate) capture: &'a Capture,
    /// Settings in force, with all values filled in that effort, capture or device decide.
    pub(crate) settings: FitSettings,
    pub(crate) sample: NodeSample,
    /// Surface points that the nodes carry, the same for every candidate's connectivity: bound
    /// along the springs of the settings' connectivity. Those of the reference come first, then the
    /// tracked points of other recordings.
    pub(crate) skin: Arc<Skin>,
    /// Number of skin points of the reference.
    pub(crate) own_skin: usize,
    /// Control points of other recordings, which follow those of the reference.
    pub(crate) others: Arc<OtherControls>,
    /// The twin that is refined, in the reference; none where a graph is built and searched.
    pub(crate) start: Option<Arc<Twin>>,
    /// Training sequences, in the capture's order.
    pub(crate) training: Vec<Training<'a>>,
    /// Typical distance of neighbouring nodes [m], the length scale of bending.
    pub(crate) spacing_m: f64,
    /// True if an object comes near the ground in the training frames.
    pub(crate) nears_ground: bool,
    /// True if elements that become too stiff for the most substeps are softened, instead of being
    /// taken back.
    pub(crate) softens: bool,
}

/// The training frames of one sequence.
pub(crate) struct Training<'a> {
    pub(crate) source: Arc<Source<'a>>,
    /// Frames to simulate from the start frame on.
    pub(crate) frames: usize,
    /// The loss, a mean over these frames.
    pub(crate) objective: Objective,
    /// Motion of the object's surroundings over these frames.
    pub(crate) motion: Arc<Motion>,
    /// Control positions over these frames, shape [frames + 1, C, 3].
    pub(crate) controls: Arc<Vec<Point>>,
}

impl<'a> Task<'a> {
    /// # Errors
    /// If settings or capture are wrong, if a recording cannot be brought to the reference, or on
    /// cancellation.
    pub(crate) fn new(
        capture: &'a Capture,
        settings: &FitSettings,
        device: DeviceKind,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let mut settings = settings_in_force(capture, settings, device)?;
        let sample = sample_nodes(capture, &settings.graph, settings.seed)?;
        settings.graph.radius_m = Some(sample.radius_m(&settings.graph));
        let nodes = connect(&sample, &Connectivity::from_settings(&settings.graph, false));
        let skin = bind_skin(&nodes, &sample.surface);
        Self::of_nodes(capture, settings, Nodes { sample, graph: nodes, skin, start: None }, cancel)
    }

    /// The task of refining a twin: its graph and its parameters are what the refinement starts
    /// from, in place of what a search finds.
    ///
    /// # Errors
    /// Those of [`Task::new`], and if the twin cannot be brought to the capture.
    pub(crate) fn from_twin(
        capture: &'a Capture,
        settings: &FitSettings,
        twin: &Twin,
        device: DeviceKind,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let settings = refining(settings_in_force(capture, settings, device)?, twin);
        let there = in_recording(twin, capture, cancel)?;
        let start = there.map_or_else(|| twin.clone(), |(twin, _)| twin);
        Self::of_nodes(capture, settings, Nodes::of_twin(start, capture), cancel)
    }

    /// The task of refining a twin on motion of its object, in its frame and from its rest shape:
    /// nothing is registered. Elements that become too stiff are softened.
    ///
    /// # Errors
    /// Those of [`Task::new`].
    pub(crate) fn of_motion(
        capture: &'a Capture,
        settings: &FitSettings,
        twin: &Twin,
        device: DeviceKind,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let settings = refining(settings_in_force(capture, settings, device)?, twin);
        let nodes = Nodes::of_twin(twin.clone(), capture);
        Ok(Self { softens: true, ..Self::of_nodes(capture, settings, nodes, cancel)? })
    }

    /// The task with training sequences that begin in these states.
    pub(crate) fn starting_in(mut self, states: Vec<Arc<State>>) -> Self {
        for (training, state) in self.training.iter_mut().zip(states) {
            Arc::make_mut(&mut training.source).initial = state;
        }
        self
    }

    fn of_nodes(
        capture: &'a Capture,
        settings: FitSettings,
        nodes: Nodes,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let Nodes { sample, graph: nodes, mut skin, start } = nodes;
        let own_skin = skin.len();
        let mut sources = source::of_reference(capture, &sample, &nodes, &skin);
        let others = join(capture, &nodes, &mut skin, &mut sources, cancel)?;
        let measure = Measure { loss: &settings.loss };
        let training = |source: Source<'a>| {
            let frames = source.sequence.train_frame_count;
            Training::new(Arc::new(source), frames, &measure)
        };
        let training: Vec<_> = sources.into_iter().filter_map(training).collect();
        if training.is_empty() {
            return Err(Error::Capture(
                "no sequence has training frames with visible points after its start: \
                 raise the training share of its split"
                    .into(),
            ));
        }
        let spacing_m = spacing(&sample);
        let nears_ground = training.iter().any(|t| t.nears_ground(&capture.environment));
        Ok(Self {
            capture,
            settings,
            sample,
            skin: Arc::new(skin),
            own_skin,
            others: Arc::new(others),
            start: start.map(Arc::new),
            training,
            spacing_m,
            nears_ground,
            softens: false,
        })
    }

    /// The task without the last frames of the training sequences, this share of the frames of
    /// each; `None` if that would leave one without anything to train on.
    pub(crate) fn without_last(&self, share: f64) -> Option<Self> {
        let measure = Measure { loss: &self.settings.loss };
        let shorter = |t: &Training<'a>| {
            let held_back = (share * t.frames as f64).round() as usize;
            Training::new(t.source.clone(), t.end().checked_sub(held_back)?, &measure)
        };
        Some(Self {
            capture: self.capture,
            settings: self.settings.clone(),
            sample: self.sample.clone(),
            skin: self.skin.clone(),
            own_skin: self.own_skin,
            others: self.others.clone(),
            start: self.start.clone(),
            training: self.training.iter().map(shorter).collect::<Option<_>>()?,
            spacing_m: self.spacing_m,
            nears_ground: self.nears_ground,
            softens: self.softens,
        })
    }

    /// The training sequences of the search: fewer sequences and frames if the settings say so, and
    /// the acceleration term, which only helps to find the right region.
    pub(crate) fn search_set(&self) -> Vec<Training<'a>> {
        let settings = &self.settings.search;
        let limit = |n: usize, most: usize| if most == 0 { n } else { n.min(most) };
        let count = limit(self.training.len(), settings.max_sequences);
        let spread = (0..count).map(|i| i * self.training.len() / count);
        let measure = Measure { loss: &self.settings.loss };
        let mut set = Vec::with_capacity(count);
        for training in spread.map(|i| &self.training[i]) {
            let source = &training.source;
            let most = limit(
                training.end(),
                settings.max_frames.saturating_add(
                    // 0 keeps meaning "all".
                    if settings.max_frames == 0 { 0 } else { source.sequence.start_frame() + 1 },
                ),
            );
            // All frames are taken if the first ones show nothing.
            let full = training.end();
            let new = |frames| Training::new(source.clone(), frames, &measure);
            let Some(mut training) = new(most).or_else(|| new(full)) else { continue };
            training.add_acceleration(self.settings.loss.acceleration_weight);
            set.push(training);
        }
        set
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

    /// Control points of the graph at rest [m]: those of the reference, then those of others.
    pub(crate) fn control_rest(&self) -> &[Point] {
        self.training.first().map_or(&[], |t| &t.source.control_rest)
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

/// Settings with which a twin is refined: without a search, and with the forces that it has.
fn refining(mut settings: FitSettings, twin: &Twin) -> FitSettings {
    (settings.search.starts, settings.search.generations) = (Some(1), Some(0));
    settings.bending = !twin.graph.triplets.is_empty();
    settings.self_contact = twin.params.contact.within_object;
    settings.skin_contact = Some(twin.params.contact.skin);
    (settings.compare_axial, settings.control_velocity) = (false, twin.control_velocity);
    settings
}

/// Settings without open ones, but for the spring radius, for a capture that can be fitted.
///
/// # Errors
/// If settings or capture are wrong.
fn settings_in_force(
    capture: &Capture,
    settings: &FitSettings,
    device: DeviceKind,
) -> Result<FitSettings, Error> {
    settings.validate().map_err(Error::Settings)?;
    capture.recordings().try_for_each(bendtwin_eval::check_capture)?;
    let sequences = capture.recordings().flat_map(|recording| &recording.sequences);
    let sequences = sequences.filter(|sequence| sequence.train_frame_count > 0).count();
    let (subject, is_weighed) = (capture.object.subject(), capture.object.mass_kg.is_some());
    Ok(settings.filled(Conditions { subject, device, sequences, is_weighed }))
}

impl<'a> Training<'a> {
    /// `None` if no frame after the start shows anything.
    fn new(source: Arc<Source<'a>>, end: usize, measure: &Measure<'_>) -> Option<Self> {
        let start = source.sequence.start_frame();
        let frames = end.checked_sub(start + 1).filter(|&n| n > 0)?;
        let objective = measure.objective(&source, frames);
        if objective.terms.is_empty() {
            return None;
        }
        let motion = Arc::new(source.motion_of(frames));
        let controls = Arc::new(source.controls(0, frames));
        Some(Self { source, frames, objective, motion, controls })
    }

    /// The frame of the sequence after the last one.
    pub(crate) fn end(&self) -> usize {
        self.source.sequence.start_frame() + self.frames + 1
    }

    /// True if a point comes near the ground in these frames.
    fn nears_ground(&self, environment: &Environment) -> bool {
        const NEAR_M: f32 = 0.05;
        let Some(ground) = environment.ground else { return false };
        let s = self.source.sequence;
        (s.start_frame()..self.end()).any(|f| {
            s.points_at(f).iter().zip(s.visible_at(f)).any(|(p, seen)| {
                let p = self.source.in_reference(*p);
                let height: f32 = p.iter().zip(ground.normal).map(|(x, n)| x * n).sum();
                *seen && height - ground.offset_m < NEAR_M
            })
        })
    }

    /// A rollout from the start, measured by the loss.
    pub(crate) fn instance(&self, model: &Loaded) -> Instance {
        Instance {
            model: model.clone(),
            initial: self.source.initial.clone(),
            controls: self.controls.clone(),
            frames: self.frames,
            objective: self.objective.clone(),
            world: self.source.world.clone(),
            motion: self.motion.clone(),
        }
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

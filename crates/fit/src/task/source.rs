//! A sequence in the terms of the fit's graph: which of its tracked points are which points of the
//! skin, where its control points are among all control points, and how it starts.

use std::{ops::Range, sync::Arc};

use bendtwin_core::{
    Capture, Graph, Point, Sequence, Skin, geometry::RigidMotion, settings::LossSettings,
};
use bendtwin_engine::{
    Motion, Objective, PointLoss, PointSet, Term, World,
    model::State,
    objective::WeightedTerm,
    world::{Attachment, Grasp, IDENTITY, Region},
};
use bendtwin_eval::initial_state;
use bendtwin_graph::NodeSample;

/// Names of the groups of the loss in progress and checkpoints.
const GROUPS: [&str; 3] = ["chamfer", "track", "acceleration"];

/// A sequence of the reference or of another recording.
#[derive(Clone, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) sequence: &'a Sequence,
    /// Motion from the recording's frame to the reference's; `None` where they are one.
    pub(crate) motion: Option<RigidMotion>,
    /// Skin points that are tracked points of the sequence, with these.
    pub(crate) observed: Vec<(u32, usize)>,
    /// Tracked points that control points prescribe.
    pub(crate) pinned: Vec<usize>,
    /// State of the nodes in the start frame.
    pub(crate) initial: Arc<State>,
    /// Range of this source's control points among those of the graph.
    pub(crate) own_controls: Range<usize>,
    /// Control points of the graph at rest [m], shape [C, 3]: where those of other sequences are.
    pub(crate) control_rest: Arc<Vec<Point>>,
    /// Surroundings in which an open grasp releases the control points of other sequences.
    pub(crate) world: Arc<World>,
}

/// The sequences of the reference.
pub(crate) fn of_reference<'a>(
    capture: &'a Capture,
    sample: &NodeSample,
    nodes: &Graph,
    skin: &Skin,
) -> Vec<Source<'a>> {
    let held = sample.pins.iter().map(|pin| sample.observed_points[pin.node as usize]);
    let held = held.filter(|p| *p != Graph::NOT_OBSERVED).map(|p| p as usize);
    let pinned: Vec<usize> = held.collect();
    let control_rest = Arc::new(sample.control_rest.clone());
    let source = |sequence: &'a Sequence| Source {
        sequence,
        motion: None,
        observed: observed(skin, 0),
        pinned: pinned.clone(),
        initial: Arc::new(initial_state(nodes, capture.fps, sequence)),
        own_controls: 0..control_rest.len(),
        control_rest: control_rest.clone(),
        world: Arc::default(),
    };
    capture.sequences.iter().map(source).collect()
}

/// Points of a skin that are tracked points, with these; the first point has the number `first`.
pub(crate) fn observed(skin: &Skin, first: u32) -> Vec<(u32, usize)> {
    (first..)
        .zip(&skin.observed_points)
        .filter(|(_, p)| **p != Graph::NOT_OBSERVED)
        .map(|(m, p)| (m, *p as usize))
        .collect()
}

impl Source<'_> {
    /// A point of the recording in the reference's frame.
    pub(crate) fn in_reference(&self, p: Point) -> Point {
        self.motion.map_or(p, |motion| motion.apply(p))
    }

    /// Positions of all control points of `count` frames, from `first` frames after the start; shape
    /// [count + 1, C, 3].
    pub(crate) fn controls(&self, first: usize, count: usize) -> Vec<Point> {
        let from = self.sequence.start_frame() + first;
        let mut all = Vec::with_capacity((count + 1) * self.control_rest.len());
        for frame in from..=from + count {
            let row = all.len();
            all.extend_from_slice(&self.control_rest);
            let own = &mut all[row + self.own_controls.start..row + self.own_controls.end];
            for (to, at) in own.iter_mut().zip(self.sequence.controls_at(frame)) {
                *to = self.in_reference(*at);
            }
        }
        all
    }

    /// Lets the graph have control points of other sequences, which hold nothing in this one.
    pub(crate) fn share_graph(&mut self, control_rest: &Arc<Vec<Point>>) {
        self.control_rest = control_rest.clone();
        let of_others = (0..control_rest.len()).filter(|c| !self.own_controls.contains(c));
        let of_others: Vec<u32> = of_others.map(|c| c as u32).collect();
        if of_others.is_empty() {
            return;
        }
        let grasp = Grasp {
            body: 0,
            region: Region::Controls(Arc::new(of_others)),
            attachment: Attachment::Pin,
            max_force: f32::INFINITY,
        };
        self.world = Arc::new(World { bodies: 1, grasps: vec![grasp], ..World::default() });
    }

    /// Motion of the surroundings over `frames`: the grasp is open.
    pub(crate) fn motion_of(&self, frames: usize) -> Motion {
        Motion {
            poses: vec![IDENTITY; (frames + 1) * self.world.bodies],
            closed: vec![false; frames * self.world.grasps.len()],
            rolls: Vec::new(),
        }
    }
}

/// The measure of a sequence.
pub(crate) struct Measure<'s> {
    pub(crate) loss: &'s LossSettings,
}

impl Measure<'_> {
    /// Mean over frames of Chamfer distance and tracking loss.
    ///
    /// - Chamfer: visible points against the skin. Left out where every visible point is tracked
    ///   and has its own skin point: then it adds no information.
    /// - Track: points whose motion is valid against their own skin points, pinned ones excepted.
    ///   Smooth L1 is scaled by beta (which makes it Huber's loss), so that beta sets where outliers
    ///   begin without changing the weight against the Chamfer distance.
    pub(crate) fn objective(&self, source: &Source<'_>, frames: usize) -> Objective {
        let (sequence, loss) = (source.sequence, self.loss);
        let start = sequence.start_frame();
        let beta_m = loss.track_beta_m as f32;
        let point_count = sequence.points_at(start).len();
        let (mut is_free, mut has_point) = (vec![true; point_count], vec![false; point_count]);
        for &p in &source.pinned {
            if let Some(free) = is_free.get_mut(p) {
                *free = false;
            }
        }
        source.observed.iter().for_each(|&(_, p)| has_point[p] = true);
        let tracked = source.observed.iter().copied().filter(|&(_, p)| is_free[p]);
        let tracked: Vec<(u32, usize)> = tracked.collect();
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
                let seen = (0..points.len()).filter(|&p| is_seen(p));
                let targets: Vec<_> = seen.map(|p| source.in_reference(points[p])).collect();
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
                    .map(|&(m, p)| (m, source.in_reference(points[p])))
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
}

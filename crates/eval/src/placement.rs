//! The nodes of a twin in another recording of its object.
//!
//! A recording of the same object has separate tracked points, control points and start. The nodes
//! are registered to the observation at that start ([`bendtwin_register::place`]); the recording's
//! tracked points are bound to the nodes there, and its control points attached to them by the
//! rules of graph building. The result is the twin in this recording: a twin like one that was
//! fitted to it, except for the parameters.

use bendtwin_core::{
    CancelToken, Capture, Environment, Graph, Params, Point, Quality, Sequence, Skin, Timing, Twin,
    geometry::{RigidMotion, point_distance, vector3},
    params::MAX_SPRING_STIFFNESS,
    quality::RegistrationScore,
    settings::GraphSettings,
};
use bendtwin_engine::{Model, enough_substeps};
use bendtwin_graph::{Connectivity, SurfacePoints, bind_points, hand_of_each, hold};
use bendtwin_register::{MAX_POINTS, Observation, RegisterOptions, place};

use crate::{
    Error,
    distance::is_finite,
    trajectory::{check, difference},
};

/// Weight of a point of the completed surface beside one that was seen.
const COMPLETED_WEIGHT: f32 = 0.5;
/// Farthest distance of a twin's node from its tracked point in the first frame of the twin's
/// capture [m], and the share of nodes for which that holds.
const SAME_M: f64 = 1e-3;
const SAME_SHARE: f64 = 0.9;

/// The nodes of a graph at the start of a sequence of another recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Positions [m], shape [N, 3].
    pub positions: Vec<Point>,
    /// Velocities [m/s], shape [N, 3].
    pub velocities: Vec<Point>,
    /// The recording's tracked points that were seen at the start, on the nodes that carry them.
    pub tracks: Skin,
    /// The rigid part of the motion from the rest shape of the graph.
    pub rigid: RigidMotion,
    /// Distances of the observed points from the nodes' surface.
    pub score: RegistrationScore,
}

impl Placement {
    /// Registers the nodes of a graph, with its skin, to the start of a sequence.
    ///
    /// # Errors
    /// If the sequence contradicts itself, if nothing was seen at its start, if the graph does not
    /// explain that, or on cancellation.
    pub fn new(
        graph: &Graph,
        skin: &Skin,
        capture: &Capture,
        sequence: &Sequence,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let start = sequence.start_frame();
        if start >= sequence.frame_count {
            return Err(Error::Inconsistent(format!("sequence `{}` has no start", sequence.name)));
        }
        let seen = VisiblePoints::at(sequence, start);
        // The shape prior is of the first frame of the capture.
        let is_first = capture.sequences.first().is_some_and(|s| std::ptr::eq(s, sequence));
        let completed = match is_first {
            true => capture.object.completed_surface.as_slice(),
            false => &[],
        };
        let placed =
            place(graph, skin, &seen.observation(completed), &RegisterOptions::default(), cancel)?;
        let points = SurfacePoints { positions: seen.points, observed_points: seen.indices };
        let tracks = bind_points(graph, &placed.positions, &points);
        let velocities =
            velocities(capture.fps, sequence, &points.observed_points, &placed.positions);
        let score = RegistrationScore {
            median_mm: placed.residual.median_mm,
            p95_mm: placed.residual.p95_mm,
            explained: placed.explained.points,
        };
        let (positions, rigid) = (placed.positions, placed.rigid);
        Ok(Self { positions, velocities, tracks, rigid, score })
    }

    /// A twin in this recording. Springs of the control points, which are the recording's, hold as
    /// firmly as those of the twin ([`Grip`]).
    ///
    /// # Errors
    /// If the twin is of a cable, which only motion capture of the same cable can be compared with.
    pub fn twin(&self, twin: &Twin, capture: &Capture, sequence: &Sequence) -> Result<Twin, Error> {
        refuse_cable(twin, capture)?;
        let controls = sequence.controls_at(sequence.start_frame());
        let settings = twin.provenance.settings.as_ref();
        let settings = settings.map_or_else(GraphSettings::default, |s| s.graph.clone());
        let connectivity = Connectivity::from_settings(&settings, false);
        let (graph, params) = self.attached(twin, controls, &connectivity);
        let mut skin = Skin { observed_points: not_observed(twin.skin.len()), ..twin.skin.clone() };
        skin.append(&self.tracks);
        let mut carried = Twin {
            graph,
            skin,
            params,
            environment: environment(&twin.environment, &capture.environment),
            timing: retimed(twin.timing, capture.fps),
            control_hands: capture.object.control_hands.clone(),
            appearance: None,
            surface: None,
            planner: None,
            // The report's arrays and the planner's twin belong to the skin of the twin that it was made for.
            quality: Quality { identifiability: None, planner: None, ..twin.quality.clone() },
            ..twin.clone()
        };
        if let Err(needs) = enough_substeps(&Model::from(&carried), carried.timing.substeps) {
            carried.timing.substeps = needs.needed;
        }
        Ok(carried)
    }

    /// Graph and parameters of a twin with other control points, its nodes where they are placed.
    fn attached(
        &self,
        twin: &Twin,
        controls: &[Point],
        connectivity: &Connectivity,
    ) -> (Graph, Params) {
        let (old, n) = (&twin.graph, twin.graph.node_count());
        let is_inner = |ends: &[u32]| ends.iter().all(|e| (*e as usize) < n);
        let springs: Vec<usize> =
            (0..old.springs.len()).filter(|&s| is_inner(&old.springs[s])).collect();
        let triplets: Vec<usize> =
            (0..old.triplets.len()).filter(|&t| is_inner(&old.triplets[t])).collect();
        let of = |values: &[f32], kept: &[usize]| kept.iter().map(|&i| values[i]).collect();
        let p = &twin.params;
        let mut params = Params {
            spring_stiffness: of(&p.spring_stiffness, &springs),
            spring_dashpot: of(&p.spring_dashpot, &springs),
            rest_lengths_m: of(&p.rest_lengths_m, &springs),
            bend_stiffness: of(&p.bend_stiffness, &triplets),
            bend_damping: of(&p.bend_damping, &triplets),
            rest_angles_rad: of(&p.rest_angles_rad, &triplets),
            ..p.clone()
        };
        let mut graph = Graph {
            rest_positions: self.positions.clone(),
            observed_points: not_observed(n),
            control_rest: controls.to_vec(),
            springs: springs.iter().map(|&s| old.springs[s]).collect(),
            triplets: triplets.iter().map(|&t| old.triplets[t]).collect(),
            ..old.clone()
        };
        let springs = hold(&self.positions, controls, connectivity);
        let grips = Grip::of(old, p).by_springs(n, controls, &springs);
        for (spring, Grip { stiffness, dashpot }) in springs.into_iter().zip(grips) {
            let [node, control] = spring.map(|e| e as usize);
            let length_m = point_distance(self.positions[node], controls[control - n]) as f32;
            graph.springs.push(spring);
            params.spring_stiffness.push(stiffness);
            params.spring_dashpot.push(dashpot);
            params.rest_lengths_m.push(length_m.max(bendtwin_graph::MIN_REST_LENGTH_M));
        }
        (graph, params)
    }
}

/// A twin in the first sequence of another recording, and that recording with this sequence alone;
/// `None` if it is the twin's capture, where the twin needs no placement.
///
/// # Errors
/// Those of [`Placement::new`] and [`Placement::twin`].
pub fn in_recording(
    twin: &Twin,
    capture: &Capture,
    cancel: &CancelToken,
) -> Result<Option<(Twin, Capture)>, Error> {
    let Some(sequence) = capture.sequences.first().filter(|_| !is_own_capture(twin, capture))
    else {
        return Ok(None);
    };
    refuse_cable(twin, capture)?;
    let placed = Placement::new(&twin.graph, &twin.skin, capture, sequence, cancel)?;
    let there = placed.twin(twin, capture, sequence)?;
    let alone = Capture {
        name: capture.name.clone(),
        fps: capture.fps,
        environment: capture.environment,
        source_to_world: capture.source_to_world,
        object: capture.object.clone(),
        sequences: vec![sequence.clone()],
        others: Vec::new(),
    };
    Ok(Some((there, alone)))
}

/// Points of a sequence that were seen in a frame.
struct VisiblePoints {
    /// Their indices.
    indices: Vec<u32>,
    /// Their positions [m].
    points: Vec<Point>,
}

impl VisiblePoints {
    fn at(sequence: &Sequence, frame: usize) -> Self {
        let rows = sequence.points_at(frame).iter().zip(sequence.visible_at(frame));
        let seen = (0..).zip(rows).filter(|(_, (p, visible))| **visible && is_finite(p));
        let (indices, points) = seen.map(|(i, (p, _))| (i, *p)).unzip();
        Self { indices, points }
    }

    /// The observation that they are, together with a completed surface.
    fn observation(&self, completed: &[Point]) -> Observation {
        let completed = completed.iter().filter(|p| is_finite(p));
        let all = self.points.iter().map(|p| (*p, 1.0));
        let all: Vec<(Point, f32)> = all.chain(completed.map(|p| (*p, COMPLETED_WEIGHT))).collect();
        let stride = all.len().div_ceil(MAX_POINTS).max(1);
        let (points, weights) = all.into_iter().step_by(stride).unzip();
        Observation { points, weights, ..Observation::default() }
    }
}

/// Velocities of nodes at the start of a sequence that has a frame before it: those of the nearest
/// tracked points [m/s].
fn velocities(fps: f64, sequence: &Sequence, tracked: &[u32], nodes: &[Point]) -> Vec<Point> {
    let still = vec![[0.0; 3]; nodes.len()];
    let start = sequence.start_frame();
    let Some(before) = start.checked_sub(1) else { return still };
    let (now, then) = (sequence.points_at(start), sequence.points_at(before));
    let visible = sequence.visible_at(before);
    let moving: Vec<(Point, Point)> = tracked
        .iter()
        .map(|&p| p as usize)
        .filter(|&p| visible[p] && is_finite(&then[p]))
        .map(|p| (now[p], difference(now[p], then[p]).map(|d| d * fps as f32)))
        .collect();
    let of = |node: &Point| {
        let nearest = moving
            .iter()
            .min_by(|a, b| point_distance(a.0, *node).total_cmp(&point_distance(b.0, *node)));
        nearest.map_or([0.0; 3], |m| m.1)
    };
    nodes.iter().map(of).collect()
}

/// True if a capture is the one that a twin was fitted to, by where its nodes are in the first
/// frame. A cable is known point by point, so that any motion capture of it will do.
pub fn is_own_capture(twin: &Twin, capture: &Capture) -> bool {
    if check(twin, capture).is_err() {
        return false;
    }
    let Some(first) = capture.sequences.first().filter(|_| !is_of_cable(twin)) else { return true };
    let start = first.start_frame();
    let (points, visible) = (first.points_at(start), first.visible_at(start));
    let (mut known, mut same) = (0.0, 0.0);
    for (at, &p) in twin.graph.rest_positions.iter().zip(&twin.graph.observed_points) {
        if visible.get(p as usize) == Some(&true) {
            known += 1.0;
            same += f64::from(u8::from(point_distance(*at, points[p as usize]) <= SAME_M));
        }
    }
    // Nodes without a tracked point give no evidence.
    known == 0.0 || same >= SAME_SHARE * known
}

/// Refuses a twin or a capture of a cable, which has no other recordings than those of its points.
pub(crate) fn refuse_cable(twin: &Twin, capture: &Capture) -> Result<(), Error> {
    if !is_of_cable(twin) && capture.object.edges.is_empty() {
        return Ok(());
    }
    check(twin, capture)?;
    Err(Error::Mismatch(
        "a cable is known point by point, and cannot be registered to another recording".into(),
    ))
}

/// True if a twin's nodes are points that clamps hold, as only a cable's are.
fn is_of_cable(twin: &Twin) -> bool {
    !twin.graph.pins.is_empty() || !twin.graph.rods.is_empty()
}

/// Stiffness and dashpot of the springs of a hand, in sum.
///
/// A hand holds elsewhere as firmly as it does in the twin's own recording, however many springs it
/// has there: a place where it reaches half as many nodes is not held half as firmly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Stiffness [N per unit strain].
    pub stiffness: f32,
    /// Dashpot [N s/m].
    pub dashpot: f32,
}

impl Grip {
    /// The mean over the hands of a graph; as if a hand held by a single typical spring if it has
    /// none.
    pub fn of(graph: &Graph, params: &Params) -> Self {
        let n = graph.node_count();
        let hand = hand_of_each(&graph.control_rest);
        let (mut holding, mut sums) = (vec![false; graph.control_count()], [0.0; 2]);
        let values = params.spring_stiffness.iter().zip(&params.spring_dashpot);
        for (spring, (stiffness, dashpot)) in graph.springs.iter().zip(values) {
            if let Some(control) = (spring[1] as usize).checked_sub(n) {
                holding[hand[control]] = true;
                sums[0] += f64::from(*stiffness);
                sums[1] += f64::from(*dashpot);
            }
        }
        let hands = holding.iter().filter(|holds| **holds).count();
        if hands == 0 {
            let typical = |values: &[f32]| {
                let mut values: Vec<f64> = values.iter().map(|x| f64::from(*x)).collect();
                bendtwin_core::geometry::median(&mut values).unwrap_or(0.0) as f32
            };
            let stiffness = typical(&params.spring_stiffness);
            return Self { stiffness, dashpot: typical(&params.spring_dashpot) };
        }
        let [stiffness, dashpot] = sums.map(|sum| (sum / hands as f64) as f32);
        Self { stiffness, dashpot }
    }

    /// The grip shared out evenly over the springs of each hand: that of each spring. `springs` are
    /// from nodes, of which there are `nodes`, to control points at `controls` [m].
    pub fn by_springs(self, nodes: usize, controls: &[Point], springs: &[[u32; 2]]) -> Vec<Self> {
        let hand = hand_of_each(controls);
        let of = |spring: &[u32; 2]| hand[spring[1] as usize - nodes];
        let mut counts = vec![0_u32; controls.len()];
        springs.iter().for_each(|s| counts[of(s)] += 1);
        let share = |spring: &[u32; 2]| {
            let count = counts[of(spring)] as f32;
            let stiffness = (self.stiffness / count).min(MAX_SPRING_STIFFNESS);
            Self { stiffness, dashpot: self.dashpot / count }
        };
        springs.iter().map(share).collect()
    }
}

/// The surroundings of another recording with the twin's strength of gravity.
fn environment(own: &Environment, there: &Environment) -> Environment {
    let strength = vector3(own.gravity).norm();
    let gravity = vector3(there.gravity);
    match gravity.norm() {
        size if size > 0.0 && strength > 0.0 => Environment {
            gravity: there.gravity.map(|g| (f64::from(g) * strength / size) as f32),
            ..*there
        },
        _ => *there,
    }
}

/// A timing at another frame rate with substeps that are no longer.
fn retimed(own: Timing, fps: f64) -> Timing {
    let substeps = f64::from(own.substeps) * own.fps / fps;
    // Rounding must not add one.
    Timing { fps, substeps: ((substeps - 1e-6).ceil() as u32).max(1) }
}

fn not_observed(count: usize) -> Vec<u32> {
    vec![Graph::NOT_OBSERVED; count]
}

#[cfg(test)]
mod tests;

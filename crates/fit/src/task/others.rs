//! Further recordings of the object in the terms of the reference's graph.
//!
//! The nodes are those of the reference. Another recording is moved so that its gravity and ground
//! are the reference's, the nodes are registered to its start ([`Placement`]), and its control
//! points are attached to them there. One graph has the control points of all recordings, so that
//! search and refinement see sequences of one model; in each sequence an open grasp releases the
//! others' control points. The twin keeps those of the reference.

use std::{ops::Range, sync::Arc};

use bendtwin_core::{
    CancelToken, Capture, Category, Environment, Graph, Params, Point, Problem as _, Sequence,
    Skin,
    capture::Subject,
    geometry::{RigidMotion, point, point_distance, vector3},
};
use bendtwin_engine::model::State;
use bendtwin_eval::Placement;
use bendtwin_graph::{Connectivity, MIN_REST_LENGTH_M, hold};
use nalgebra::{Rotation3, Vector3};

use super::{
    Task,
    source::{Source, observed},
};
use crate::Error;

/// Largest angle between the grounds of two recordings whose gravity is aligned [rad].
const LEVEL_RAD: f64 = 0.05;
/// Largest difference of what must be equal in the recordings of a cable [m, m/s²].
const SAME: f64 = 1e-4;

/// Control points of other recordings, which follow those of the reference in the graph.
#[derive(Clone, Debug, Default)]
pub(crate) struct OtherControls {
    groups: Vec<Group>,
}

/// Control points of one sequence, in the recording's own frame.
#[derive(Clone, Debug)]
struct Group {
    /// Nodes at the start [m], shape [N, 3].
    nodes: Vec<Point>,
    /// Control points at the start [m], shape [C, 3].
    controls: Vec<Point>,
}

/// Adds the training sequences of other recordings to those of the reference, and their tracked
/// points to its skin. `nodes` is a graph of the reference's nodes.
pub(crate) fn join<'a>(
    capture: &'a Capture,
    nodes: &Graph,
    skin: &mut Skin,
    sources: &mut Vec<Source<'a>>,
    cancel: &CancelToken,
) -> Result<OtherControls, Error> {
    let mut others = OtherControls::default();
    if capture.recordings().count() > Capture::MOST_RECORDINGS {
        return Err(Error::Capture(format!(
            "it has {} recordings of its object: at most {} are taken",
            capture.recordings().count(),
            Capture::MOST_RECORDINGS
        )));
    }
    let (own_skin, mut control_rest) = (skin.clone(), nodes.control_rest.clone());
    for recording in &capture.others {
        let is_used = |s: &&Sequence| s.train_frame_count > s.start_frame() + 1;
        let mut used = recording.sequences.iter().filter(is_used).peekable();
        if used.peek().is_none() {
            continue;
        }
        let motion = to_reference(capture, recording).map_err(|why| wrong(recording, why))?;
        for sequence in used {
            if capture.object.subject() == Subject::Cable {
                let source = of_cable(nodes, &own_skin, capture, sequence, sources);
                sources.push(source);
                continue;
            }
            let placed = Placement::new(nodes, &own_skin, recording, sequence, cancel);
            let placed = placed.map_err(|error| unplaced(recording, error))?;
            let controls = sequence.controls_at(sequence.start_frame());
            let first = control_rest.len();
            control_rest.extend(controls.iter().map(|p| motion.apply(*p)));
            let initial = State {
                positions: placed.positions.iter().map(|p| motion.apply(*p)).collect(),
                velocities: placed
                    .velocities
                    .iter()
                    .map(|v| point(motion.rotation * vector3(*v)))
                    .collect(),
                ..State::rest(nodes)
            };
            sources.push(Source {
                sequence,
                motion: Some(motion),
                observed: observed(&placed.tracks, skin.len() as u32),
                pinned: Vec::new(),
                initial: Arc::new(initial),
                own_controls: first..control_rest.len(),
                control_rest: Arc::default(),
                world: Arc::default(),
            });
            others.groups.push(Group { nodes: placed.positions, controls: controls.to_vec() });
            let mut tracks = placed.tracks;
            tracks.observed_points.fill(Graph::NOT_OBSERVED);
            skin.append(&tracks);
        }
    }
    let control_rest = Arc::new(control_rest);
    sources.iter_mut().for_each(|source| source.share_graph(&control_rest));
    Ok(others)
}

/// A sequence of a cable, whose points are nodes.
fn of_cable<'a>(
    nodes: &Graph,
    skin: &Skin,
    capture: &Capture,
    sequence: &'a Sequence,
    sources: &[Source<'a>],
) -> Source<'a> {
    Source {
        sequence,
        motion: None,
        observed: observed(skin, 0),
        pinned: sources.first().map(|s| s.pinned.clone()).unwrap_or_default(),
        initial: Arc::new(bendtwin_eval::initial_state(nodes, capture.fps, sequence)),
        own_controls: 0..nodes.control_count(),
        control_rest: Arc::default(),
        world: Arc::default(),
    }
}

fn wrong(recording: &Capture, why: String) -> Error {
    Error::Capture(format!("recording `{}` {why}", recording.name))
}

fn unplaced(recording: &Capture, error: bendtwin_eval::Error) -> Error {
    match error.category() {
        Category::Cancelled => bendtwin_engine::Error::Cancelled.into(),
        _ => Error::Recording { name: recording.name.clone(), error: Box::new(error) },
    }
}

/// The motion that makes a recording's gravity and ground the reference's, or the reason why no
/// motion does.
fn to_reference(reference: &Capture, other: &Capture) -> Result<RigidMotion, String> {
    if (reference.fps - other.fps).abs() > 1e-6 * reference.fps {
        return Err(format!(
            "has {} frames a second and the reference {}: resample it",
            other.fps, reference.fps
        ));
    }
    if reference.object.subject() != other.object.subject() {
        return Err("and the reference are not both of a cable with known edges".to_owned());
    }
    let motion = level(&reference.environment, &other.environment)?;
    if reference.object.subject() == Subject::Cable {
        let turned = (motion.rotation - nalgebra::Matrix3::identity()).norm();
        if turned > SAME || motion.translation.norm() > SAME {
            return Err("of a cable is in another frame than the reference".to_owned());
        }
        let (a, b) = (&reference.object, &other.object);
        let same = a.point_count == b.point_count && a.edges == b.edges && a.pins == b.pins;
        if !same {
            return Err("is of a cable with other edges or clamps".to_owned());
        }
    }
    Ok(motion)
}

fn level(reference: &Environment, other: &Environment) -> Result<RigidMotion, String> {
    let [to, from] = [reference, other].map(|e| vector3(e.gravity));
    let rotation = match (to.try_normalize(0.0), from.try_normalize(0.0)) {
        (None, None) => Rotation3::identity(),
        (Some(to), Some(from)) => {
            let half_turn = || Rotation3::from_axis_angle(&across(from), std::f64::consts::PI);
            Rotation3::rotation_between(&from, &to).unwrap_or_else(half_turn)
        }
        _ => return Err("and the reference do not both have gravity".to_owned()),
    };
    let mut motion = RigidMotion { rotation: *rotation.matrix(), translation: Vector3::zeros() };
    match (reference.ground, other.ground) {
        (None, None) => Ok(motion),
        (Some(to), Some(from)) => {
            let normal = vector3(to.normal);
            if normal.angle(&(motion.rotation * vector3(from.normal))) > LEVEL_RAD {
                return Err(
                    "has a ground that is inclined otherwise than the reference's".to_owned()
                );
            }
            motion.translation = normal * f64::from(to.offset_m - from.offset_m);
            Ok(motion)
        }
        _ => {
            Err("and the reference do not both have a ground: declare it in both or in none"
                .to_owned())
        }
    }
}

/// A direction perpendicular to another.
fn across(direction: Vector3<f64>) -> nalgebra::Unit<Vector3<f64>> {
    let any = if direction.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    nalgebra::Unit::new_normalize(direction.cross(&any))
}

impl OtherControls {
    /// True without other recordings.
    pub(crate) fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Control points of each sequence in the graph, whose first `own` are the reference's.
    pub(crate) fn ranges(&self, own: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        self.groups.iter().scan(own, |next, group| {
            let first = *next;
            *next += group.controls.len();
            Some(first..*next)
        })
    }

    /// Attaches the control points to the graph of the reference, in the shapes that its nodes have
    /// in their recordings.
    pub(crate) fn attach(
        &self,
        connectivity: &Connectivity,
        control_rest: &[Point],
        graph: &mut Graph,
        rest_lengths_m: &mut Vec<f32>,
    ) {
        let n = graph.node_count();
        for group in &self.groups {
            let first = graph.control_rest.len();
            let own = &control_rest[first..first + group.controls.len()];
            graph.control_rest.extend_from_slice(own);
            for [node, control] in hold(&group.nodes, &group.controls, connectivity) {
                let at = group.controls[control as usize - n];
                let length_m = point_distance(group.nodes[node as usize], at) as f32;
                graph.springs.push([node, control + first as u32]);
                rest_lengths_m.push(length_m.max(MIN_REST_LENGTH_M));
            }
        }
    }
}

/// Graph, parameters and skin with the control points and the skin of the reference alone.
pub(crate) fn of_reference(
    task: &Task<'_>,
    graph: &Graph,
    params: Params,
    skin: &Skin,
) -> (Graph, Params, Skin) {
    if task.others.is_empty() {
        return (graph.clone(), params, skin.clone());
    }
    let controls = task.sample.control_rest.len();
    let end = graph.node_count() + controls;
    let is_own: Vec<bool> = graph.springs.iter().map(|s| (s[1] as usize) < end).collect();
    let kept = |values: &[f32]| -> Vec<f32> {
        values.iter().zip(&is_own).filter(|(_, own)| **own).map(|(x, _)| *x).collect()
    };
    let params = Params {
        spring_stiffness: kept(&params.spring_stiffness),
        spring_dashpot: kept(&params.spring_dashpot),
        rest_lengths_m: kept(&params.rest_lengths_m),
        ..params
    };
    let springs = graph.springs.iter().zip(&is_own).filter(|(_, own)| **own);
    let graph = Graph {
        control_rest: graph.control_rest[..controls].to_vec(),
        springs: springs.map(|(s, _)| *s).collect(),
        ..graph.clone()
    };
    let own: Vec<usize> = (0..task.own_skin).collect();
    (graph, params, skin.select(&own))
}

#[cfg(test)]
mod tests;

//! The tree of coordinate frames that `/tf` and `/tf_static` describe.

mod parents;

use std::collections::BTreeMap;

pub(super) use self::parents::Choice;
use super::messages::Transform;
use crate::{
    Error,
    files::at_most,
    raw::{
        Pose,
        clock::samples::{around, nearby},
    },
};

/// Transforms that are kept.
const MAX_SAMPLES: usize = 1_000_000;
/// Frames between a camera and the world.
const MAX_DEPTH: usize = 64;

/// Pose of each frame in its parents.
#[derive(Debug, Default)]
pub(super) struct Tree {
    /// Edges by child, then by parent.
    edges: BTreeMap<String, BTreeMap<String, Edge>>,
    /// The parents that count of frames with several.
    chosen: BTreeMap<String, String>,
    count: usize,
}

/// Pose of a frame in a parent.
#[derive(Debug, Default)]
struct Edge {
    /// The one that holds for all times, if there is any: it goes before the others.
    fixed: Option<Transform>,
    /// In the order of time.
    samples: Vec<Transform>,
}

/// A frame's name: ROS 1 writes some with a slash before them.
pub(super) fn plain(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

impl Tree {
    /// Adds a transform; one that is `fixed` holds for all times.
    pub(super) fn add(&mut self, mut transform: Transform, fixed: bool) -> Result<(), Error> {
        self.count += 1;
        at_most("transforms", self.count, MAX_SAMPLES)?;
        let child = plain(&std::mem::take(&mut transform.child)).to_owned();
        let parent = plain(&std::mem::take(&mut transform.parent)).to_owned();
        let edge = self.edges.entry(child).or_default().entry(parent).or_default();
        if fixed {
            // The latest calibration counts.
            edge.fixed = Some(transform);
        } else {
            edge.samples.push(transform);
        }
        Ok(())
    }

    pub(super) fn sort(&mut self) {
        for edge in self.edges.values_mut().flat_map(BTreeMap::values_mut) {
            edge.samples.sort_by_key(|sample| sample.stamp_ns);
        }
    }

    /// A frame and all above it, up to the root.
    pub(super) fn path<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let mut path = vec![frame];
        while let Some((parent, _)) = path.last().and_then(|frame| self.parent(frame)) {
            // A circle has no root.
            if path.len() > MAX_DEPTH || path.contains(&parent) {
                return Vec::new();
            }
            path.push(parent);
        }
        path
    }

    /// The parent of a frame that counts.
    fn parent(&self, frame: &str) -> Option<(&str, &Edge)> {
        let parents = self.edges.get(frame)?;
        let (parent, edge) = match self.chosen.get(frame) {
            Some(chosen) => parents.get_key_value(chosen)?,
            None => parents.first_key_value()?,
        };
        Some((parent, edge))
    }

    /// `true` if a frame moves in one above it.
    pub(super) fn moves(&self, frame: &str, world: &str) -> bool {
        self.between(frame, world).any(Edge::moves)
    }

    /// Pose of a frame in one above it at a time.
    pub(super) fn pose(&self, frame: &str, world: &str, ns: i64) -> Pose {
        along(self.between(frame, world), ns)
    }

    /// Pose of a frame in another in the same tree, at any place of it, at some times [ns]; `None` where
    /// it is unknown. `shared` is a frame above both.
    pub(super) fn relative(
        &self,
        frame: &str,
        to: &str,
        shared: &str,
        times_ns: &[i64],
    ) -> Vec<Option<Pose>> {
        let [from, to]: [Vec<&Edge>; 2] = [frame, to].map(|f| self.between(f, shared).collect());
        let pose = |&ns: &i64| {
            let is_known = from.iter().chain(&to).all(|edge| edge.is_known(ns));
            let placed = |way: &[&Edge]| along(way.iter().copied(), ns);
            is_known.then(|| placed(&to).inverse().after(&placed(&from)))
        };
        times_ns.iter().map(pose).collect()
    }

    /// The frame nearest to two that is above both, or one of them.
    pub(super) fn shared<'a>(&'a self, frame: &'a str, other: &'a str) -> Option<&'a str> {
        let path = self.path(other);
        self.path(frame).into_iter().find(|frame| path.contains(frame))
    }

    /// A frame at or above this one with several parents of which none was chosen.
    pub(super) fn unsettled<'a>(&'a self, frame: &'a str) -> Option<&'a str> {
        let is_unsettled = |frame: &&str| {
            !self.chosen.contains_key(*frame)
                && self.edges.get(*frame).is_some_and(|parents| parents.len() > 1)
        };
        self.path(frame).into_iter().find(is_unsettled)
    }

    /// Names of the frames that have a parent.
    pub(super) fn frames(&self) -> impl Iterator<Item = &String> {
        self.edges.keys()
    }

    fn between<'a>(&'a self, frame: &'a str, world: &'a str) -> impl Iterator<Item = &'a Edge> {
        let path = self.path(frame);
        let below = path.into_iter().take_while(move |f| *f != world);
        below.filter_map(|f| self.parent(f)).map(|(_, edge)| edge)
    }
}

/// Pose of the frame where a way up begins in that where it ends, at a time.
fn along<'a>(way: impl Iterator<Item = &'a Edge>, ns: i64) -> Pose {
    way.fold(Pose::IDENTITY, |pose, edge| edge.at(ns).after(&pose))
}

impl Transform {
    fn is_as(&self, other: &Self) -> bool {
        (self.translation, self.rotation) == (other.translation, other.rotation)
    }
}

impl Edge {
    fn moves(&self) -> bool {
        self.fixed.is_none() && self.samples.windows(2).any(|w| !w[0].is_as(&w[1]))
    }

    /// `true` if its pose is known at a time: it is fixed, has a single sample, or one nearby.
    fn is_known(&self, ns: i64) -> bool {
        self.fixed.is_some()
            || self.samples.len() == 1
            || nearby(&self.samples, |sample| sample.stamp_ns, ns).is_some()
    }

    /// Between the samples before and after, at the ends as the nearest one.
    fn at(&self, ns: i64) -> Pose {
        if let Some(fixed) = &self.fixed {
            return Pose::from_quaternion(fixed.rotation, fixed.translation);
        }
        let Some(found) = around(&self.samples, |sample| sample.stamp_ns, ns) else {
            return Pose::IDENTITY;
        };
        let [a, b] = [found.before, found.after]
            .map(|i| (self.samples[i].translation, self.samples[i].rotation));
        Pose::between([&a, &b], found.share)
    }
}

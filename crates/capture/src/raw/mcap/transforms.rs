//! The tree of coordinate frames that `/tf` and `/tf_static` describe.

mod parents;

use std::collections::BTreeMap;

pub(super) use self::parents::Choice;
use super::messages::Transform;
use crate::{Error, files::at_most, raw::Pose};

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
        let mut pose = Pose::IDENTITY;
        for edge in self.between(frame, world) {
            pose = edge.at(ns).after(&pose);
        }
        pose
    }

    fn between<'a>(&'a self, frame: &'a str, world: &'a str) -> impl Iterator<Item = &'a Edge> {
        let path = self.path(frame);
        let below = path.into_iter().take_while(move |f| *f != world);
        below.filter_map(|f| self.parent(f)).map(|(_, edge)| edge)
    }
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

    /// Between the samples before and after, at the ends as the nearest one.
    fn at(&self, ns: i64) -> Pose {
        if let Some(fixed) = &self.fixed {
            return Pose::from_quaternion(fixed.rotation, fixed.translation);
        }
        let after = self.samples.partition_point(|sample| sample.stamp_ns < ns);
        let last = self.samples.len().saturating_sub(1);
        let pair = (self.samples.get(after.saturating_sub(1)), self.samples.get(after.min(last)));
        let (Some(a), Some(b)) = pair else { return Pose::IDENTITY };
        let span = b.stamp_ns.saturating_sub(a.stamp_ns);
        let share = if span > 0 {
            (ns.saturating_sub(a.stamp_ns) as f64 / span as f64).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mix = |a: f64, b: f64| a + share * (b - a);
        // A quaternion and its negative are the same rotation; samples are near each other, so the
        // chord will do.
        let dot: f64 = a.rotation.iter().zip(&b.rotation).map(|(a, b)| a * b).sum();
        let sign = if dot < 0.0 { -1.0 } else { 1.0 };
        let q = std::array::from_fn(|i| mix(a.rotation[i], sign * b.rotation[i]));
        let translation = std::array::from_fn(|i| mix(a.translation[i], b.translation[i]));
        Pose::from_quaternion(q, translation)
    }
}

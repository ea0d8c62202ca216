//! The planner's twin: a small twin beside a twin, with the same skin and the same control points, that
//! moves nearly as the twin does and takes a fraction of its time.
//!
//! The small twin is a separate model, distilled from the twin's motion under sampled actions. Its nodes are
//! some of the twin's nodes, so that a state of the twin is one of the planner's twin by leaving out the
//! others; and each of the twin's nodes is carried by its nodes as a point of a skin is, so that its
//! motion is one of all of the twin's nodes.

use serde::{Deserialize, Serialize};

use crate::{Point, Skin, Twin, geometry::wide, settings::MOST_PLANNER_NODES};

/// A small twin beside a twin.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannersTwin {
    /// Nodes of the small twin, as numbers of nodes of the twin, ascending, shape [n].
    pub nodes: Vec<u32>,
    /// The small twin, without members, appearance and quality. The skin has the M points of the
    /// full twin's skin, then its N nodes; those of them that are also nodes of the small twin
    /// coincide with these.
    pub twin: Box<Twin>,
}

/// Figures of a planner's twin: its size, and its deviation from the exact twin under actions that it
/// was not fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannerQuality {
    /// Number of nodes.
    pub nodes: u32,
    /// Number of springs.
    pub springs: u32,
    /// Number of triplets.
    pub triplets: u32,
    /// Substeps per frame.
    pub substeps: u32,
    /// Distance between a point of the skin here and there, mean over points and frames [m].
    pub mean_deviation_m: f64,
    /// The largest such distance [m].
    pub max_deviation_m: f64,
    /// Scale to compare with: distance of the exact twin's skin from its initial positions, mean over
    /// points and frames [m].
    pub mean_travel_m: f64,
    /// Frames of each window over which this was measured.
    pub frames: u32,
    /// Number of windows of actions over which this was measured.
    pub actions: u32,
}

impl PlannersTwin {
    /// The skin of the twin alone, which has `points` points.
    pub fn own_skin(&self, points: usize) -> Skin {
        let all: Vec<usize> = (0..points).collect();
        self.twin.skin.select(&all)
    }

    /// Positions of the twin's nodes [m], shape [N, 3], from those of the planner's nodes, shape [n, 3];
    /// the twin's skin has `points` points.
    pub fn positions(&self, points: usize, nodes: &[Point]) -> Vec<Point> {
        let skin = &self.twin.skin;
        let at = |i: u32| wide(nodes[i as usize]);
        (points..skin.len()).map(|m| skin.position(m, at).map(|x| x as f32)).collect()
    }

    /// Velocities of the twin's nodes [m/s], from positions and velocities of the planner's.
    pub fn velocities(&self, points: usize, nodes: &[Point], velocities: &[Point]) -> Vec<Point> {
        let skin = &self.twin.skin;
        let (at, moving) =
            (|i: u32| wide(nodes[i as usize]), |i: u32| wide(velocities[i as usize]));
        (points..skin.len()).map(|m| skin.velocity(m, at, moving).map(|x| x as f32)).collect()
    }

    /// Values of the planner's nodes, of those of the twin's nodes.
    pub fn select<T: Copy>(&self, of_nodes: &[T]) -> Vec<T> {
        self.nodes.iter().filter_map(|&i| of_nodes.get(i as usize)).copied().collect()
    }

    /// The planner's node that stands for each node of the twin: itself, or the nearest one at rest;
    /// shape [N]. `rest` has the twin's nodes at rest [m], shape [N, 3].
    pub fn nearest(&self, rest: &[Point]) -> Vec<u32> {
        let own: Vec<Point> = self.select(rest);
        let square = |a: Point, b: Point| -> f32 { (0..3).map(|k| (a[k] - b[k]).powi(2)).sum() };
        let of = |p: &Point| {
            let by_distance = |(_, a): &(u32, &Point), (_, b): &(u32, &Point)| {
                square(**a, *p).total_cmp(&square(**b, *p))
            };
            (0..).zip(&own).min_by(by_distance).map_or(0, |(place, _)| place)
        };
        rest.iter().map(of).collect()
    }

    /// Checks that it is a small twin of a twin.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, of: &Twin) -> Result<(), String> {
        let Twin { graph, skin, timing, members, appearance, planner, .. } = &*self.twin;
        let (n, count) = (of.graph.node_count(), self.nodes.len());
        if count != graph.node_count() {
            return Err(format!("the planner's twin has {} nodes for {count}", graph.node_count()));
        }
        if count > MOST_PLANNER_NODES as usize && count < n {
            return Err(format!(
                "the planner's twin has {count} nodes, at most {MOST_PLANNER_NODES} are possible"
            ));
        }
        let is_ascending = self.nodes.windows(2).all(|pair| pair[0] < pair[1]);
        if !is_ascending || self.nodes.last().is_some_and(|&last| last as usize >= n) {
            return Err(format!("the planner's nodes are not ascending nodes of {n}"));
        }
        let there = [of.graph.control_count(), of.graph.rods.len(), of.skin.len() + n];
        let here = [graph.control_count(), graph.rods.len(), skin.len()];
        if there != here {
            return Err(format!(
                "the planner's twin has {here:?} control points, rods and skin points: it needs {there:?}"
            ));
        }
        if timing.fps.to_bits() != of.timing.fps.to_bits() {
            return Err(format!("the planner's twin has {} frames per second", timing.fps));
        }
        if !members.is_empty() || appearance.is_some() || planner.is_some() {
            return Err(
                "the planner's twin has members, an appearance or its own planner's twin".into()
            );
        }
        Ok(())
    }
}

impl PlannerQuality {
    /// Mean deviation over mean travel; 0 where nothing travels.
    pub fn share_of_travel(&self) -> f64 {
        if self.mean_travel_m > 0.0 { self.mean_deviation_m / self.mean_travel_m } else { 0.0 }
    }

    /// Checks that its numbers are possible for a planner's twin.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, of: &Twin) -> Result<(), String> {
        let graph = &of.graph;
        let there = [graph.node_count(), graph.springs.len(), graph.triplets.len()];
        let here = [self.nodes, self.springs, self.triplets].map(|n| n as usize);
        if here != there || self.substeps != of.timing.substeps {
            return Err("the figures of the planner's twin are not those of its file".into());
        }
        let lengths = [self.mean_deviation_m, self.max_deviation_m, self.mean_travel_m];
        match lengths.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
            Some(x) => Err(format!("the planner's twin deviates by {x}: it must be finite")),
            None => Ok(()),
        }
    }
}

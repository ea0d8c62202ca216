//! An observation beside a twin: what its points should be on, and how far they are from it. Tracks
//! are points that nodes carry; a cloud is matched with the points of the twin's skin, because the
//! nodes of a coarse twin are as far from its surface as from each other.

use bendtwin_core::{
    Graph, Point, Skin,
    geometry::{biweight, median, vector3},
};
use nalgebra::Vector3;

use crate::{
    Error, Observation,
    elastic::{Elastic, Match, Matches},
    rigid::thinned,
    surface::{Surface, spacing},
};

/// Points of a skin that clouds are matched with, at most; of more, evenly chosen ones.
const MOST: usize = 10_000;
/// Distance from which a point counts as astray, in deviations and in medians.
const ASTRAY: [f64; 2] = [6.0, 5.0];

/// The part of a skin that clouds are matched with.
#[derive(Debug)]
pub(crate) struct MatchedSkin {
    pub(crate) skin: Skin,
    /// Distance of its neighbouring points at rest [m].
    pub(crate) spacing_m: f64,
}

impl MatchedSkin {
    /// The skin of a graph, matched with at most [`MOST`] points.
    pub(crate) fn new(graph: &Graph, skin: &Skin) -> Self {
        let all: Vec<usize> = (0..skin.len()).collect();
        let skin = skin.select(&thinned(&all, MOST));
        let spacing_m = spacing(&skin.positions(&graph.rest_positions));
        Self { skin, spacing_m }
    }

    /// Positions of its points when endpoints are at `x` [m].
    pub(crate) fn positions(&self, x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        (0..self.skin.len()).map(|p| position(&self.skin, p, x)).collect()
    }

    /// Surface with points at these positions [m].
    pub(crate) fn surface(&self, positions: &[Vector3<f64>]) -> Result<Surface, Error> {
        Surface::new(positions, self.spacing_m)
            .ok_or_else(|| Error::Invalid("the twin has no skin, or it is not finite".into()))
    }
}

/// Distance of neighbouring nodes of the surface at rest [m].
pub(crate) fn node_spacing(graph: &Graph) -> f64 {
    spacing(&graph.rest_positions[..graph.surface_count()])
}

/// Position of a point that nodes carry [m].
pub(crate) fn position(skin: &Skin, p: usize, x: &[Vector3<f64>]) -> Vector3<f64> {
    skin.position(p, |n| x[n as usize].into()).into()
}

/// Offset of a point from the combination of its nodes, turned as in the current state [m].
fn offset(skin: &Skin, p: usize, x: &[Vector3<f64>]) -> Vector3<f64> {
    skin.offset(p, |n| x[n as usize].into()).into()
}

/// An observation beside a graph.
pub(crate) struct Matcher<'a> {
    pub(crate) graph: &'a Graph,
    /// Skin that a cloud is matched with; tracks do without.
    pub(crate) skin: Option<&'a MatchedSkin>,
    pub(crate) observation: &'a Observation,
}

impl<'a> Matcher<'a> {
    /// The observed points with what they should be on, now that endpoints are at `x`: the places
    /// of tracks, or the nearest points of the skin. Weighted so that points astray of the others
    /// count little.
    pub(crate) fn matches(&self, x: &[Vector3<f64>], noise_m: f64) -> Result<Matches<'a>, Error> {
        let points = &self.observation.points;
        let (mut list, mut distances) =
            (Vec::with_capacity(points.len()), Vec::with_capacity(points.len()));
        let mut push = |p: usize, points, weights, offset: Vector3<f64>, distance_m: f64| {
            let target = vector3(self.observation.points[p]) - offset;
            let precision = self.observation.weight(p) / (noise_m * noise_m);
            list.push(Match { points, weights, target, precision });
            distances.push(distance_m);
        };
        let skin = match &self.observation.tracks {
            Some(tracks) => {
                for (p, y) in points.iter().enumerate() {
                    let distance_m = (position(tracks, p, x) - vector3(*y)).norm();
                    let offset = offset(tracks, p, x);
                    push(p, [p as u32, 0, 0], [1.0, 0.0, 0.0], offset, distance_m);
                }
                tracks
            }
            None => {
                let matched = self.matched()?;
                let surface = matched.surface(&matched.positions(x))?;
                for (p, y) in points.iter().enumerate() {
                    let foot = surface.foot(*y);
                    let offset = foot.corners().map(|(p, b)| offset(&matched.skin, p, x) * b).sum();
                    push(p, foot.points, foot.weights, offset, foot.distance_m);
                }
                &matched.skin
            }
        };
        let middle = median(&mut distances.clone()).unwrap_or(0.0);
        let width = (ASTRAY[0] * noise_m).max(ASTRAY[1] * middle);
        for (m, d) in list.iter_mut().zip(&distances) {
            m.precision *= biweight(d / width);
        }
        let mut matches = Matches { skin, list };
        self.share(&mut matches, noise_m);
        Ok(matches)
    }

    fn matched(&self) -> Result<&'a MatchedSkin, Error> {
        self.skin.ok_or_else(|| Error::Invalid("a cloud needs the twin's skin".into()))
    }

    /// Lets points that are dense share what they know: their errors are not independent, so that
    /// all points around a node weigh no more than a few.
    fn share(&self, matches: &mut Matches<'_>, noise_m: f64) {
        const MOST_AROUND: f64 = 4.0;
        let Matches { skin, list } = matches;
        let mut on_points = vec![0.0; skin.len()];
        for m in &*list {
            m.corners().for_each(|(p, b)| on_points[p] += m.precision * b * noise_m * noise_m);
        }
        // Weights beyond a skin's nodes are negative for some: a node counts by their size.
        let size = |p: usize| skin.weights_of(p).map(|(_, w)| f64::from(w.abs())).sum::<f64>();
        let sizes: Vec<f64> = (0..skin.len()).map(size).collect();
        let mut load = vec![0.0; self.graph.node_count()];
        for p in 0..skin.len() {
            for (n, w) in skin.weights_of(p) {
                load[n as usize] += on_points[p] * f64::from(w.abs()) / sizes[p];
            }
        }
        for (p, around) in on_points.iter_mut().enumerate() {
            let weights = skin.weights_of(p);
            *around = weights.map(|(n, w)| load[n as usize] * f64::from(w.abs()) / sizes[p]).sum();
        }
        for m in list {
            let around: f64 = m.corners().map(|(p, b)| on_points[p] * b).sum();
            m.precision *= (MOST_AROUND / around.max(1e-12)).min(1.0);
        }
    }

    /// Distances of the observed points [m].
    pub(crate) fn distances(&self, x: &[Vector3<f64>]) -> Result<Vec<f64>, Error> {
        let points = &self.observation.points;
        Ok(match &self.observation.tracks {
            Some(tracks) => {
                let distance =
                    |(p, y): (usize, &Point)| (position(tracks, p, x) - vector3(*y)).norm();
                points.iter().enumerate().map(distance).collect()
            }
            None => {
                let matched = self.matched()?;
                let surface = matched.surface(&matched.positions(x))?;
                points.iter().map(|p| surface.foot(*p).distance_m).collect()
            }
        })
    }

    /// The change of the nodes' velocities that the observed velocities, of a deviation of `noise`
    /// [m/s], ask for [m/s], shape [N + C]; `None` without them. `give` is that of the springs by
    /// the deviation of a point [1/m].
    pub(crate) fn velocity_change(
        &self,
        elastic: &Elastic,
        velocities: &[Point],
        noise: f64,
        give: f64,
    ) -> Option<Vec<Vector3<f64>>> {
        let observed = &self.observation.velocities;
        let skin = self.observation.tracks.as_ref().filter(|_| !observed.is_empty())?;
        let mut list = Vec::with_capacity(observed.len());
        let mut sizes = Vec::with_capacity(observed.len());
        for (p, wanted) in observed.iter().enumerate() {
            let own = skin.combined(p, |n| velocities[n as usize].map(f64::from));
            let target = vector3(*wanted) - Vector3::from(own);
            sizes.push(target.norm());
            let precision = self.observation.weight(p) / (noise * noise);
            let (points, weights) = ([p as u32, 0, 0], [1.0, 0.0, 0.0]);
            list.push(Match { points, weights, target, precision });
        }
        let middle = median(&mut sizes.clone()).unwrap_or(0.0);
        let width = (ASTRAY[0] * noise).max(ASTRAY[1] * middle);
        for (m, size) in list.iter_mut().zip(&sizes) {
            m.precision *= biweight(size / width);
        }
        let mut matches = Matches { skin, list };
        self.share(&mut matches, noise);
        // The field's springs are in metres: a second turns their deviations into velocities.
        Some(elastic.field(&matches, give * noise))
    }
}

#[cfg(test)]
mod tests;

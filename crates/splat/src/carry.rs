//! Gaussians that the nodes of a twin carry.
//!
//! A mean is a point of a skin. The rotation of a Gaussian is a blend of those of its nodes, and a
//! node's is the one nearest to how its springs have turned since rest. Nothing is kept from frame
//! to frame: any frame stands by itself.

mod rotation;

use bendtwin_core::{
    Graph, Point, Skin,
    geometry::{Vector, add, scaled, sub, wide},
};
use rayon::prelude::*;

use self::rotation::{multiply, nearest_rotation, turn, turn_back};
use crate::{Error, Gaussians, GaussiansBar};

/// Nodes or Gaussians that a thread takes at a time.
const PIECE: usize = 256;

/// A binding of Gaussians to nodes. G is the number of Gaussians, N that of nodes.
#[derive(Clone, Debug)]
pub struct Carrier {
    skin: Skin,
    /// Rest positions of nodes [m], shape [N].
    rest: Vec<Vector>,
    /// First neighbour of each node, and the end of the last, shape [N + 1].
    starts: Vec<usize>,
    /// Nodes that springs join to each.
    neighbours: Vec<u32>,
    /// Bound means at rest [m], shape [G, 3].
    means_m: Vec<Vector>,
}

/// The motion of bound Gaussians from rest to a frame. G is their number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Carried {
    /// Bound means in the frame [m], shape [G, 3].
    pub means_m: Vec<[f32; 3]>,
    /// Rotations from rest as unit quaternions x, y, z, w, shape [G, 4].
    pub rotations: Vec<[f32; 4]>,
    /// Bound means at rest [m], shape [G, 3].
    pub rest_means_m: Vec<[f32; 3]>,
}

impl Carrier {
    /// Gaussians whose means are the points of a skin, on the nodes of a graph.
    ///
    /// # Errors
    /// [`Error::Carrier`] if the graph contradicts itself, or the skin does not fit it.
    pub fn new(graph: &Graph, skin: &Skin) -> Result<Self, Error> {
        graph.check().map_err(Error::Carrier)?;
        let n = graph.node_count();
        skin.check(n).map_err(Error::Carrier)?;
        let mut ends: Vec<[u32; 2]> = Vec::with_capacity(2 * graph.springs.len());
        for &[a, b] in graph.springs.iter().filter(|s| s.iter().all(|&e| (e as usize) < n)) {
            ends.extend([[a, b], [b, a]]);
        }
        ends.sort_unstable();
        ends.dedup();
        let starts = (0..=n).map(|i| ends.partition_point(|e| (e[0] as usize) < i)).collect();
        let rest: Vec<Vector> = graph.rest_positions.iter().map(|&x| wide(x)).collect();
        let means_m = (0..skin.len()).map(|g| skin.position(g, |i| rest[i as usize])).collect();
        Ok(Self {
            skin: skin.clone(),
            rest,
            starts,
            neighbours: ends.iter().map(|e| e[1]).collect(),
            means_m,
        })
    }

    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.skin.len()
    }

    /// True without Gaussians.
    pub fn is_empty(&self) -> bool {
        self.skin.is_empty()
    }

    /// The motion to a frame with nodes at these places [m], shape [N, 3].
    ///
    /// # Errors
    /// [`Error::Carrier`] if there are not N nodes, or one is not at a finite place.
    pub fn at(&self, nodes: &[Point]) -> Result<Carried, Error> {
        let expected = self.rest.len();
        if nodes.len() != expected {
            return Err(Error::Carrier(format!("{} positions for {expected} nodes", nodes.len())));
        }
        if let Some(i) = nodes.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
            return Err(Error::Carrier(format!("node {i} is at {:?}", nodes[i])));
        }
        let turns: Vec<[f64; 4]> = (0..nodes.len())
            .into_par_iter()
            .with_min_len(PIECE)
            .map(|i| self.node_rotation(nodes, i))
            .collect();
        let place = |i: u32| wide(nodes[i as usize]);
        let carried: Vec<([f32; 3], [f32; 4])> = (0..self.len())
            .into_par_iter()
            .with_min_len(PIECE)
            .map(|g| {
                let mean = self.skin.position(g, place).map(|x| x as f32);
                (mean, self.blend(&turns, g).map(|x| x as f32))
            })
            .collect();
        let (means_m, rotations) = carried.into_iter().unzip();
        let rest_means_m = self.means_m.iter().map(|m| m.map(|x| x as f32)).collect();
        Ok(Carried { means_m, rotations, rest_means_m })
    }

    /// The rotation nearest to A = Σ_j (x_j - x_i) (X_j - X_i)^T over the neighbours j of node i,
    /// with the rest positions X.
    fn node_rotation(&self, nodes: &[Point], i: usize) -> [f64; 4] {
        let mut sum = [[0.0; 3]; 3];
        for &j in &self.neighbours[self.starts[i]..self.starts[i + 1]] {
            let now = sub(wide(nodes[j as usize]), wide(nodes[i]));
            let rest = sub(self.rest[j as usize], self.rest[i]);
            for (row, x) in sum.iter_mut().zip(now) {
                *row = add(*row, scaled(rest, x));
            }
        }
        nearest_rotation(&sum)
    }

    /// Mean of the rotations of a Gaussian's nodes by the absolute values of their weights, each
    /// with the sign that is nearer to the first one's.
    fn blend(&self, turns: &[[f64; 4]], g: usize) -> [f64; 4] {
        let mut weights = self.skin.weights_of(g);
        let Some((first, weight)) = weights.next() else { return rotation::IDENTITY };
        let first = turns[first as usize];
        let mut sum = first.map(|x| x * f64::from(weight.abs()));
        for (node, weight) in weights {
            let turn = turns[node as usize];
            let along: f64 = (0..4).map(|k| turn[k] * first[k]).sum();
            let weight = f64::from(weight.abs()).copysign(along);
            (0..4).for_each(|k| sum[k] += weight * turn[k]);
        }
        rotation::normalized(sum).unwrap_or(first)
    }
}

impl Carried {
    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.means_m.len()
    }

    /// True without Gaussians.
    pub fn is_empty(&self) -> bool {
        self.means_m.is_empty()
    }

    /// Gaussians of the frame, from those at rest. The difference between a mean and the bound one,
    /// which training makes, turns with the Gaussian.
    ///
    /// # Errors
    /// [`Error::Lengths`] if there are not as many as were bound.
    pub fn place(&self, rest: &Gaussians) -> Result<Gaussians, Error> {
        self.expect(rest.means_m.len(), "means of Gaussians")?;
        self.expect(rest.rotations.len(), "rotations of Gaussians")?;
        let mean = |g: usize| {
            let off = [0, 1, 2].map(|k| rest.means_m[g][k] - self.rest_means_m[g][k]);
            let off = turn(self.rotations[g], off);
            [0, 1, 2].map(|k| self.means_m[g][k] + off[k])
        };
        Ok(Gaussians {
            means_m: self.each(mean),
            rotations: self.each(|g| multiply(self.rotations[g], rest.rotations[g])),
            scales_m: rest.scales_m.clone(),
            opacities: rest.opacities.clone(),
            colors: rest.colors.clone(),
        })
    }

    /// Adjoint of [`Carried::place`]: d loss / d Gaussians at rest from those by Gaussians of the
    /// frame, for fixed nodes.
    ///
    /// # Errors
    /// [`Error::Lengths`] if there are not as many as were bound.
    pub fn adjoint(&self, bar: &GaussiansBar) -> Result<GaussiansBar, Error> {
        self.expect(bar.means_m.len(), "derivatives by means of Gaussians")?;
        self.expect(bar.rotations.len(), "derivatives by rotations of Gaussians")?;
        let conjugate = |[x, y, z, w]: [f32; 4]| [-x, -y, -z, w];
        Ok(GaussiansBar {
            means_m: self.each(|g| turn_back(self.rotations[g], bar.means_m[g])),
            // A product with a unit quaternion is a rotation of four numbers, its adjoint the
            // product with the inverse.
            rotations: self.each(|g| multiply(conjugate(self.rotations[g]), bar.rotations[g])),
            scales_m: bar.scales_m.clone(),
            opacities: bar.opacities.clone(),
            colors: bar.colors.clone(),
            screen: bar.screen.clone(),
        })
    }

    /// A value for each Gaussian.
    fn each<T: Send>(&self, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
        (0..self.len()).into_par_iter().with_min_len(PIECE).map(of).collect()
    }

    fn expect(&self, got: usize, what: &'static str) -> Result<(), Error> {
        let expected = self.len();
        let is_right = got == expected;
        is_right.then_some(()).ok_or(Error::Lengths { expected, of: "bound Gaussians", got, what })
    }
}

#[cfg(test)]
mod tests;

//! The skin of a twin: points of its surface, finer than its nodes, which the nodes carry.
//!
//! A point is at p = Σ w_i x_i + o: a fixed affine combination of nodes (Σ w_i = 1), and an offset
//! that is constant in a frame of three of them. The offset of a point with nodes all around is
//! zero, and every affine motion of the nodes, a rotation included, carries the point exactly.
//! Nodes in a plane or on a line do not say how far beside it the point is: the rest is the offset.
//!
//! The frame of nodes a, b, c has the axes e1 along b - a, n along (b - a) × (c - a), and
//! e2 = n × e1.

use crate::{
    Graph, Point,
    geometry::{Vector, add, cross, dot, length, scaled, sub, wide},
};

/// Shorter edges [m] give a frame no direction.
const LEAST_M: f64 = 1e-12;
/// Sine of the angle between a frame's edges up to which its nodes span no triangle. Rounding in
/// single precision gives nodes on a line a sine of 1e-7 and any direction.
pub const LEAST_SINE: f64 = 1e-4;

/// Points of a surface that nodes carry. M is their number, K that of all weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// The capture's observed point for each point, shape [M]; [`Graph::NOT_OBSERVED`] for points
    /// without one.
    pub observed_points: Vec<u32>,
    /// First weight of each point, and the end of the last, shape [M + 1].
    pub starts: Vec<u32>,
    /// Node of each weight, shape [K].
    pub nodes: Vec<u32>,
    /// Weights, shape [K]; those of a point sum up to 1.
    pub weights: Vec<f32>,
    /// Nodes a, b, c of each point's frame, shape [M]; all of them [`Skin::NO_FRAME`] where the
    /// offset is along the axes of the world.
    pub frames: Vec<[u32; 3]>,
    /// Offset of each point along the axes of its frame [m], shape [M, 3].
    pub offsets_m: Vec<Point>,
}

/// Axes of a frame, with what their derivatives need.
struct Axes {
    axes: [Vector; 3],
    /// b - a and c - a [m].
    edges: [Vector; 2],
    /// Length of b - a [m], and of (b - a) × (c - a) [m²].
    lengths: [f64; 2],
}

impl Skin {
    /// Marks a point whose offset has no frame.
    pub const NO_FRAME: u32 = u32::MAX;
    /// Share of a point's largest weight from which on a node bears the point.
    pub const BEARING: f32 = 0.25;
    /// Most weights of a point, which bounds the work of placing it.
    pub const MOST_WEIGHTS: usize = 64;

    /// The skin that is the surface nodes of a graph themselves.
    pub fn of_nodes(graph: &Graph) -> Self {
        // A graph that is read from a file is checked later.
        let m = graph.surface_count().min(graph.observed_points.len());
        let nodes: Vec<u32> = (0..m as u32).collect();
        Self { observed_points: graph.observed_points[..m].to_vec(), ..Self::at_nodes(&nodes) }
    }

    /// Points that coincide with nodes, in this order, none of them observed.
    pub fn at_nodes(nodes: &[u32]) -> Self {
        let m = nodes.len();
        Self {
            observed_points: vec![Graph::NOT_OBSERVED; m],
            starts: (0..=m as u32).collect(),
            nodes: nodes.to_vec(),
            weights: vec![1.0; m],
            frames: vec![[Self::NO_FRAME; 3]; m],
            offsets_m: vec![[0.0; 3]; m],
        }
    }

    /// Some of the points, in this order; indices that do not exist are left out.
    #[must_use]
    pub fn select(&self, points: &[usize]) -> Self {
        let mut chosen = Self::default();
        for &p in points.iter().filter(|p| **p < self.len()) {
            let weights: Vec<(u32, f32)> = self.weights_of(p).collect();
            chosen.push(self.observed_points[p], &weights, self.frames[p], self.offsets_m[p]);
        }
        chosen
    }

    /// Number of points M.
    pub fn len(&self) -> usize {
        self.observed_points.len()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.observed_points.is_empty()
    }

    /// True if its points are the surface nodes of a graph, in their order.
    pub fn is_nodes(&self, graph: &Graph) -> bool {
        self.len() == graph.surface_count() && *self == Self::of_nodes(graph)
    }

    /// Adds a point: the observed point that it is, its weights by node, and its offset in a frame.
    pub fn push(
        &mut self,
        observed_point: u32,
        weights: &[(u32, f32)],
        frame: [u32; 3],
        offset_m: Point,
    ) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.observed_points.push(observed_point);
        self.nodes.extend(weights.iter().map(|w| w.0));
        self.weights.extend(weights.iter().map(|w| w.1));
        self.starts.push(self.nodes.len() as u32);
        self.frames.push(frame);
        self.offsets_m.push(offset_m);
    }

    /// Adds the points of another skin of the same nodes.
    pub fn append(&mut self, other: &Self) {
        for p in 0..other.len() {
            let weights: Vec<(u32, f32)> = other.weights_of(p).collect();
            self.push(other.observed_points[p], &weights, other.frames[p], other.offsets_m[p]);
        }
    }

    /// Node and weight of each weight of a point.
    pub fn weights_of(&self, point: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let own = self.starts[point] as usize..self.starts[point + 1] as usize;
        self.nodes[own.clone()].iter().copied().zip(self.weights[own].iter().copied())
    }

    /// Position of a point [m], from those of nodes.
    pub fn position(&self, point: usize, node: impl Fn(u32) -> Vector) -> Vector {
        add(self.combined(point, &node), self.offset(point, node))
    }

    /// Combination of a quantity of the nodes by the weights of a point.
    pub fn combined(&self, point: usize, node: impl Fn(u32) -> Vector) -> Vector {
        let weights = self.weights_of(point);
        weights.fold([0.0; 3], |sum, (i, w)| add(sum, scaled(node(i), f64::from(w))))
    }

    /// Offset of a point from the combination of its nodes' positions [m], along the axes of the
    /// world.
    pub fn offset(&self, point: usize, node: impl Fn(u32) -> Vector) -> Vector {
        let offset = wide(self.offsets_m[point]);
        if offset == [0.0; 3] {
            return offset;
        }
        let Some(nodes) = self.frame(point) else { return offset };
        let Some(Axes { axes, .. }) = Axes::of(nodes.map(node)) else { return [0.0; 3] };
        axes.iter().zip(offset).fold([0.0; 3], |sum, (axis, o)| add(sum, scaled(*axis, o)))
    }

    /// Positions of all points [m], shape [M, 3], from those of nodes, shape [N, 3].
    pub fn positions(&self, nodes: &[Point]) -> Vec<Point> {
        let node = |i: u32| wide(nodes[i as usize]);
        (0..self.len()).map(|m| self.position(m, node).map(|x| x as f32)).collect()
    }

    /// Velocity of a point [m/s], from positions and velocities of nodes: the derivative of
    /// [`Skin::position`] by time.
    pub fn velocity(
        &self,
        point: usize,
        node: impl Fn(u32) -> Vector,
        velocity: impl Fn(u32) -> Vector,
    ) -> Vector {
        let mut sum = [0.0; 3];
        for (i, w) in self.weights_of(point) {
            sum = add(sum, scaled(velocity(i), f64::from(w)));
        }
        let offset = wide(self.offsets_m[point]);
        let Some(nodes) = self.frame(point).filter(|_| offset != [0.0; 3]) else { return sum };
        let Some(axes) = Axes::of(nodes.map(node)) else { return sum };
        let rates = axes.rates(nodes.map(velocity));
        rates.iter().zip(offset).fold(sum, |v, (rate, o)| add(v, scaled(*rate, o)))
    }

    /// Nodes that carry a point or span its frame, some of them more than once.
    pub fn carriers(&self, point: usize) -> impl Iterator<Item = u32> + '_ {
        let frame = self.frame(point).into_iter().flatten();
        self.weights_of(point).map(|(i, _)| i).chain(frame)
    }

    /// Nodes that bear a point: those with at least [`Skin::BEARING`] of its largest weight.
    pub fn bearers(&self, point: usize) -> impl Iterator<Item = u32> + '_ {
        let largest = self.weights_of(point).map(|(_, w)| w).fold(0.0, f32::max);
        let least = Self::BEARING * largest;
        self.weights_of(point).filter(move |(_, w)| *w > 0.0 && *w >= least).map(|(i, _)| i)
    }

    /// Passes d loss / d position of a point on to its nodes: `add_to` is called with a node and
    /// its share, more than once for some.
    pub fn add_gradient(
        &self,
        point: usize,
        node: impl Fn(u32) -> Vector,
        bar: Vector,
        mut add_to: impl FnMut(u32, Vector),
    ) {
        for (i, w) in self.weights_of(point) {
            add_to(i, scaled(bar, f64::from(w)));
        }
        let offset = wide(self.offsets_m[point]);
        let Some(nodes) = self.frame(point).filter(|_| offset != [0.0; 3]) else { return };
        let Some(axes) = Axes::of(nodes.map(node)) else { return };
        for (i, bar) in nodes.into_iter().zip(axes.node_bars(offset, bar)) {
            add_to(i, bar);
        }
    }

    /// Nodes of a point's frame, if it has one.
    fn frame(&self, point: usize) -> Option<[u32; 3]> {
        Some(self.frames[point]).filter(|f| f[0] != Self::NO_FRAME)
    }

    /// Checks that lengths agree, nodes exist, numbers are finite and weights sum up to 1.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, node_count: usize) -> Result<(), String> {
        let m = self.len();
        if m == 0 && self.starts.len() <= 1 && self.nodes.is_empty() && self.weights.is_empty() {
            return Ok(());
        }
        let lengths = [
            ("starts of weights", self.starts.len().wrapping_sub(1)),
            ("frames", self.frames.len()),
            ("offsets", self.offsets_m.len()),
        ];
        if let Some((what, len)) = lengths.into_iter().find(|(_, len)| *len != m) {
            return Err(format!("{m} skin points but {len} {what}"));
        }
        let ends = [self.starts[0], self.starts[m]].map(|s| s as usize);
        if !self.starts.is_sorted()
            || ends != [0, self.nodes.len()]
            || self.nodes.len() != self.weights.len()
        {
            return Err(format!(
                "{} nodes and {} weights do not divide among {m} skin points",
                self.nodes.len(),
                self.weights.len()
            ));
        }
        if let Some(node) = self.nodes.iter().find(|&&i| i as usize >= node_count) {
            return Err(format!("a skin point is carried by node {node} of {node_count} nodes"));
        }
        for point in 0..m {
            let sum: f64 = self.weights_of(point).map(|(_, w)| f64::from(w)).sum();
            let off = (sum - 1.0).abs();
            if off.is_nan() || off >= 1e-3 {
                return Err(format!("the weights of skin point {point} sum up to {sum}, not to 1"));
            }
            let (count, most) = (self.weights_of(point).count(), Self::MOST_WEIGHTS);
            if count > most {
                return Err(format!(
                    "skin point {point} has {count} weights, at most {most} may be"
                ));
            }
            let frame = self.frames[point];
            let has_frame = frame != [Self::NO_FRAME; 3];
            if has_frame && frame.iter().any(|&i| i as usize >= node_count) {
                return Err(format!("the frame of skin point {point} is of nodes {frame:?}"));
            }
        }
        if !self.weights.iter().chain(self.offsets_m.iter().flatten()).all(|x| x.is_finite()) {
            return Err("a weight or an offset of the skin is not finite".into());
        }
        Ok(())
    }
}

/// Offset of a point from its weighted mean along the axes of a frame of three nodes at these
/// places [m]; `None` if they have no frame.
pub fn offset_in_frame(nodes: [Vector; 3], offset: Vector) -> Option<Vector> {
    Axes::of(nodes).map(|a| a.axes.map(|axis| dot(axis, offset)))
}

impl Axes {
    /// `None` if the nodes span no triangle.
    fn of([a, b, c]: [Vector; 3]) -> Option<Self> {
        let edges = [sub(b, a), sub(c, a)];
        let normal = cross(edges[0], edges[1]);
        let lengths = [length(edges[0]), length(normal)];
        let sides = lengths[0] * length(edges[1]);
        if !(lengths[0] > LEAST_M && lengths[1] > LEAST_SINE * sides) {
            return None;
        }
        let e1 = scaled(edges[0], 1.0 / lengths[0]);
        let n = scaled(normal, 1.0 / lengths[1]);
        Some(Self { axes: [e1, cross(n, e1), n], edges, lengths })
    }

    /// Derivatives of the axes by time, from the velocities of nodes a, b, c.
    fn rates(&self, [a, b, c]: [Vector; 3]) -> [Vector; 3] {
        let [e1, _, n] = self.axes;
        let [u, v] = self.edges;
        let [u_rate, v_rate] = [sub(b, a), sub(c, a)];
        let e1_rate = of_unit(e1, u_rate, self.lengths[0]);
        let normal_rate = add(cross(u_rate, v), cross(u, v_rate));
        let n_rate = of_unit(n, normal_rate, self.lengths[1]);
        [e1_rate, add(cross(n_rate, e1), cross(n, e1_rate)), n_rate]
    }

    /// Shares of nodes a, b, c in d loss / d position of a point with an offset along the axes.
    fn node_bars(&self, offset: Vector, bar: Vector) -> [Vector; 3] {
        let [e1, _, n] = self.axes;
        let [u, v] = self.edges;
        let e2_bar = scaled(bar, offset[1]);
        let e1_bar = add(scaled(bar, offset[0]), cross(e2_bar, n));
        let n_bar = add(scaled(bar, offset[2]), cross(e1, e2_bar));
        let normal_bar = of_unit(n, n_bar, self.lengths[1]);
        let u_bar = add(of_unit(e1, e1_bar, self.lengths[0]), cross(v, normal_bar));
        let v_bar = cross(normal_bar, u);
        [scaled(add(u_bar, v_bar), -1.0), u_bar, v_bar]
    }
}

/// A change of the unit vector along a vector of this length, from a change of that; the map is its own
/// adjoint.
fn of_unit(axis: Vector, change: Vector, length: f64) -> Vector {
    scaled(sub(change, scaled(axis, dot(axis, change))), 1.0 / length)
}

#[cfg(test)]
mod tests;

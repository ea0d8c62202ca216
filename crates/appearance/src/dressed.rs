//! A twin with its Gaussians, ready to be drawn in any state of its nodes.

use bendtwin_core::{Appearance, Graph, Point, Splats, Twin, geometry::wide};
use bendtwin_splat::{Carried, Carrier, Gaussians};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::Error;

/// Neighbours of a skin point that give its Gaussian a size.
const NEIGHBOURS: usize = 4;
/// Standard deviation of a skin point's Gaussian over the mean distance of its neighbours: so large
/// that there are no gaps between them.
const SPREAD: f32 = 0.55;
/// Opacity of a skin point's Gaussian.
const OPACITY: f32 = 0.95;
/// Least standard deviation [m].
const LEAST_M: f32 = 2e-4;

/// Gaussians and the nodes that carry them.
#[derive(Clone, Debug)]
pub struct Dressed {
    carrier: Carrier,
    rest: Gaussians,
}

impl Dressed {
    /// Splats on the nodes of a graph.
    ///
    /// # Errors
    /// If they do not fit it.
    pub fn new(graph: &Graph, splats: &Splats) -> Result<Self, Error> {
        let carrier = Carrier::new(graph, &splats.carriers)?;
        let rest = Gaussians {
            means_m: splats.carriers.positions(&graph.rest_positions),
            scales_m: splats.scales_m.clone(),
            rotations: splats.rotations.clone(),
            opacities: splats.opacities.clone(),
            colors: splats.colors.clone(),
        };
        Ok(Self { carrier, rest })
    }

    /// The Gaussians of a twin in an appearance; without any, its skin in the colours of the appearance.
    ///
    /// # Errors
    /// If they do not fit the twin.
    pub fn in_appearance(twin: &Twin, appearance: &Appearance) -> Result<Self, Error> {
        match &appearance.splats {
            Some(splats) => Self::new(&twin.graph, splats),
            None => Self::new(&twin.graph, &of_skin(twin, &appearance.skin_colors)),
        }
    }

    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// True without Gaussians.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// The Gaussians at rest.
    pub fn rest(&self) -> &Gaussians {
        &self.rest
    }

    /// The motion from rest to a frame with nodes at these places [m], shape [N, 3].
    ///
    /// # Errors
    /// If there are not N nodes, or one is not at a finite place.
    pub fn carried(&self, nodes: &[Point]) -> Result<Carried, Error> {
        Ok(self.carrier.at(nodes)?)
    }

    /// The Gaussians with nodes at these places [m], shape [N, 3].
    ///
    /// # Errors
    /// Those of [`Dressed::carried`].
    pub fn at(&self, nodes: &[Point]) -> Result<Gaussians, Error> {
        Ok(self.carried(nodes)?.place(&self.rest)?)
    }
}

/// A round Gaussian for each point of a twin's skin, in its colour; grey without colours.
pub(crate) fn of_skin(twin: &Twin, colors: &[[u8; 3]]) -> Splats {
    let means = twin.skin.positions(&twin.graph.rest_positions);
    let color = |p: usize| colors.get(p).map_or([0.5; 3], |c| c.map(|x| f32::from(x) / 255.0));
    Splats {
        carriers: twin.skin.clone(),
        scales_m: spacings(&means).into_iter().map(|s| [(SPREAD * s).max(LEAST_M); 3]).collect(),
        rotations: vec![[0.0, 0.0, 0.0, 1.0]; means.len()],
        opacities: vec![OPACITY; means.len()],
        colors: (0..means.len()).map(color).collect(),
    }
}

/// Mean distance of each point from its neighbours [m], shape [M]; 0 for a lone one.
pub(crate) fn spacings(points: &[Point]) -> Vec<f32> {
    let Ok(tree) = ImmutableKdTree::<f32, 3>::new_from_slice(points) else {
        return vec![0.0; points.len()];
    };
    // The point itself is among them.
    let count = std::num::NonZero::new(NEIGHBOURS + 1).unwrap_or(std::num::NonZero::<usize>::MIN);
    let of = |p: &Point| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f32>>(count).execute();
        let sum: f32 = found.iter().map(|n| n.distance.sqrt()).sum();
        sum / found.len().saturating_sub(1).max(1) as f32
    };
    points.iter().map(of).collect()
}

/// Largest distance of two points' coordinates [m].
pub(crate) fn extent_m(points: &[Point]) -> f32 {
    let ends = |axis: usize| {
        let values = points.iter().map(|p| wide(*p)[axis]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
    };
    (0..3).map(ends).map(|(low, high)| (high - low) as f32).fold(0.0, f32::max)
}

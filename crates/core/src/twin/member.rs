//! Other fits of a twin's object.

use super::{Provenance, Twin};
use crate::{Environment, Graph, Params, Point, Quality, Timing, geometry::sub};

/// Another fit of a twin's object to the same capture, as far as it differs: it shares the twin's
/// nodes, control points, rods and skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Springs as [`Graph::springs`], shape [E].
    pub springs: Vec<[u32; 2]>,
    /// Triplets as [`Graph::triplets`], shape [T].
    pub triplets: Vec<[u32; 3]>,
    /// Fitted numbers of these springs and triplets, and of the twin's rods.
    pub params: Params,
    /// Gravity and ground.
    pub environment: Environment,
    /// Substeps of a frame.
    pub substeps: u32,
    /// Loss that the fit ended with, by the measure of the twin's; none in files that do not say.
    pub loss: Option<f64>,
}

impl Member {
    /// The member that a fit is of a twin; `None` if it has other nodes, control points, rods,
    /// skin or frame rate.
    pub fn of(fit: &Twin, twin: &Twin) -> Option<Self> {
        let Graph { springs, triplets, .. } = fit.graph.clone();
        let member = Self {
            springs,
            triplets,
            params: fit.params.clone(),
            environment: fit.environment,
            substeps: fit.timing.substeps,
            loss: fit.provenance.loss,
        };
        let again = member.twin(twin);
        let is_same =
            again.graph == fit.graph && again.skin == fit.skin && again.timing == fit.timing;
        is_same.then_some(member)
    }

    /// The graph of this fit of a twin's object.
    pub fn graph(&self, twin: &Graph) -> Graph {
        Graph { springs: self.springs.clone(), triplets: self.triplets.clone(), ..twin.clone() }
    }

    /// This fit as a twin, without members and quality.
    pub fn twin(&self, of: &Twin) -> Twin {
        Twin {
            graph: self.graph(&of.graph),
            skin: of.skin.clone(),
            params: self.params.clone(),
            environment: self.environment,
            timing: Timing { substeps: self.substeps, ..of.timing },
            control_velocity: of.control_velocity,
            provenance: Provenance { loss: self.loss, ..of.provenance.clone() },
            quality: Quality::default(),
            mass_kg: of.mass_kg,
            control_hands: of.control_hands.clone(),
            members: Vec::new(),
            appearance: of.appearance.clone(),
            surface: of.surface.clone(),
            planner: None,
        }
    }
}

/// Spread of several predictions of points, shape [M]: root mean square distance of the others from
/// the first [m]. NaN where one of them is; 0 without others.
pub fn spread(own: &[Point], others: &[&[Point]]) -> Vec<f32> {
    let square = |a: Point, b: Point| {
        let apart = sub(a, b).map(f64::from);
        apart.iter().map(|x| x * x).sum::<f64>()
    };
    let of_point = |(index, point): (usize, &Point)| {
        let at = |other: &&[Point]| other.get(index).map_or(f64::NAN, |p| square(*p, *point));
        (others.iter().map(at).sum::<f64>() / others.len().max(1) as f64).sqrt() as f32
    };
    own.iter().enumerate().map(of_point).collect()
}

#[cfg(test)]
mod tests;

//! The space in which Adam walks: logarithms of stiffnesses, dashpots, dampings, drag and rest lengths
//! (positive, and their scale is unknown), rest angles and contact ratios as they are.

use std::{f64::consts::PI, ops::Range};

use bendtwin_core::{Params, params::MAX_SPRING_STIFFNESS};

use crate::{adam::Decay, task::Task};

/// How far rest lengths may move from where they started (a factor, as a logarithm).
const REST_LENGTH_SPAN: f64 = 0.2;
/// How far rest angles may move from where they started [rad].
const REST_ANGLE_SPAN: f64 = 0.6;
/// A rest length that moves by a percent says as much as a stiffness that moves by a quarter.
const REST_LENGTH_RATE: f64 = 0.04;
/// Rest angles [rad] per unit of learning rate.
const REST_ANGLE_RATE: f64 = 0.3;
/// Smallest positive value that a logarithm is taken of.
const TINY: f64 = 1e-9;

/// A kind of parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Stiffness,
    Dashpot,
    RestLength,
    BendStiffness,
    BendDamping,
    RestAngle,
    Drag,
    GroundRestitution,
    GroundFriction,
    ObjectRestitution,
    ObjectFriction,
}

impl Kind {
    fn is_log(self) -> bool {
        matches!(
            self,
            Self::Stiffness
                | Self::Dashpot
                | Self::RestLength
                | Self::BendStiffness
                | Self::BendDamping
                | Self::Drag
        )
    }

    /// Length of a step relative to the learning rate.
    fn rate(self) -> f64 {
        match self {
            Self::RestLength => REST_LENGTH_RATE,
            Self::RestAngle => REST_ANGLE_RATE,
            _ => 1.0,
        }
    }

    /// The values of this kind; globals as a slice of one.
    fn values(self, p: &Params) -> &[f32] {
        let one = std::slice::from_ref;
        match self {
            Self::Stiffness => &p.spring_stiffness,
            Self::Dashpot => &p.spring_dashpot,
            Self::RestLength => &p.rest_lengths_m,
            Self::BendStiffness => &p.bend_stiffness,
            Self::BendDamping => &p.bend_damping,
            Self::RestAngle => &p.rest_angles_rad,
            Self::Drag => one(&p.drag),
            Self::GroundRestitution => one(&p.contact.ground_restitution),
            Self::GroundFriction => one(&p.contact.ground_friction),
            Self::ObjectRestitution => one(&p.contact.object_restitution),
            Self::ObjectFriction => one(&p.contact.object_friction),
        }
    }

    fn values_mut(self, p: &mut Params) -> &mut [f32] {
        let one = std::slice::from_mut;
        match self {
            Self::Stiffness => &mut p.spring_stiffness,
            Self::Dashpot => &mut p.spring_dashpot,
            Self::RestLength => &mut p.rest_lengths_m,
            Self::BendStiffness => &mut p.bend_stiffness,
            Self::BendDamping => &mut p.bend_damping,
            Self::RestAngle => &mut p.rest_angles_rad,
            Self::Drag => one(&mut p.drag),
            Self::GroundRestitution => one(&mut p.contact.ground_restitution),
            Self::GroundFriction => one(&mut p.contact.ground_friction),
            Self::ObjectRestitution => one(&mut p.contact.object_restitution),
            Self::ObjectFriction => one(&mut p.contact.object_friction),
        }
    }

    /// Where a coordinate that starts at `start` may go.
    fn bounds(self, start: f64, spacing_m: f64) -> [f64; 2] {
        let square = spacing_m * spacing_m;
        let logs = |low: f64, high: f64| [low.ln(), high.ln()];
        let [low, high] = match self {
            Self::Stiffness => logs(1.0, f64::from(MAX_SPRING_STIFFNESS)),
            Self::Dashpot => logs(1e-3, 1e3),
            Self::RestLength => [start - REST_LENGTH_SPAN, start + REST_LENGTH_SPAN],
            Self::BendStiffness => logs(1e-3 * square, 1e6 * square),
            Self::BendDamping => logs(1e-4 * square, 1e4 * square),
            Self::RestAngle => {
                [(start - REST_ANGLE_SPAN).max(0.0), (start + REST_ANGLE_SPAN).min(PI)]
            }
            Self::Drag => logs(1e-3, 50.0),
            Self::GroundRestitution | Self::ObjectRestitution => [0.0, 1.0],
            Self::GroundFriction | Self::ObjectFriction => [0.0, 2.0],
        };
        [low.min(start), high.max(start)]
    }
}

/// The coordinates of one graph's parameters.
pub(crate) struct Coordinates {
    base: Params,
    sections: Vec<(Kind, Range<usize>)>,
    bounds: Vec<[f64; 2]>,
    rates: Vec<f64>,
}

impl Coordinates {
    /// For parameters that start at `base`.
    pub(crate) fn new(task: &Task<'_>, base: Params) -> Self {
        let mut kinds = vec![
            Kind::Stiffness,
            Kind::Dashpot,
            Kind::BendStiffness,
            Kind::BendDamping,
            Kind::Drag,
        ];
        if task.settings.refine.rest_shape {
            kinds.extend([Kind::RestLength, Kind::RestAngle]);
        }
        if task.nears_ground() {
            kinds.extend([Kind::GroundRestitution, Kind::GroundFriction]);
        }
        if task.has_contact() {
            kinds.extend([Kind::ObjectRestitution, Kind::ObjectFriction]);
        }
        let mut this = Self { base, sections: Vec::new(), bounds: Vec::new(), rates: Vec::new() };
        for kind in kinds {
            let first = this.bounds.len();
            for &value in kind.values(&this.base) {
                this.bounds.push(kind.bounds(coordinate(kind, value), task.spacing_m));
                this.rates.push(kind.rate());
            }
            this.sections.push((kind, first..this.bounds.len()));
        }
        this
    }

    pub(crate) fn len(&self) -> usize {
        self.bounds.len()
    }

    /// Where the walk starts.
    pub(crate) fn start(&self) -> Vec<f64> {
        let values = |kind: Kind| kind.values(&self.base).iter().map(move |&v| coordinate(kind, v));
        self.sections.iter().flat_map(|(kind, _)| values(*kind)).collect()
    }

    /// The parameters at a point.
    pub(crate) fn params(&self, theta: &[f64]) -> Params {
        let mut params = self.base.clone();
        for (kind, range) in &self.sections {
            for (value, &x) in kind.values_mut(&mut params).iter_mut().zip(&theta[range.clone()]) {
                *value = if kind.is_log() { x.exp() as f32 } else { x as f32 };
            }
        }
        // Rounding to f32 must not carry an angle above pi.
        let pi = std::f32::consts::PI;
        params.rest_angles_rad.iter_mut().for_each(|a| *a = a.min(pi));
        params
    }

    /// d loss / d theta at `params`, from d loss / d params.
    pub(crate) fn gradient(&self, params: &Params, gradient: &Params) -> Vec<f64> {
        let mut slopes = Vec::with_capacity(self.len());
        for (kind, _) in &self.sections {
            let pairs = kind.values(gradient).iter().zip(kind.values(params));
            slopes.extend(pairs.map(|(&slope, &value)| {
                // d/d ln p = p d/dp.
                let chain = if kind.is_log() { f64::from(value) } else { 1.0 };
                f64::from(slope) * chain
            }));
        }
        slopes
    }

    /// One step of Adam.
    pub(crate) fn step(
        &self,
        adam: &mut crate::adam::Adam,
        theta: &mut [f64],
        gradient: &[f64],
        learning_rate: f64,
        decay: Decay,
    ) {
        let rates: Vec<f64> = self.rates.iter().map(|r| r * learning_rate).collect();
        adam.step(theta, gradient, &rates, &self.bounds, decay);
    }
}

fn coordinate(kind: Kind, value: f32) -> f64 {
    if kind.is_log() { f64::from(value).max(TINY).ln() } else { f64::from(value) }
}

#[cfg(test)]
mod tests;

//! The variables of the search: physical constants of the whole object and, if asked for, the
//! connectivity of its nodes. Every variable is scaled to 0..=1.
//!
//! Stiffness, dashpots, drag and bending are searched in logarithms: what matters is their order of
//! magnitude, and the useful part of a linear scale (PhysTwin's 0..1e5, for example) would be a
//! thin slice at one end. Ratios and lengths are searched directly. Variables without effect on the
//! capture (friction of an object in the air) are left out: each costs the search evaluations.

use std::f64::consts::PI;

use bendtwin_core::{
    Contact, Environment, FitSettings, Params, capture::Subject, environment::ControlVelocity,
    params::MAX_SPRING_STIFFNESS, settings::defaults::SearchOrigin,
};
use bendtwin_graph::Connectivity;

use crate::{built_graph::BuiltGraph, task::Task};

/// Steps of searched radii [m]: finer ones would only make graphs that are equal in all but name.
const RADIUS_STEP_M: f64 = 5e-4;

/// Spring radii that are searched, over the one at the start. A third of the radius that suits the
/// spacing is that to the sixth neighbour, which holds an even body together.
const RADII: [f64; 2] = [1.0 / 3.0, 5.0 / 3.0];

/// Restitution at which the search starts: soft objects hardly bounce, and only a capture with free
/// flight says more.
const SOFT_RESTITUTION: f64 = 0.1;

/// Change of restitution that the prior counts as it does a decade of damping.
const RESTITUTION_DECADE: f64 = 0.25;

/// A quantity that the search varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variable {
    Stiffness,
    Dashpot,
    Drag,
    BendStiffness,
    BendDamping,
    RestBend,
    TwistStiffness,
    TwistDamping,
    RestTwist,
    GroundRestitution,
    GroundFriction,
    ObjectRestitution,
    ObjectFriction,
    CollisionDistance,
    Radius,
    Neighbours,
    ControlRadius,
    ControlNeighbours,
    Gravity,
}

impl std::fmt::Display for Variable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Stiffness => "spring stiffness",
            Self::Dashpot => "spring dashpot",
            Self::Drag => "drag",
            Self::BendStiffness => "bending stiffness",
            Self::BendDamping => "bending damping",
            Self::RestBend => "rest bend",
            Self::TwistStiffness => "twist stiffness",
            Self::TwistDamping => "twist damping",
            Self::RestTwist => "rest twist",
            Self::GroundRestitution => "ground restitution",
            Self::GroundFriction => "ground friction",
            Self::ObjectRestitution => "object restitution",
            Self::ObjectFriction => "object friction",
            Self::CollisionDistance => "collision distance",
            Self::Radius => "spring radius",
            Self::Neighbours => "neighbours",
            Self::ControlRadius => "control radius",
            Self::ControlNeighbours => "control neighbours",
            Self::Gravity => "gravity's strength",
        })
    }
}

/// A variable with its range.
#[derive(Clone, Copy, Debug)]
struct Axis {
    variable: Variable,
    low: f64,
    high: f64,
    start: f64,
    is_log: bool,
}

impl Axis {
    fn log(variable: Variable, low: f64, high: f64, start: f64) -> Self {
        Self { variable, low, high, start, is_log: true }
    }

    /// An axis whose range grows where the start lies outside it, so that a setting is never
    /// overruled.
    fn linear(variable: Variable, low: f64, high: f64, start: f64) -> Self {
        Self { variable, low: low.min(start), high: high.max(start), start, is_log: false }
    }

    fn value(&self, x: f64) -> f64 {
        let value = if self.is_log {
            (self.low.ln() + x * (self.high / self.low).ln()).exp()
        } else {
            self.low + x * (self.high - self.low)
        };
        value.clamp(self.low, self.high)
    }

    fn coordinate(&self) -> f64 {
        let x = if self.is_log {
            (self.start / self.low).ln() / (self.high / self.low).ln()
        } else {
            (self.start - self.low) / (self.high - self.low)
        };
        x.clamp(0.0, 1.0)
    }
}

/// The unit cube that the search explores.
pub(crate) struct Space {
    axes: Vec<Axis>,
    start: Candidate,
}

/// A point of the search space in physical units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) connectivity: Connectivity,
    stiffness: f64,
    dashpot: f64,
    drag: f64,
    bend_stiffness: f64,
    bend_damping: f64,
    /// Share of the measured rest shape's bend; 0 is straight.
    rest_bend: f64,
    twist_stiffness: f64,
    twist_damping: f64,
    rest_twist: f64,
    contact: Contact,
    /// Gravity as a multiple of the capture's.
    gravity: f64,
}

impl Space {
    /// The space of a start of the task, by the start's own settings.
    pub(crate) fn new(task: &Task<'_>, settings: &FitSettings) -> Self {
        use Variable::*;
        let is_cable = task.subject() == Subject::Cable;
        let origin = SearchOrigin::of(task.subject());
        let mut connectivity = Connectivity::from_settings(&settings.graph, settings.bending);
        // Rods twist by how their clamps move.
        connectivity.rods &= settings.control_velocity == ControlVelocity::True;
        let mut axes = vec![
            Axis::log(Stiffness, 1e2, f64::from(MAX_SPRING_STIFFNESS), 3e3),
            Axis::log(Dashpot, 0.1, 300.0, origin.dashpot),
            Axis::log(Drag, 0.01, 20.0, 1.0),
        ];
        if connectivity.triplets.is_some() {
            // A triplet with arms of length l and stiffness k l² resists a sideways
            // displacement as a spring of stiffness k [N/m] would.
            let square = task.spacing_m * task.spacing_m;
            let share = origin.bend_share;
            let (stiffness, damping) = (100.0 * share * square, share * square);
            axes.push(Axis::log(BendStiffness, 0.1 * square, 1e5 * square, stiffness));
            axes.push(Axis::log(BendDamping, 1e-2 * square, 1e3 * square, damping));
            if is_cable && task.sample.rest_shape.is_some() {
                // An angle has no direction: a cable that twists bends back
                // towards its rest angle on the wrong side. Often a part of it fits best.
                axes.push(Axis::linear(RestBend, 0.0, 1.0, 0.5));
            }
        }
        if task.has_rods(&connectivity) {
            let square = task.spacing_m * task.spacing_m;
            axes.push(Axis::log(TwistStiffness, 1e-2 * square, 1e4 * square, 30.0 * square));
            axes.push(Axis::log(TwistDamping, 1e-4 * square, 1e3 * square, 0.1 * square));
            axes.push(Axis::linear(RestTwist, -PI, PI, 0.0));
        }
        if task.nears_ground {
            axes.push(Axis::linear(GroundRestitution, 0.0, 1.0, SOFT_RESTITUTION));
            axes.push(Axis::linear(GroundFriction, 0.0, 2.0, 0.5));
        }
        if task.has_contact() {
            axes.push(Axis::linear(ObjectRestitution, 0.0, 1.0, SOFT_RESTITUTION));
            axes.push(Axis::linear(ObjectFriction, 0.0, 2.0, 0.3));
            axes.push(Axis::linear(CollisionDistance, 0.01, 0.05, 0.02));
        }
        if task.searches_gravity() {
            axes.push(Axis::log(Gravity, 0.5, 2.0, 1.0));
        }
        if settings.search.topology {
            let graph = &settings.graph;
            if !is_cable {
                // Relative to the start, which knows how far apart the points are.
                let [low, high] = RADII.map(|times| times * connectivity.radius_m);
                axes.push(Axis::linear(Radius, low, high, connectivity.radius_m));
                axes.push(Axis::linear(Neighbours, 10.0, 50.0, connectivity.max_neighbours as f64));
            }
            if task.has_control_springs() {
                axes.push(Axis::linear(ControlRadius, 0.01, 0.08, graph.control_radius_m));
                let neighbours = graph.control_neighbours as f64;
                axes.push(Axis::linear(ControlNeighbours, 10.0, 80.0, neighbours));
            }
        }
        let contact = Contact {
            within_object: settings.self_contact,
            skin: settings.skin_contact.unwrap_or(false),
            ..Contact::default()
        };
        let mut start = Candidate {
            connectivity,
            stiffness: 0.0,
            dashpot: 0.0,
            drag: 0.0,
            bend_stiffness: 0.0,
            bend_damping: 0.0,
            rest_bend: 1.0,
            twist_stiffness: 0.0,
            twist_damping: 0.0,
            rest_twist: 0.0,
            contact,
            gravity: 1.0,
        };
        axes.iter().for_each(|a| start.set(a.variable, a.start));
        Self { axes, start }
    }

    /// The point at which the search starts.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.axes.iter().map(Axis::coordinate).collect()
    }

    /// The candidate at a point of the cube.
    pub(crate) fn candidate(&self, point: &[f64]) -> Candidate {
        let mut candidate = self.start;
        for (axis, &x) in self.axes.iter().zip(point) {
            candidate.set(axis.variable, axis.value(x));
        }
        candidate
    }

    /// Factor on the loss at a point of the cube, for `prior` of it per square decade that damping
    /// and bending, or per square [`RESTITUTION_DECADE`] that restitution is away from where the
    /// search starts.
    ///
    /// A body that is held and moved says much about its stiffness and little about what damps it:
    /// drag or dashpots, of which either may be anything within two decades at nearly the same loss.
    /// Where the search leaves them matters for motion that the capture does not show. One that
    /// never bounces says nothing about restitution.
    pub(crate) fn penalty(&self, point: &[f64], prior: f64) -> f64 {
        let square_decades = |(axis, &x): (&Axis, &f64)| match axis.variable {
            Variable::Dashpot
            | Variable::Drag
            | Variable::BendStiffness
            | Variable::BendDamping => (axis.value(x) / axis.start).log10().powi(2),
            Variable::GroundRestitution | Variable::ObjectRestitution => {
                ((axis.value(x) - axis.start) / RESTITUTION_DECADE).powi(2)
            }
            _ => 0.0,
        };
        1.0 + prior * self.axes.iter().zip(point).map(square_decades).sum::<f64>()
    }

    /// Physical variables that ended within a hundredth of an end of their range.
    pub(crate) fn at_bounds(&self, point: &[f64]) -> Vec<(Variable, f64)> {
        let at_end = |x: f64| !(0.01..=0.99).contains(&x);
        let pairs = self.axes.iter().zip(point).filter(|(a, x)| a.is_log && at_end(**x));
        pairs.map(|(a, &x)| (a.variable, a.value(x))).collect()
    }
}

impl Candidate {
    fn set(&mut self, variable: Variable, value: f64) {
        let c = &mut self.contact;
        let to_grid = |x: f64| (x / RADIUS_STEP_M).round() * RADIUS_STEP_M;
        match variable {
            Variable::Stiffness => self.stiffness = value,
            Variable::Dashpot => self.dashpot = value,
            Variable::Drag => self.drag = value,
            Variable::BendStiffness => self.bend_stiffness = value,
            Variable::BendDamping => self.bend_damping = value,
            Variable::RestBend => self.rest_bend = value,
            Variable::TwistStiffness => self.twist_stiffness = value,
            Variable::TwistDamping => self.twist_damping = value,
            Variable::RestTwist => self.rest_twist = value,
            Variable::GroundRestitution => c.ground_restitution = value as f32,
            Variable::GroundFriction => c.ground_friction = value as f32,
            Variable::ObjectRestitution => c.object_restitution = value as f32,
            Variable::ObjectFriction => c.object_friction = value as f32,
            Variable::CollisionDistance => c.collision_distance_m = value as f32,
            Variable::Radius => self.connectivity.radius_m = to_grid(value),
            Variable::Neighbours => self.connectivity.max_neighbours = value.round() as usize,
            Variable::ControlRadius => self.connectivity.control_radius_m = to_grid(value),
            Variable::Gravity => self.gravity = value,
            Variable::ControlNeighbours => {
                self.connectivity.control_neighbours = value.round() as usize;
            }
        }
    }

    /// The capture's environment, with gravity scaled by the candidate's.
    pub(crate) fn environment(&self, captured: Environment) -> Environment {
        let gravity = captured.gravity.map(|g| (f64::from(g) * self.gravity) as f32);
        Environment { gravity, ..captured }
    }

    /// Parameters of a graph: the same for every spring, every triplet and every rod.
    pub(crate) fn params(&self, built: &BuiltGraph) -> Params {
        let BuiltGraph { rest_lengths_m, rest_angles_rad, .. } = built;
        let (e, t, r) = (rest_lengths_m.len(), rest_angles_rad.len(), built.graph.rods.len());
        Params {
            spring_stiffness: vec![self.stiffness as f32; e],
            spring_dashpot: vec![self.dashpot as f32; e],
            rest_lengths_m: rest_lengths_m.clone(),
            bend_stiffness: vec![self.bend_stiffness as f32; t],
            bend_damping: vec![self.bend_damping as f32; t],
            rest_angles_rad: rest_angles_rad
                .iter()
                .map(|&a| scale_bend(a, self.rest_bend))
                .collect(),
            twist_stiffness: vec![self.twist_stiffness as f32; r],
            twist_damping: vec![self.twist_damping as f32; r],
            rest_twists_rad: vec![self.rest_twist as f32; r],
            drag: self.drag as f32,
            contact: self.contact,
        }
    }
}

/// A rest angle with a share of its bend.
fn scale_bend(angle_rad: f32, share: f64) -> f32 {
    let straight = std::f32::consts::PI;
    let bend = f64::from(straight - angle_rad) * share;
    ((f64::from(straight) - bend) as f32).clamp(0.0, straight)
}

#[cfg(test)]
mod tests;

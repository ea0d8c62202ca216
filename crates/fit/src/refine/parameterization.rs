//! Coordinates of the refinement: logarithms of stiffnesses, dashpots, dampings, drag and rest
//! lengths (positive, of unknown scale); rest angles, rest twists and contact ratios unchanged.

use std::f64::consts::PI;

use bendtwin_core::{Params, params::MAX_SPRING_STIFFNESS};
use bendtwin_engine::optimizer::{Parameter, Parameterization, Scale};

use crate::task::Task;

/// Largest change of a rest length, as the logarithm of a factor.
const REST_LENGTH_SPAN: f64 = 0.2;
/// Largest change of a rest angle [rad].
const REST_ANGLE_SPAN: f64 = 0.6;
/// Rest lengths per unit of learning rate: one percent matters as much as a quarter of a stiffness.
const REST_LENGTH_RATE: f64 = 0.04;
/// Rest angles [rad] per unit of learning rate.
const REST_ANGLE_RATE: f64 = 0.05;
/// Largest change of a rest twist [rad].
const REST_TWIST_SPAN: f64 = 2.0 * PI;
/// Rest twists [rad] per unit of learning rate: a rod turns by more than any one of its angles.
const REST_TWIST_RATE: f64 = 1.0;
/// Numbers that the whole object has one of, per unit of learning rate: alone of their kind, they
/// would always move by all of it.
const GLOBAL_RATE: f64 = 0.5;

/// The coordinates of one graph's parameters, which start at `base`.
pub(crate) fn parameterization(task: &Task<'_>, base: Params) -> Parameterization {
    let mut parameters = vec![
        Parameter::SpringStiffness,
        Parameter::SpringDashpot,
        Parameter::BendStiffness,
        Parameter::BendDamping,
        Parameter::TwistStiffness,
        Parameter::TwistDamping,
        Parameter::Drag,
    ];
    if task.settings.refine.rest_shape {
        parameters.extend([Parameter::RestLength, Parameter::RestAngle, Parameter::RestTwist]);
    }
    if task.nears_ground {
        parameters.extend([Parameter::GroundRestitution, Parameter::GroundFriction]);
    }
    if task.has_contact() {
        parameters.extend([Parameter::ObjectRestitution, Parameter::ObjectFriction]);
    }
    let per_second = f64::from(task.settings.substeps.most()) * task.capture.fps;
    parameters.into_iter().fold(Parameterization::new(base), |parameterization, parameter| {
        let bounds = |start| bounds(parameter, start, task.spacing_m, per_second);
        parameterization.with(parameter, scale(parameter), rate(parameter), bounds)
    })
}

fn scale(parameter: Parameter) -> Scale {
    match parameter {
        Parameter::SpringStiffness
        | Parameter::SpringDashpot
        | Parameter::RestLength
        | Parameter::BendStiffness
        | Parameter::BendDamping
        | Parameter::TwistStiffness
        | Parameter::TwistDamping
        | Parameter::Drag => Scale::Logarithmic,
        Parameter::RestAngle
        | Parameter::RestTwist
        | Parameter::GroundRestitution
        | Parameter::GroundFriction
        | Parameter::ObjectRestitution
        | Parameter::ObjectFriction => Scale::Linear,
    }
}

/// Length of a step relative to the learning rate.
fn rate(parameter: Parameter) -> f64 {
    match parameter {
        Parameter::RestLength => REST_LENGTH_RATE,
        Parameter::RestAngle => REST_ANGLE_RATE,
        Parameter::RestTwist => REST_TWIST_RATE,
        Parameter::Drag
        | Parameter::GroundRestitution
        | Parameter::GroundFriction
        | Parameter::ObjectRestitution
        | Parameter::ObjectFriction => GLOBAL_RATE,
        _ => 1.0,
    }
}

/// Bounds of a coordinate that starts at `start`, with `per_second` substeps a second.
fn bounds(parameter: Parameter, start: f64, spacing_m: f64, per_second: f64) -> [f64; 2] {
    let square = spacing_m * spacing_m;
    let logs = |low: f64, high: f64| [low.ln(), high.ln()];
    match parameter {
        Parameter::SpringStiffness => logs(1.0, f64::from(MAX_SPRING_STIFFNESS)),
        Parameter::SpringDashpot => logs(1e-3, 1e3),
        Parameter::RestLength => [start - REST_LENGTH_SPAN, start + REST_LENGTH_SPAN],
        // As for damping: stable up to a frequency of two per substep.
        Parameter::BendStiffness => {
            let stiffest = (per_second * per_second / 36.0).min(1e6);
            logs(1e-3 * square, stiffest * square)
        }
        // Explicit damping is stable up to a rate of two per substep; a node takes part in a dozen
        // triplets, which act on it by up to six times their damping over a square arm.
        Parameter::BendDamping => logs(1e-4 * square, per_second / 36.0 * square),
        Parameter::RestAngle => {
            [(start - REST_ANGLE_SPAN).max(0.0), (start + REST_ANGLE_SPAN).min(PI)]
        }
        Parameter::TwistStiffness => logs(1e-4 * square, 1e5 * square),
        Parameter::TwistDamping => logs(1e-6 * square, 1e4 * square),
        Parameter::RestTwist => [start - REST_TWIST_SPAN, start + REST_TWIST_SPAN],
        Parameter::Drag => logs(1e-3, 50.0),
        Parameter::GroundRestitution | Parameter::ObjectRestitution => [0.0, 1.0],
        Parameter::GroundFriction | Parameter::ObjectFriction => [0.0, 2.0],
    }
}

#[cfg(test)]
mod tests;

//! Parameters by instance, and ensembles of them.

use super::{
    Batch, Error, Limits,
    tensors::{floats, given, required},
    within,
};
use crate::v1::{Fidelity, RollOutRequest, Tensor, Vary, ensemble::Statistic, tensor::Dtype};

/// Largest factor of a parameter.
const MOST: f32 = 100.0;
/// Smallest factor of what must not vanish.
const LEAST: f32 = 0.01;

pub(super) fn check(request: &RollOutRequest, batch: &Batch, limits: &Limits) -> Result<(), Error> {
    let sets = match &request.ensemble {
        None => ("B", batch.instances),
        Some(_) => ("E", members(request)),
    };
    if let Some(ensemble) = &request.ensemble {
        if ensemble.members == 0 {
            let fault = "is 0: say how many sets of parameters `vary` has";
            return Err(Error::field("ensemble.members", fault));
        }
        let Ok(statistic) = Statistic::try_from(ensemble.statistic) else {
            let fault =
                format!("has the unknown value {}: use MEAN, WORST or CVAR", ensemble.statistic);
            return Err(Error::field("ensemble.statistic", fault));
        };
        let share = ensemble.share;
        if statistic == Statistic::Cvar && !(share > 0.0 && share <= 1.0) {
            let fault = format!("is {share}: with CVAR it must lie above 0 and be at most 1");
            return Err(Error::field("ensemble.share", fault));
        }
        if ensemble.members > 1 && request.vary.as_ref().is_none_or(is_empty) {
            let fault = "is missing: without it all members of the ensemble are the same";
            return Err(Error::field("vary", fault));
        }
        within(
            "the number of instances (actions x members)",
            u128::from(batch.instances) * u128::from(ensemble.members),
            limits.instances,
            "split the batch, or use fewer members",
        )?;
    }
    let Some(vary) = &request.vary else { return Ok(()) };
    if vary.fits && request.ensemble.is_none() {
        let fault = "is without an `ensemble`, whose members are simulated on the fits";
        return Err(Error::field("vary.fits", fault));
    }
    if vary.fits && request.fidelity() == Fidelity::Fast {
        let fault = "is for the exact twin, and the fast variant has no other fits: ask for EXACT";
        return Err(Error::field("vary.fits", fault));
    }
    for (name, tensor, least) in factors(vary) {
        if let Some(tensor) = given(tensor) {
            self::factor(tensor, &format!("vary.{name}"), sets, least)?;
        }
    }
    Ok(())
}

/// Number of sets of parameters under which each action is simulated.
pub fn members(request: &RollOutRequest) -> u64 {
    request.ensemble.as_ref().map_or(1, |ensemble| u64::from(ensemble.members.max(1)))
}

/// Most sets of parameters that differ, beside the twin's own.
pub(in crate::rollout) fn sets(request: &RollOutRequest, batch: &Batch) -> u64 {
    let varied = request.vary.as_ref().is_some_and(|vary| !is_empty(vary));
    match &request.ensemble {
        _ if !varied => 0,
        None => batch.instances,
        Some(_) => members(request),
    }
}

fn is_empty(vary: &Vary) -> bool {
    !vary.fits && factors(vary).into_iter().all(|(_, tensor, _)| given(tensor).is_none())
}

/// Name and tensor of each factor, and the least that it may be.
fn factors(vary: &Vary) -> [(&'static str, Option<&Tensor>, f32); 5] {
    [
        ("stiffness", vary.stiffness.as_ref(), LEAST),
        ("damping", vary.damping.as_ref(), 0.0),
        ("bending", vary.bending.as_ref(), 0.0),
        ("friction", vary.friction.as_ref(), 0.0),
        ("mass", vary.mass.as_ref(), LEAST),
    ]
}

fn factor(
    tensor: &Tensor,
    field: &str,
    (name, count): (&str, u64),
    least: f32,
) -> Result<(), Error> {
    let (tensor, shape) = required(Some(tensor), field, Dtype::Float32)?;
    if shape != [count] {
        let fault = format!("has shape {shape:?}, not [{count}] ({name})");
        return Err(Error::field(field, fault));
    }
    match floats(tensor).enumerate().find(|(_, x)| !(least..=MOST).contains(x)) {
        Some((i, x)) => {
            let fault = format!("is {x} for {i}: it is a factor, and must lie in {least}..={MOST}");
            Err(Error::field(field, fault))
        }
        None => Ok(()),
    }
}

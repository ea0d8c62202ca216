//! Limits of what is plausible, and options of gradients.

use bendtwin_proto::v1::RollOutRequest;

use super::{
    super::implausible::ImplausibleReason, Asked, Error, Message, Price, mul, numbers::within_range,
};
use crate::rollout::message::length;

/// Widest layer of smooth contact [m].
const WIDEST_M: f32 = 0.1;

pub(in crate::rollout) fn check(request: &RollOutRequest) -> Result<(), Error> {
    if let Some(gradient) = &request.gradient {
        let width = Some(gradient.smoothing_m as f32);
        within_range(width, "gradient.smoothing_m", 0.0..=WIDEST_M)?;
    }
    let Some(limits) = &request.plausibility else { return Ok(()) };
    for reason in ImplausibleReason::ALL {
        if let Some(limit) = reason.limit(limits).filter(|x| x.is_nan() || *x < 0.0) {
            let fault = format!("is {limit}: it must not be negative");
            return Err(Error::field(format!("plausibility.{}", reason.field()), fault));
        }
    }
    Ok(())
}

/// True if forces of grasps are measured for the limits of a request.
pub(super) fn limits_grasp_force(request: &RollOutRequest) -> bool {
    let limits = request.plausibility.unwrap_or_default();
    ImplausibleReason::GraspForce.limit_or_default(&limits) < f64::INFINITY
        && !request.grasps.is_empty()
}

/// Findings of each instance, at most. Found values are in single precision, so a limit beyond that is
/// never exceeded.
pub(in crate::rollout) fn price(asked: &Asked<'_>) -> Price {
    let limits = asked.request.plausibility.unwrap_or_default();
    let last = mul(&[asked.batch.instances, asked.members]).saturating_sub(1);
    let grasps = asked.request.grasps.len() as u64;
    let can_be = |r: &ImplausibleReason| r.limit_or_default(&limits) < f64::INFINITY;
    let each = ImplausibleReason::ALL.into_iter().filter(can_be).map(|reason| {
        let frame = if reason.names_frame() { 1 + length(asked.batch.frames) } else { 0 };
        // Tag and length, an index, the reason, what was found and the limit.
        let one = 3 + (1 + length(last)) + (2 + reason.as_str().len() as u64) + 2 * 9 + frame;
        match reason {
            ImplausibleReason::GraspForce => mul(&[grasps, one + 1 + length(grasps)]),
            _ => one,
        }
    });
    let mut reply = Message::default();
    reply.add(mul(&[asked.covered, asked.members, each.sum()]));
    Price { reply, ..Price::default() }
}

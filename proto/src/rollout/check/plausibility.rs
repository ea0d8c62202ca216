//! Limits of what is plausible, and options of gradients.

use super::{Error, numbers::within_range};
use crate::v1::RollOutRequest;

/// Widest layer of smooth contact [m].
const WIDEST_M: f32 = 0.1;

pub(super) fn check(request: &RollOutRequest) -> Result<(), Error> {
    if let Some(gradient) = &request.gradient {
        let width = Some(gradient.smoothing_m as f32);
        within_range(width, "gradient.smoothing_m", 0.0..=WIDEST_M)?;
    }
    let Some(limits) = &request.plausibility else { return Ok(()) };
    let limits = [
        ("start_gap_m", limits.start_gap_m),
        ("control_speed_m_s", limits.control_speed_m_s),
        ("strain", limits.strain),
        ("control_depth_m", limits.control_depth_m),
    ];
    match limits.into_iter().find(|(_, limit)| limit.is_some_and(|x| x.is_nan() || x < 0.0)) {
        Some((name, limit)) => {
            let fault = format!("is {}: it must not be negative", limit.unwrap_or(f64::NAN));
            Err(Error::field(format!("plausibility.{name}"), fault))
        }
        None => Ok(()),
    }
}

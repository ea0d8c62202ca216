//! Limits of what is plausible, and options of gradients.

use bendtwin_proto::v1::RollOutRequest;

use super::{super::implausible::ImplausibleReason, Error, numbers::within_range};

/// Widest layer of smooth contact [m].
const WIDEST_M: f32 = 0.1;

pub(super) fn check(request: &RollOutRequest) -> Result<(), Error> {
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

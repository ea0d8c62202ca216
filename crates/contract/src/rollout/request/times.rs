//! Times of the knots of actions.

use bendtwin_proto::v1::{RollOutRequest, knot_times::Times, tensor::Dtype};

use super::{
    Error,
    tensors::{finite, floats, required},
};

const AT: &str = "knot_times.at_s";
const PERIOD: &str = "knot_times.period_s";
/// Periods that an action may have [s].
const PERIODS: std::ops::RangeInclusive<f64> = 1e-5..=1e5;

/// Checks the times of `knots` knots.
pub(in crate::rollout) fn check(request: &RollOutRequest, knots: u64) -> Result<(), Error> {
    let Some(times) = request.knot_times.as_ref().and_then(|times| times.times.as_ref()) else {
        return Ok(());
    };
    if request.frames == 0 {
        let fault = "is missing: with `knot_times` say how many frames of the twin to simulate";
        return Err(Error::field("frames", fault));
    }
    match times {
        Times::PeriodS(period) if PERIODS.contains(period) => Ok(()),
        Times::PeriodS(period) => {
            let (low, high) = (PERIODS.start(), PERIODS.end());
            let fault = format!("is {period}: it must lie in {low:e}..={high:e} seconds");
            Err(Error::field(PERIOD, fault))
        }
        Times::AtS(at) => {
            let (at, shape) = required(Some(at), AT, Dtype::Float32)?;
            if shape != [knots] {
                let fault = format!("has shape {shape:?}: the actions have {knots} knots");
                return Err(Error::field(AT, fault));
            }
            finite(at, AT)?;
            rising(floats(at))
        }
    }
}

fn rising(times: impl Iterator<Item = f32>) -> Result<(), Error> {
    let mut last = None;
    for (knot, time) in times.enumerate() {
        let fault = match last {
            None if time != 0.0 => format!("begins with {time}: the first knot is at 0"),
            Some(last) if time <= last => {
                format!("has {time} after {last} at knot {knot}: times must rise")
            }
            _ => {
                last = Some(time);
                continue;
            }
        };
        return Err(Error::field(AT, fault));
    }
    Ok(())
}

//! Settings of the planner from a request.

use std::time::Duration;

use bendtwin_plan::{Bounds, Curve, Limit, Method, Settings, check_places, rounds};
use bendtwin_proto::v1::{
    Interpolation, KnotTimes, PlanMethod, PlanRequest, RollOutRequest, Tensor, knot_times::Times,
    plan_method, roll_out_request::Actions, tensor::Dtype,
};

use super::Error;
use crate::rollout::{
    Batch,
    tensors::{floats, given, required},
};

/// Standard deviation of samples without another [m or rad].
const SIGMA: f64 = 0.02;
/// Largest step of a gradient's iteration without another [m or rad].
const RATE: f64 = 0.005;
/// Samples and iterations of methods that sample, and with a gradient.
const SAMPLED: [u32; 2] = [64, 1];
const DESCENDED: [u32; 2] = [1, 20];
/// Samples of each place without another number, of methods that sample.
const OF_PLACE: u32 = 8;

/// The settings for a batch of one instance and D coordinates, with `frame_s` seconds a frame, that search
/// as many `places`.
pub(super) fn settings(
    request: &PlanRequest,
    rollout: &RollOutRequest,
    batch: &Batch,
    dims: usize,
    frame_s: f64,
    places: usize,
) -> Result<Settings, Error> {
    let method = method(request.method.as_ref())?;
    let [mut samples, mut iterations] = if method.needs_gradients() { DESCENDED } else { SAMPLED };
    if places > 1 {
        let each = if method.needs_gradients() { 1 } else { OF_PLACE };
        samples = samples.max(each.saturating_mul(places as u32));
        iterations = iterations.max(rounds(places) as u32);
    }
    let or = |given: u32, default: u32| if given == 0 { default as usize } else { given as usize };
    let knots = usize::try_from(batch.knots).unwrap_or(usize::MAX);
    let bounds = request.bounds.clone().unwrap_or_default();
    let frames = usize::try_from(batch.frames).unwrap_or(usize::MAX);
    let default = Settings::new(method, dims, frames);
    let settings = Settings {
        knots,
        frame_s,
        knot_times: times(rollout.knot_times.as_ref(), knots)?,
        curve: curve(rollout),
        samples: or(request.samples, samples),
        iterations: or(request.iterations, iterations),
        sigma: numbers(request.sigma.as_ref(), "sigma")?.unwrap_or_else(|| vec![SIGMA]),
        correlation: request.correlation,
        finest: request.finest.unwrap_or(default.finest),
        bounds: Bounds {
            low: limit(bounds.low.as_ref(), "bounds.low")?,
            high: limit(bounds.high.as_ref(), "bounds.high")?,
            speed: limit(bounds.speed.as_ref(), "bounds.speed")?,
        },
        deadline: deadline(request.deadline_s)?,
        seed: request.seed,
        ..default
    };
    settings.check()?;
    check_places(&settings, places)?;
    Ok(settings)
}

fn method(method: Option<&PlanMethod>) -> Result<Method, Error> {
    use plan_method::Method as Wire;
    Ok(match method.and_then(|m| m.method.as_ref()) {
        None => Method::MPPI,
        Some(Wire::Mppi(mppi)) if mppi.temperature == 0.0 => Method::MPPI,
        Some(Wire::Mppi(mppi)) => Method::Mppi { temperature: mppi.temperature },
        Some(Wire::Cem(cem)) => Method::Cem {
            elites: if cem.elites == 0 { 8 } else { cem.elites as usize },
            memory: cem.memory.unwrap_or(0.1),
            smallest: cem.smallest.unwrap_or(0.05),
        },
        Some(Wire::PredictiveSampling(_)) => Method::PredictiveSampling,
        Some(Wire::Gradient(gradient)) => {
            let rate = numbers(gradient.rate.as_ref(), "method.gradient.rate")?;
            Method::Gradient { rate: rate.unwrap_or_else(|| vec![RATE]) }
        }
    })
}

fn deadline(seconds: f64) -> Result<Option<Duration>, Error> {
    if seconds == 0.0 {
        return Ok(None);
    }
    Duration::try_from_secs_f64(seconds).map(Some).map_err(|_| {
        Error::field("deadline_s", format!("is {seconds}: it must be 0 or more, and finite"))
    })
}

fn curve(rollout: &RollOutRequest) -> Curve {
    let interpolation = match &rollout.actions {
        Some(Actions::Trajectories(t)) => t.interpolation(),
        Some(Actions::Poses(p)) => p.interpolation(),
        None => Interpolation::Unspecified,
    };
    match interpolation {
        Interpolation::Unspecified | Interpolation::Linear => Curve::Linear,
        Interpolation::Cubic => Curve::Cubic,
        Interpolation::Zero => Curve::Hold,
    }
}

/// Times of the knots of a checked rollout [s]; empty: spread evenly.
fn times(times: Option<&KnotTimes>, knots: usize) -> Result<Vec<f64>, Error> {
    match times.and_then(|times| times.times.as_ref()) {
        None => Ok(Vec::new()),
        Some(Times::PeriodS(period)) => Ok((0..knots).map(|k| k as f64 * period).collect()),
        Some(Times::AtS(at)) => {
            Ok(numbers(Some(at), "rollout.knot_times.at_s")?.unwrap_or_default())
        }
    }
}

fn limit(tensor: Option<&Tensor>, field: &str) -> Result<Limit, Error> {
    Ok(match numbers(tensor, field)?.as_deref() {
        None => Limit::None,
        Some([all]) => Limit::All(*all),
        Some(each) => Limit::Each(each.to_vec()),
    })
}

/// The values of a tensor of any shape, if it is given.
fn numbers(tensor: Option<&Tensor>, field: &str) -> Result<Option<Vec<f64>>, Error> {
    let Some(tensor) = given(tensor) else { return Ok(None) };
    let (tensor, _) = required(Some(tensor), field, Dtype::Float32)?;
    Ok(Some(floats(tensor).map(f64::from).collect()))
}

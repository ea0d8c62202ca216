//! Comparisons whose failures state the expected and the actual values.

use bendtwin_engine::model::State;

pub(crate) type Outcome = Result<(), String>;

/// Fails unless `got` lies within `tolerance` of `expected`. NaN fails.
pub(crate) fn close(what: &str, got: f64, expected: f64, tolerance: f64) -> Outcome {
    ensure((got - expected).abs() <= tolerance, || {
        format!("{what} is {got:.9}, expected {expected:.9} within {tolerance:.1e}")
    })
}

/// Fails with `message` unless `ok`.
pub(crate) fn ensure(ok: bool, message: impl FnOnce() -> String) -> Outcome {
    if ok { Ok(()) } else { Err(message()) }
}

/// Fails unless all positions and velocities are finite.
pub(crate) fn finite(what: &str, state: &State) -> Outcome {
    let all = state.positions.iter().chain(&state.velocities).flatten();
    ensure(all.clone().all(|x| x.is_finite()), || format!("{what}: the state is not finite"))
}

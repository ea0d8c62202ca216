//! The factor by which a camera's depth has to be multiplied to agree with the others.

use super::{ViewSet, hypothesis::Hypothesis};

/// Frequent wrong factors: units of length, and the other depth units of a RealSense.
pub(crate) const UNITS: [f64; 12] =
    [0.001, 0.01, 0.0254, 0.1, 0.25, 0.5, 2.0, 4.0, 10.0, 39.37, 100.0, 1000.0];
/// Steps up and down from a factor, and their ratio: first coarse, then fine.
const STEPS: [(i32, f64); 2] = [(8, 1.05), (5, 1.01)];

/// A factor and the misfit that remains with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScaleFit {
    pub(crate) factor: f64,
    pub(crate) misfit: f64,
}

/// The best factor for one view's depth.
pub(crate) fn of_one(set: &ViewSet<'_>, hypothesis: &Hypothesis, which: usize) -> Option<ScaleFit> {
    let misfit = |factor: f64| {
        let scaled = hypothesis.with(which, |s| s.depth_scale *= factor);
        set.misfit_of(&scaled, |a, b| a == which || b == which)
    };
    search(set, misfit)
}

/// The best factor for all depths together.
pub(crate) fn of_all(set: &ViewSet<'_>, hypothesis: &Hypothesis) -> Option<ScaleFit> {
    search(set, |factor| set.misfit(&hypothesis.with_all(|s| s.depth_scale *= factor)))
}

fn search(set: &ViewSet<'_>, misfit: impl Fn(f64) -> Option<f64>) -> Option<ScaleFit> {
    let tried = |factor: f64| misfit(factor).map(|misfit| ScaleFit { factor, misfit });
    let better = |a: &ScaleFit, b: &ScaleFit| a.misfit.total_cmp(&b.misfit);
    let around = |mut fine: ScaleFit| {
        for (steps, ratio) in STEPS {
            let from = fine.factor;
            let near = |step: i32| tried(from * ratio.powi(step));
            fine = (-steps..=steps).filter_map(near).min_by(better)?;
        }
        Some(fine)
    };
    // A wrong unit may by chance look better than the declared one before either is refined.
    let declared = around(tried(1.0)?)?;
    let unit = UNITS.into_iter().filter_map(tried).min_by(better)?;
    let other = (unit.misfit < tried(1.0)?.misfit).then(|| around(unit)).flatten();
    let fine = other.into_iter().chain([declared]).min_by(better)?;
    // As declared, unless another factor is really better.
    match tried(1.0) {
        Some(declared) if declared.misfit <= fine.misfit + set.thresholds.min_scale_gain => {
            Some(declared)
        }
        _ => Some(fine),
    }
}

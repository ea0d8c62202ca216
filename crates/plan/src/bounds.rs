//! Limits of what a plan may do.

use crate::{Knots, error::Invalid};

/// Limits by coordinate. They hold at the knots, and also between them along straight lines. Row 0
/// is the current state, and is not changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Smallest value of a coordinate.
    pub low: Limit,
    /// Largest value of a coordinate.
    pub high: Limit,
    /// Fastest change of a coordinate, per second.
    pub speed: Limit,
}

/// A limit for every coordinate.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Limit {
    /// No limit.
    #[default]
    None,
    /// A bound for all coordinates.
    All(f64),
    /// A bound for each, shape [D].
    Each(Vec<f64>),
}

impl Limit {
    fn of(&self, coordinate: usize, without: f64) -> f64 {
        match self {
            Self::None => without,
            Self::All(limit) => *limit,
            Self::Each(limits) => limits.get(coordinate).copied().unwrap_or(without),
        }
    }

    fn check(&self, field: &'static str, dims: usize) -> Result<(), Invalid> {
        match self {
            Self::Each(limits) if limits.len() != dims => Err(Invalid::new(
                field,
                format!("has {} values: give one for each of {dims} coordinates", limits.len()),
            )),
            Self::All(limit) if limit.is_nan() => Err(Invalid::new(field, "is not a number")),
            Self::Each(limits) if limits.iter().any(|l| l.is_nan()) => {
                Err(Invalid::new(field, "has values that are not numbers"))
            }
            _ => Ok(()),
        }
    }
}

impl Bounds {
    pub(crate) fn check(&self, dims: usize) -> Result<(), Invalid> {
        self.low.check("bounds.low", dims)?;
        self.high.check("bounds.high", dims)?;
        self.speed.check("bounds.speed", dims)?;
        for d in 0..dims {
            let (low, high) = (self.low.of(d, f64::NEG_INFINITY), self.high.of(d, f64::INFINITY));
            if low > high {
                let problem = format!("{low} lies above the upper bound {high}: swap them");
                return Err(Invalid::new("bounds.low", problem));
            }
            if self.speed.of(d, 0.0) < 0.0 {
                return Err(Invalid::new("bounds.speed", "is negative: give 0 or more"));
            }
        }
        Ok(())
    }

    /// The plan within the limits, with knots at times `at` [s]. Knots are moved one after another:
    /// the speed limit holds even where it prevents a plan that begins outside the other limits
    /// from returning to them immediately.
    pub(crate) fn project(&self, plan: &mut Knots, dims: usize, at: &[f64]) {
        for i in dims..plan.len() {
            let (k, d, last) = (i / dims, i % dims, plan[i - dims]);
            let (low, high) = (self.low.of(d, f64::NEG_INFINITY), self.high.of(d, f64::INFINITY));
            let step = self.speed.of(d, f64::INFINITY) * (at[k] - at[k - 1]);
            plan[i] = plan[i].max(low).min(high).max(last - step).min(last + step);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_hold_and_speed_comes_first() {
        let bounds = Bounds {
            low: Limit::Each(vec![-1.0, 0.0]),
            high: Limit::All(1.0),
            speed: Limit::Each(vec![0.5, f64::INFINITY]),
        };
        bounds.check(2).unwrap();
        // x begins beyond its bound and returns no faster than it may.
        let mut plan = vec![3.0, 0.5, 0.0, -2.0, 0.0, 2.0];
        bounds.project(&mut plan, 2, &[0.0, 2.0, 4.0]);
        assert_eq!(plan, [3.0, 0.5, 2.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn contradictions_are_refused() {
        let bounds = |low, high, speed| Bounds { low, high, speed };
        for wrong in [
            bounds(Limit::All(1.0), Limit::All(0.0), Limit::None),
            bounds(Limit::None, Limit::None, Limit::All(-1.0)),
            bounds(Limit::Each(vec![0.0]), Limit::None, Limit::None),
            bounds(Limit::All(f64::NAN), Limit::None, Limit::None),
        ] {
            assert!(wrong.check(2).is_err(), "{wrong:?}");
        }
    }
}

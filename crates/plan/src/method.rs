//! Four ways to propose plans and to learn from their costs.

mod gradient;
mod sampling;

pub(crate) use self::{
    gradient::{Batch, Descent},
    sampling::{Sampling, still},
};
use crate::error::Invalid;

/// Way to propose plans and to learn from their costs.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Model-predictive path integral control: the mean of all samples, weighted by their costs.
    Mppi {
        /// Temperature as a share of the costs' spread: small ones follow the best sample, large
        /// ones average.
        temperature: f64,
    },
    /// Cross-entropy: mean and spread of the best samples, iteration by iteration.
    Cem {
        /// Number of the best samples from which the next iteration is made.
        elites: usize,
        /// Share of the old mean and spread in the new ones.
        memory: f64,
        /// Spread below which it does not shrink, as a share of sigma.
        smallest: f64,
    },
    /// The best sample around the best plan so far.
    PredictiveSampling,
    /// Adam along the gradient, from the nominal plan and others that begin sigma away.
    Gradient {
        /// Largest step of an iteration: one, or by coordinate [D].
        rate: Vec<f64>,
    },
}

impl Method {
    /// Path integral control with a temperature of a tenth of the costs' spread.
    pub const MPPI: Self = Self::Mppi { temperature: 0.1 };
    /// Cross-entropy with 8 elites.
    pub const CEM: Self = Self::Cem { elites: 8, memory: 0.1, smallest: 0.05 };

    /// True if it needs gradients of the cost.
    pub fn needs_gradients(&self) -> bool {
        matches!(self, Self::Gradient { .. })
    }

    pub(crate) fn check(&self, dims: usize) -> Result<(), Invalid> {
        match self {
            Self::Mppi { temperature } if temperature.is_nan() || *temperature <= 0.0 => {
                Err(Invalid::new("temperature", "must be above 0"))
            }
            Self::Cem { elites: 0, .. } => Err(Invalid::new("elites", "give 1 or more")),
            Self::Cem { memory, .. } if !(0.0..1.0).contains(memory) => {
                Err(Invalid::new("memory", "must be 0 or more, and less than 1"))
            }
            Self::Cem { smallest, .. } if !(smallest.is_finite() && *smallest >= 0.0) => {
                Err(Invalid::new("smallest", "must be 0 or more"))
            }
            Self::Gradient { rate } if ![1, dims].contains(&rate.len()) => {
                Err(Invalid::new("rate", format!("give 1 value or {dims}")))
            }
            Self::Gradient { rate } if rate.iter().any(|r| !(r.is_finite() && *r > 0.0)) => {
                Err(Invalid::new("rate", "must be above 0"))
            }
            _ => Ok(()),
        }
    }
}

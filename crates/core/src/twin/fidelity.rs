//! Fidelity of a rollout: the twin exactly as fitted, its fast variant, or its planner's twin.

use serde::{Deserialize, Serialize};

/// The model of a twin that computes a rollout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fidelity {
    /// Substeps and parameters as fitted.
    #[default]
    Exact,
    /// The twin's [`FastVariant`].
    Fast,
    /// The twin's [`PlannersTwin`](crate::PlannersTwin).
    Planner,
}

/// The fast variant of a twin: its definition, and its deviation from the exact twin when both
/// follow the twin's own capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FastVariant {
    /// Substeps per frame.
    pub substeps: u32,
    /// Rate limit to which springs and triplets are softened (dimensionless, see
    /// `bendtwin_engine::fidelity`); none if parameters are as fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_limit: Option<f64>,
    /// Distance between a node here and there, mean over nodes and frames [m].
    pub mean_deviation_m: f64,
    /// The largest such distance [m].
    pub max_deviation_m: f64,
    /// Scale to compare with: distance of the exact twin's nodes from their initial positions, mean
    /// over nodes and frames [m].
    pub mean_travel_m: f64,
    /// Frames from the start of each recording over which this was measured, at most.
    pub frames: u32,
}

impl FastVariant {
    /// Checks that the variant can be made and its numbers are possible.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self) -> Result<(), String> {
        if self.substeps == 0 {
            return Err("the fast variant has no substeps".into());
        }
        if let Some(limit) = self.rate_limit.filter(|l| !(l.is_finite() && *l > 0.0)) {
            return Err(format!("the fast variant's rate limit is {limit}: it must be positive"));
        }
        let lengths = [self.mean_deviation_m, self.max_deviation_m, self.mean_travel_m];
        match lengths.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
            Some(x) => Err(format!("the fast variant deviates by {x}: it must be finite")),
            None => Ok(()),
        }
    }
}

//! Plans: actions searched for with rollouts.

use super::super::{App, Plan, Result};
use crate::dispatch::Updates;

impl App {
    /// Searches for actions. Faults of the request are refused before the first update; dropping
    /// the updates ends the search.
    pub(crate) async fn plan(&self, plan: Plan) -> Result<Updates> {
        if let Some(rollout) = &plan.request.rollout {
            self.require_rollout(rollout).await?;
        }
        self.dispatch.plan(plan).await
    }
}

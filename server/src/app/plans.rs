//! Plans: actions searched for with rollouts.

use super::{App, Plan, Result};
use crate::dispatch::Updates;

impl App {
    /// Searches for actions. Faults of the request are refused before the first update; dropping
    /// the updates ends the search.
    pub(crate) async fn plan(&self, plan: Plan) -> Result<Updates> {
        self.dispatch.plan(plan).await
    }
}

//! Plans at the server: batch after batch of samples goes to the workers as rollouts do, in the same
//! lines and with the same turns. The mathematics is `bendtwin-plan`'s. A stream of updates computes
//! only while it is read: dropping it drops the rollout under way.

mod beside;
mod evaluation;
mod run;
mod start;

use std::{sync::Arc, time::Duration};

use bendtwin_budget::Share;
use bendtwin_contract::{
    plan::{self, Checked},
    rollout::{self, TwinShape},
};
use bendtwin_proto::v1::{PlanRequest, PlanUpdate};
use futures::stream::{self, BoxStream, StreamExt as _};
use prost::Message as _;
use tokio::time::Instant;

use self::{beside::beside, run::Run};
use super::{Dispatch, rollout::LONGEST};
use crate::{
    error::{Error, Result},
    memory::Shares,
};

/// A plan to be made.
pub(crate) struct Plan {
    pub(crate) request: PlanRequest,
    /// Time that the caller allows, if it said.
    pub(crate) timeout: Option<Duration>,
    /// True if the updates are to be written as nested lists of JSON.
    pub(crate) as_lists: bool,
    /// Memory of the request, held until the plan is made.
    pub(crate) memory: Arc<Shares>,
}

/// A plan that has passed the check.
pub(super) struct Ready {
    pub(super) checked: Checked,
    /// Size of the request.
    bytes: u64,
    /// The end of the call.
    deadline: Instant,
    memory: Arc<Shares>,
    share: Share,
}

/// Updates of a plan as they come.
pub(crate) type Updates = BoxStream<'static, Result<PlanUpdate>>;

impl Dispatch {
    /// Checks a request and prepares it; faults are refused before the first update.
    pub(crate) async fn plan(&self, plan: Plan) -> Result<Updates> {
        let ready = self.ready(plan).await?;
        self.search(ready).await
    }

    /// Checks a request.
    pub(super) async fn ready(&self, plan: Plan) -> Result<Ready> {
        let Plan { mut request, timeout, as_lists, memory } = plan;
        let deadline = Instant::now() + timeout.unwrap_or(LONGEST).min(LONGEST);
        let missing = || plan::Error::Field {
            field: "rollout".to_owned(),
            fault: "is missing: say what to minimize".to_owned(),
        };
        let rollout = request.rollout.as_mut().ok_or_else(missing)?;
        let (_, parts) = self.session_of(rollout).await?;
        let known = self.twins.get(&self.store, rollout.twin.parse().map_err(Error::Name)?).await?;
        let limits = self.limits.rollout;
        let bytes = request.encoded_len();
        let check = move || plan::check(request, parts, &known.shape, known.frame_s, &limits);
        let checked = beside(bytes as u64, check).await??;
        if as_lists {
            self.fits_lists(last_reply_bytes(&checked, &known.shape))?;
        }
        self.opens_to(&checked, deadline).await?;
        let share = self.memory.plan(checked.bytes)?;
        Ok(Ready { checked, bytes: bytes as u64, deadline, memory, share })
    }

    /// Begins the search where the control points are now.
    pub(super) async fn search(&self, ready: Ready) -> Result<Updates> {
        let Ready { checked, bytes, deadline, memory, share } = ready;
        let controls = self.controls(checked.template.request(), deadline).await?;
        let parts = beside(bytes, move || start::search(checked, controls)).await??;
        let run = Run::new(self.clone(), parts, deadline, memory, share);
        Ok(stream::unfold(Some(Box::new(run)), |run| async { run?.update().await }).boxed())
    }
}

/// Size of the reply to the rollout of the best plan; 0 without such a rollout.
fn last_reply_bytes(checked: &Checked, twin: &TwinShape) -> u64 {
    let Some(request) = checked.template.last(&checked.nominal) else { return 0 };
    let (knots, frames) = (checked.settings.knots as u64, checked.settings.frames as u64);
    rollout::reply_bytes(&request, &rollout::Batch { instances: 1, knots, frames }, twin, 0)
}

//! The start of a plan: where things are, and the nominal plan in coordinates.

use bendtwin_contract::plan::{self, Checked, Template};
use bendtwin_plan::{Invalid, Planner, Search, Space};
use bendtwin_proto::v1::{
    GetSessionStatesRequest, RollOutRequest, Tensor,
    initial_state::{GivenState, SessionSlots, State},
    roll_out_request::Actions,
};
use tokio::time::Instant;

use crate::{
    dispatch::Dispatch,
    error::{Error, Result},
};

/// Search, space and rollout of a plan.
pub(super) struct Parts {
    pub(super) search: Search<Planner>,
    pub(super) space: Space,
    pub(super) template: Template,
    /// Bytes of the plans of a batch.
    pub(super) bytes: u64,
}

impl Dispatch {
    /// Control points where a rollout by trajectories begins, if its initial state determines them.
    pub(super) async fn controls(
        &self,
        request: &RollOutRequest,
        deadline: Instant,
    ) -> Result<Option<Vec<f64>>> {
        if !matches!(request.actions, Some(Actions::Trajectories(_))) {
            return Ok(None);
        }
        let controls = match request.initial.as_ref().and_then(|i| i.state.as_ref()) {
            Some(State::Given(GivenState { controls, .. })) => controls.clone(),
            Some(State::Session(SessionSlots { session, slots })) => {
                let slots = vec![slots.first().copied().unwrap_or(0)];
                let call = GetSessionStatesRequest { name: session.clone(), slots };
                let left = deadline.saturating_duration_since(Instant::now());
                let (states, _) = self.session_states(call, Some(left), false).await?;
                states.states.and_then(|s| s.controls)
            }
            _ => None,
        };
        controls.filter(|t| !t.is_absent()).map(|t| values(&t)).transpose()
    }
}

/// The planner of a checked request, with its nominal plan moved on and begun where control points
/// are.
pub(super) fn search(checked: Checked, controls: Option<Vec<f64>>) -> Result<Parts> {
    let Checked { template, settings, movement, start, nominal, shift_frames, bytes } = checked;
    let row = nominal.len() / settings.knots.max(1);
    let begun = |actions: &[f64]| {
        let start = start.clone().unwrap_or_else(|| actions[..row].to_vec());
        Space::new(start, &movement)
    };
    let mut actions = nominal;
    if shift_frames > 0.0 {
        let space = begun(&actions);
        let displacements = space.displacements(&actions);
        actions = space.displaced(&settings.shifted(&displacements, space.width(), shift_frames));
    }
    if let Some(controls) = controls.filter(|controls| controls.len() == row) {
        actions[..row].copy_from_slice(&controls);
    }
    let mut space = begun(&actions);
    let knots = space.around(space.displacements(&actions));
    let invalid = |invalid: Invalid| Error::Plan(plan::Error::from(invalid));
    let mut planner = Planner::new(settings).map_err(invalid)?;
    planner.set_nominal(knots).map_err(invalid)?;
    Ok(Parts { search: planner.into_search(), space, template, bytes })
}

fn values(tensor: &Tensor) -> Result<Vec<f64>> {
    let (_, values) = tensor
        .unpack::<f32>("controls")
        .map_err(|e| Error::Internal(format!("the control points of a session: {e}")))?;
    Ok(values.into_iter().map(f64::from).collect())
}

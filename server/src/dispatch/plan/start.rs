//! The start of a plan: where things are, and the nominal plan in coordinates, of each place to grasp.

use bendtwin_contract::plan::{self, Checked, Template};
use bendtwin_plan::{Invalid, Movement, PlaceSearch, Space};
use bendtwin_proto::{
    tensor::TensorError,
    v1::{
        GetSessionStatesRequest, RollOutRequest, Tensor,
        initial_state::{GivenState, SessionSlots, State},
        roll_out_request::Actions,
    },
};
use tokio::time::Instant;

use crate::{
    dispatch::Dispatch,
    error::{Error, Result},
};

/// Search, spaces and rollout of a plan.
pub(super) struct Parts {
    pub(super) search: PlaceSearch,
    /// The space of each place to begin at.
    pub(super) spaces: Vec<Space>,
    /// True if places to grasp are searched.
    pub(super) searches_grasps: bool,
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
            Some(State::Session(slots)) => self.state_of(slots, deadline).await?.controls,
            _ => None,
        };
        controls.filter(|t| !t.is_absent()).map(|t| values(&t)).transpose()
    }

    /// Refuses a search of places to grasp in a session whose slot holds something already. The contract
    /// checks states that requests give.
    pub(super) async fn opens_to(&self, checked: &Checked, deadline: Instant) -> Result<()> {
        let request = checked.template.request();
        let state = request.initial.as_ref().and_then(|initial| initial.state.as_ref());
        let (Some(places), Some(State::Session(slots))) = (&checked.places, state) else {
            return Ok(());
        };
        let grasping = self.state_of(slots, deadline).await?.grasping;
        let phases = grasping.and_then(|grasping| grasping.phases).filter(|t| !t.is_absent());
        let Some(phases) = phases else { return Ok(()) };
        let internal = |e: TensorError| Error::Internal(format!("the grasps of a session: {e}"));
        let (_, phases) = phases.unpack::<u32>("phases").map_err(internal)?;
        plan::check_open(places, request, &phases).map_err(Error::Plan)
    }

    /// State of the first of the slots that a rollout begins in.
    async fn state_of(&self, at: &SessionSlots, deadline: Instant) -> Result<GivenState> {
        let slots = vec![at.slots.first().copied().unwrap_or(0)];
        let call = GetSessionStatesRequest { name: at.session.clone(), slots };
        let left = deadline.saturating_duration_since(Instant::now());
        let (states, _) = self.session_states(call, Some(left), false).await?;
        Ok(states.states.unwrap_or_default())
    }
}

/// The search of a checked request, with its nominal plan moved on and begun where control points are, or
/// at each place to grasp.
pub(super) fn search(checked: Checked, controls: Option<Vec<f64>>) -> Result<Parts> {
    let Checked { template, settings, movement, start, nominal, shift_frames, places, bytes } =
        checked;
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
    let begins = match &places {
        None => vec![(begun(&actions), actions)],
        Some(places) => (0..places.count())
            .map(|place| {
                let moved = moved(&actions, &places.at(place, &actions[..row]), &movement);
                let start = start.as_deref().unwrap_or(&actions[..row]);
                (Space::new(places.at(place, start), &movement), moved)
            })
            .collect(),
    };
    let begin = |(mut space, actions): (Space, Vec<f64>)| {
        let knots = space.around(space.displacements(&actions));
        (space, knots)
    };
    let (spaces, nominals) = begins.into_iter().map(begin).unzip();
    let invalid = |invalid: Invalid| Error::Plan(plan::Error::from(invalid));
    let search = PlaceSearch::new(settings, nominals).map_err(invalid)?;
    Ok(Parts { search, spaces, searches_grasps: places.is_some(), template, bytes })
}

/// Actions that begin in another row, and move from there by the same displacements.
fn moved(actions: &[f64], row: &[f64], movement: &Movement) -> Vec<f64> {
    let of = |start: &[f64]| Space::new(start.to_vec(), movement);
    of(row).displaced(&of(&actions[..row.len()]).displacements(actions))
}

fn values(tensor: &Tensor) -> Result<Vec<f64>> {
    let (_, values) = tensor
        .unpack::<f32>("controls")
        .map_err(|e| Error::Internal(format!("the control points of a session: {e}")))?;
    Ok(values.into_iter().map(f64::from).collect())
}

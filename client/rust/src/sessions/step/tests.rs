use bendtwin_proto::v1::{
    self, RollOutResponse, Tensor, corrected_session::Correction as WireCorrection,
    initial_state::GivenState,
};

use super::*;
use crate::{Observation, Rollout, TwinId};

#[test]
fn a_step_is_sent_and_its_reply_is_read() {
    let name = SessionId::generate();
    let twin = TwinId::generate();
    let rollout = Rollout::of(twin).trajectories([1, 2, 1], vec![[0.0; 3]; 2]).frames(9);
    let planning = Planning::of(rollout.forces()).shifted(2.0);
    let seen = Correction::by(Observation::nodes(&[[0.0, 0.0, 1.0]], &[2])).carry(0.5);
    let step = Step::of(planning).slot(3).corrected(seen).execute(2);
    let request = step.deadline(Duration::from_millis(100)).into_request(name).unwrap();
    assert_eq!((request.name, request.slot), (name.to_string(), 3));
    assert_eq!((request.execute_frames, request.deadline_s), (2, 0.1));
    // Of the frames that are executed, and not of the whole plan.
    assert!(request.returns.unwrap().forces);
    let search = request.search.unwrap();
    assert_eq!(search.shift_frames, 2.0);
    let rollout = search.rollout.unwrap();
    assert_eq!((rollout.twin, rollout.initial, rollout.returns), (twin.to_string(), None, None));
    let correction = request.correction.unwrap();
    assert!(correction.name.is_empty() && correction.slots.is_empty());
    assert_eq!(correction.options.unwrap().carry, Some(0.5));

    let positions = Some(Tensor::pack_points(&[1], &[[0.5; 3]]));
    let one = WireCorrection { slot: 3, ..WireCorrection::default() };
    let corrected = v1::CorrectedSession { corrections: vec![one], ..Default::default() };
    let worker = bendtwin_core::ids::WorkerId::generate().to_string();
    let no_costs = Some(Tensor::pack(&[0], &[0f64; 0]));
    let plan = v1::PlanUpdate {
        knots: Some(Tensor::pack(&[1, 1, 1, 3], &[0f32; 3])),
        coordinates: Some(Tensor::pack(&[1, 3], &[0f64; 3])),
        cost_terms: no_costs.clone(),
        strain: 0.5,
        ..v1::PlanUpdate::default()
    };
    let stepped = Stepped::try_from(SteppedSession {
        corrected: Some(corrected),
        plan: Some(plan),
        advanced: Some(RollOutResponse { worker, costs: no_costs, ..RollOutResponse::default() }),
        state: Some(GivenState { positions, ..GivenState::default() }),
        lost: true,
        ..SteppedSession::default()
    })
    .unwrap();
    assert_eq!((stepped.corrected.unwrap().slot, stepped.refused), (3, None));
    assert!(stepped.lost && stepped.advanced.is_some());
    assert_eq!((stepped.plan.strain, stepped.state.positions), (0.5, vec![[0.5; 3]]));
}

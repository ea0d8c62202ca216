//! Corrections that last: rest shapes of slots, in all that is simulated from them.

use bendtwin_core::Point;
use bendtwin_proto::v1::{CorrectOptions, Ensemble, Vary, initial_state::SessionSlots};

use super::*;
use crate::{
    request::initial::Start,
    session::{
        Begun, Session, Sessions,
        correct::{CorrectionInput, corrected},
    },
    tests::registration::{session, tracked},
};

/// A twin and a session of it.
struct RunningSession {
    bench: Bench,
    sessions: Sessions,
    session: Arc<Session>,
}

impl RunningSession {
    /// A session with slots at rest, of a chain whose rest lengths have this factor.
    fn new(slots: usize, longer: f32) -> Self {
        let mut twin = twin();
        twin.params.rest_lengths_m.iter_mut().for_each(|length| *length *= longer);
        Self::of(twin, slots)
    }

    /// A session with slots at rest.
    fn of(twin: Twin, slots: usize) -> Self {
        let bench = Bench::of(twin, bendtwin_engine::cpu_with_threads(2));
        let sessions = Sessions::default();
        let session = sessions.add(session(&bench, slots)).unwrap();
        Self { bench, sessions, session }
    }

    /// A plan from slots.
    async fn plan(
        &self,
        slots: &[u32],
        commit: &[u32],
        request: RollOutRequest,
    ) -> (Plan, Starts, Begun) {
        let slots = SessionSlots { session: self.session.id.to_string(), slots: slots.to_vec() };
        let initial = Some(InitialState { state: Some(State::Session(slots)) });
        let mut request = RollOutRequest { initial, ..request };
        let begun = Begun::new(&self.sessions, &mut request, commit.to_vec());
        let begun = begun.await.unwrap().unwrap();
        let starts = begun.starts();
        let exact = Served::exact(Arc::clone(&self.bench.warm));
        let served = Served { rests: starts.rests(), ..exact };
        (self.bench.plan_for(request, 16, served).unwrap().0, starts, begun)
    }

    /// The parts of a rollout from slots, which stay where they are.
    async fn roll_out(&self, slots: &[u32], request: RollOutRequest) -> Vec<RollOutResponse> {
        let (plan, starts, _) = self.plan(slots, &[], request).await;
        self.bench.execute(&plan, &starts).unwrap()
    }

    /// Nodes of slots at the end of a rollout.
    async fn predict(&self, slots: &[u32], request: RollOutRequest) -> Vec<Point> {
        let parts = self.roll_out(slots, request).await;
        let last = parts.last().unwrap().final_positions.as_ref().unwrap();
        last.unpack_points("final").unwrap().1
    }

    async fn advance(&self, slots: &[u32], frames: u32) {
        self.advance_by(slots, still(slots.len(), frames)).await;
    }

    async fn advance_by(&self, slots: &[u32], request: RollOutRequest) {
        let (plan, starts, begun) = self.plan(slots, slots, request).await;
        let execution = Execution {
            plan: &plan,
            starts: &starts,
            backend: &self.bench.backend,
            cancel: &CancelToken::default(),
            until: None,
            arrived: Instant::now(),
            worker: "w",
            keeps_states: begun.commits(),
        };
        let states = execution.run(|_| Ok(())).unwrap();
        begun.commit(states, plan.frames).unwrap();
    }

    fn correct(&self, slot: usize, there: &[Point], carry: f64) {
        let options = CorrectOptions { carry: Some(carry), ..CorrectOptions::default() };
        let backend = &self.bench.backend;
        let warm = &self.bench.warm;
        let by = CorrectionInput::new(warm, backend, &self.session.setup, tracked(there), options)
            .unwrap();
        corrected(&self.session, &[slot], &by, Vec::new(), &CancelToken::default()).unwrap();
    }

    fn nodes(&self, slot: usize) -> Vec<Point> {
        self.session.states(&[slot]).0.remove(0).state.positions.clone()
    }

    /// Rest lengths of the models of a plan's instances, by instance, and their stiffness.
    fn springs(plan: &Plan, starts: &Starts, instances: usize) -> Vec<(Vec<f32>, f32)> {
        let springs = |i| {
            let instance = plan.instance(i, starts);
            let params = &instance.model.model().params;
            (params.rest_lengths_m.clone(), params.spring_stiffness[0])
        };
        (0..instances).map(springs).collect()
    }
}

/// Instances whose control point stays at rest.
fn still(instances: usize, frames: u32) -> RollOutRequest {
    let positions = vec![[0.0, 0.0, 0.6]; 2 * instances];
    RollOutRequest {
        actions: Some(Actions::Trajectories(ControlTrajectories {
            positions: Some(Tensor::pack_points(&[instances, 2, 1], &positions)),
            interpolation: 0,
        })),
        frames,
        returns: Some(Returns { final_state: true, ..Returns::default() }),
        ..RollOutRequest::default()
    }
}

fn mean_apart(a: &[Point], b: &[Point]) -> f64 {
    let apart = a.iter().zip(b).map(|(a, b)| bendtwin_core::geometry::point_distance(*a, *b));
    apart.sum::<f64>() / a.len() as f64
}

#[tokio::test]
async fn what_corrections_carry_stays_in_predictions() {
    let (there, here) = (RunningSession::new(1, 1.15), RunningSession::new(2, 1.0));
    for _ in 0..8 {
        there.advance(&[0], 5).await;
        here.advance(&[0, 1], 5).await;
        here.correct(0, &there.nodes(0), 1.0);
        here.correct(1, &there.nodes(0), 0.0);
    }
    let seen = there.predict(&[0], still(1, 15)).await;
    let predicted = here.predict(&[0, 1], still(2, 15)).await;
    let error = |slot: usize| mean_apart(&predicted[4 * slot..4 * (slot + 1)], &seen);
    assert!(error(0) < 0.5 * error(1), "{} and {} m", error(0), error(1));
}

#[tokio::test]
async fn a_rest_shape_goes_where_its_slot_goes() {
    let (there, here) = (RunningSession::new(1, 1.15), RunningSession::new(3, 1.0));
    there.advance(&[0], 5).await;
    here.advance(&[0, 1, 2], 5).await;
    here.correct(0, &there.nodes(0), 1.0);
    here.session.fork(0, &[1]);
    let rest = |slot: usize| here.session.states(&[slot]).0.remove(0).rest;
    let own = rest(0).unwrap();
    here.advance(&[0, 1], 5).await;
    for slot in [0, 1] {
        assert!(Arc::ptr_eq(&rest(slot).unwrap(), &own));
    }
    assert_eq!(here.nodes(0), here.nodes(1));
    here.correct(0, &here.nodes(0), 1.0);
    assert!(Arc::ptr_eq(&rest(0).unwrap(), &own), "nothing was to be corrected");

    // A reset slot is as one that never was corrected.
    here.session.reset(&[0, 1, 2], None);
    assert!(rest(0).is_none());
    let untouched = RunningSession::new(1, 1.0).predict(&[0], still(1, 5)).await;
    let after = here.predict(&[0, 1, 2], still(3, 5)).await;
    assert!(after.chunks(4).all(|nodes| nodes == untouched));
}

#[tokio::test]
async fn instances_have_the_rest_shapes_of_their_slots_and_factors_on_top() {
    let (there, here) = (RunningSession::new(1, 1.15), RunningSession::new(3, 1.0));
    there.advance(&[0], 5).await;
    here.correct(0, &there.nodes(0), 1.0);
    here.session.fork(0, &[1]);
    let (own, mut changed) = (here.bench.warm.loaded.model(), None);
    let stiffness = |factors: &[f32]| {
        let factors = Tensor::pack(&[factors.len()], factors);
        Some(Vary { stiffness: Some(factors), ..Vary::default() })
    };
    for (slots, instances, factors, members, expected) in [
        (vec![0], 2, vec![], 1, vec![(true, 1.0); 2]),
        (vec![0, 2, 1], 3, vec![], 1, vec![(true, 1.0), (false, 1.0), (true, 1.0)]),
        (vec![2, 0], 2, vec![0.5, 0.25], 1, vec![(false, 0.5), (true, 0.25)]),
        (
            vec![0, 2],
            2,
            vec![0.5, 0.25],
            2,
            vec![(true, 0.5), (true, 0.25), (false, 0.5), (false, 0.25)],
        ),
    ] {
        let request = RollOutRequest {
            vary: if factors.is_empty() { None } else { stiffness(&factors) },
            ensemble: (members > 1).then(|| Ensemble { members, ..Ensemble::default() }),
            ..still(instances, 3)
        };
        let (plan, starts, _) = here.plan(&slots, &[], request).await;
        let found = RunningSession::springs(&plan, &starts, expected.len());
        for ((lengths, stiffness), (is_changed, factor)) in found.into_iter().zip(expected) {
            assert_eq!(stiffness, factor * own.params.spring_stiffness[0]);
            if is_changed {
                assert_ne!(lengths, own.params.rest_lengths_m);
                assert_eq!(lengths, *changed.get_or_insert_with(|| lengths.clone()));
            } else {
                assert_eq!(lengths, own.params.rest_lengths_m);
            }
        }
    }
}

#[tokio::test]
async fn windows_and_gradients_are_of_the_same_rest_shape() {
    let (there, here) = (RunningSession::new(1, 1.15), RunningSession::new(1, 1.0));
    there.advance(&[0], 5).await;
    here.correct(0, &there.nodes(0), 1.0);
    let whole = here.predict(&[0], still(1, 6)).await;
    let mut parted = still(1, 6);
    parted.returns.as_mut().unwrap().part_frames = 2;
    assert_eq!(here.predict(&[0], parted).await, whole);

    let mut steered = RollOutRequest { costs: vec![keypoint_cost(0.06)], ..still(1, 6) };
    steered.returns.as_mut().unwrap().control_gradients = true;
    let carried = here.roll_out(&[0], steered.clone()).await.remove(0);
    // The same state with the rest shape of the twin.
    let start = here.session.states(&[0]).0.remove(0);
    here.session.reset(&[0], Some(vec![Start { rest: None, ..start }]));
    let own = here.roll_out(&[0], steered).await.remove(0);
    assert_ne!(carried.final_positions, own.final_positions);
    assert_ne!(carried.control_gradients, own.control_gradients);
}

/// A slot of a twin with members, advanced by the mean of the fits, continues from the mean.
#[tokio::test]
async fn an_advance_by_the_mean_of_the_fits_leaves_their_mean_in_the_slot() {
    let mut softer = twin();
    softer.params.spring_stiffness = vec![200.0; 4];
    let twin = twin();
    let members = vec![bendtwin_core::twin::Member::of(&softer, &twin).unwrap()];
    let running = RunningSession::of(Twin { members, ..twin }, 1);
    let alone = |stiffness: f32| {
        let mut twin = super::twin();
        twin.params.spring_stiffness = vec![stiffness; 4];
        RunningSession::of(twin, 1)
    };
    let of_mean = || {
        let mut request = still(1, 5);
        let statistic = bendtwin_proto::v1::ensemble::Statistic::MeanPrediction.into();
        request.vary = Some(Vary { fits: true, ..Vary::default() });
        request.ensemble = Some(Ensemble { members: 2, statistic, share: 0.0 });
        request
    };
    let predicted = running.predict(&[0], of_mean()).await;
    running.advance_by(&[0], of_mean()).await;
    assert_eq!(running.nodes(0), predicted);
    let [stiff, soft] = [500.0, 200.0].map(alone);
    let [stiff, soft] =
        [stiff.predict(&[0], still(1, 5)).await, soft.predict(&[0], still(1, 5)).await];
    assert!(mean_apart(&stiff, &soft) > 1e-4);
    let between = stiff.iter().zip(&soft).map(|(a, b)| [0, 1, 2].map(|i| 0.5 * (a[i] + b[i])));
    assert!(mean_apart(&predicted, &between.collect::<Vec<_>>()) < 1e-6);
    // Both continue from their mean.
    let after = running.predict(&[0], of_mean()).await;
    assert!(mean_apart(&after, &predicted) > 1e-4);

    let mut of_costs = of_mean();
    of_costs.ensemble = Some(Ensemble { members: 2, ..Ensemble::default() });
    let slots = SessionSlots { session: running.session.id.to_string(), slots: vec![0] };
    of_costs.initial = Some(InitialState { state: Some(State::Session(slots)) });
    let begun = Begun::new(&running.sessions, &mut of_costs, vec![0]).await;
    assert!(begun.err().unwrap().to_string().contains("MEAN_PREDICTION"));
}

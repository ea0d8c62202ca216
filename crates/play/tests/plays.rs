//! Plays with a host that moves every node to the first gripper.

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    task::Poll,
    time::Duration,
};

use bendtwin_core::{
    Category, Fault, Problem as _,
    ids::{PlayId, TwinId},
};
use bendtwin_play::{
    Begin, Document, Error, Host, Limits, Player, Plays, Recording, Result, Updates, View, read,
};
use bendtwin_proto::v1::{
    AdvanceSessionRequest, OpenSessionRequest, PlanRequest, PlanUpdate, ResetSessionRequest,
    RollOutResponse, Tensor, TwinGeometry, initial_state::GivenState, roll_out_request::Actions,
};
use futures::{FutureExt as _, StreamExt as _, future::BoxFuture, stream};
use serde_json::{Value, json};
use tokio_util::sync::CancellationToken;

/// Nodes of the twin.
const NODES: usize = 3;

#[derive(Default)]
struct Mover {
    opened: AtomicUsize,
    closed: AtomicUsize,
    reset: AtomicUsize,
    /// True if a search for a plan continues until it is dropped.
    searches_on: AtomicBool,
    /// Each such search has a share of it.
    searches: Arc<()>,
    /// Searches under way when a session was last closed.
    searches_at_close: AtomicUsize,
    /// The error of the next frame.
    fails: Mutex<Option<Error>>,
}

fn points(at: [f32; 3], count: usize) -> Option<Tensor> {
    Some(Tensor::pack_points(&[count], &vec![at; count]))
}

fn state(at: [f32; 3]) -> GivenState {
    GivenState { positions: points(at, NODES), controls: points(at, 1), ..GivenState::default() }
}

impl Mover {
    /// Searches under way.
    fn searches(&self) -> usize {
        Arc::strong_count(&self.searches) - 1
    }

    fn advance(&self, request: AdvanceSessionRequest) -> Result<RollOutResponse> {
        if let Some(error) = self.fails.lock().unwrap().take() {
            return Err(error);
        }
        let rollout = request.rollout.unwrap();
        let Some(Actions::Poses(poses)) = rollout.actions else { panic!("no poses") };
        let (shape, values) = poses.poses.unwrap().unpack::<f32>("poses").unwrap();
        let last = (shape[1] - 1) * shape[2] * 7;
        let at = [values[last], values[last + 1], values[last + 2]];
        let GivenState { positions, controls, .. } = state(at);
        Ok(RollOutResponse {
            final_positions: positions,
            final_controls: controls,
            ..RollOutResponse::default()
        })
    }
}

fn ready<'a, T: Send + 'a>(value: Result<T>) -> BoxFuture<'a, Result<T>> {
    std::future::ready(value).boxed()
}

impl Host for Mover {
    fn owner(&self) -> &str {
        "ada"
    }

    fn open_session(&self, _: OpenSessionRequest, _: Duration) -> BoxFuture<'_, Result<String>> {
        let nth = self.opened.fetch_add(1, Ordering::SeqCst);
        ready(Ok(format!("sessions/{nth}")))
    }

    fn session_state(&self, _: String, _: Duration) -> BoxFuture<'_, Result<GivenState>> {
        ready(Ok(state([0.0; 3])))
    }

    fn advance_session(
        &self,
        request: AdvanceSessionRequest,
        _: Duration,
    ) -> BoxFuture<'_, Result<RollOutResponse>> {
        ready(self.advance(request))
    }

    fn reset_session(&self, _: ResetSessionRequest, _: Duration) -> BoxFuture<'_, Result<()>> {
        self.reset.fetch_add(1, Ordering::SeqCst);
        ready(Ok(()))
    }

    fn close_session(&self, _: String, _: Duration) -> BoxFuture<'_, Result<()>> {
        self.searches_at_close.store(self.searches(), Ordering::SeqCst);
        self.closed.fetch_add(1, Ordering::SeqCst);
        ready(Ok(()))
    }

    fn plan(&self, request: PlanRequest, _: Duration) -> BoxFuture<'_, Result<Updates>> {
        if self.searches_on.load(Ordering::SeqCst) {
            let share = Arc::clone(&self.searches);
            let search = stream::poll_fn(move |_| {
                let _share = &share;
                Poll::Pending
            });
            return ready(Ok(search.boxed()));
        }
        // To hold the first gripper at x = 0.5 m through all knots.
        let rollout = request.rollout.unwrap();
        let Some(Actions::Poses(poses)) = rollout.actions else { panic!("no poses") };
        let (shape, mut values) = poses.poses.unwrap().unpack::<f32>("poses").unwrap();
        for knot in values.chunks_mut(shape[2] * 7) {
            knot[0] = 0.5;
        }
        let knots = Some(Tensor::pack(&[1, shape[1], shape[2], 7], &values));
        let update = PlanUpdate { knots, last: true, cost: 0.0, ..PlanUpdate::default() };
        ready(Ok(stream::iter([Ok(update)]).boxed()))
    }

    fn problem(&self, error: Error) -> Value {
        json!({"reason": error.reason(), "detail": error.to_string()})
    }
}

fn plays(limits: Limits) -> (Plays, CancellationToken) {
    let stopping = CancellationToken::new();
    (Plays::new(limits, stopping.clone()), stopping)
}

fn limits() -> Limits {
    Limits { plays: 2, watchers: 1, idle: Duration::from_secs(3600) }
}

async fn begin(plays: &Plays, host: &Arc<Mover>) -> Result<Player> {
    let geometry = TwinGeometry {
        fps: 200.0,
        rest_positions: points([0.0; 3], NODES),
        controls: points([0.0; 3], 1),
        hands: Some(Tensor::pack(&[1], &[0u32])),
        ..TwinGeometry::default()
    };
    let host = Arc::clone(host) as Arc<dyn Host>;
    plays.begin(host, TwinId::generate(), &geometry, Begin::default()).await
}

fn id(view: &View) -> PlayId {
    let ready: Value = serde_json::from_str(view.ready()).unwrap();
    ready["play"].as_str().unwrap().parse().unwrap()
}

fn say(player: &Player, message: Value) {
    player.inbox.push(read(&message.to_string()).unwrap()).unwrap();
}

/// Waits for a state in which the nodes are at this x, within the accuracy of the message.
async fn reaches(view: &mut View, x: f32) {
    let at = |state: &[u8]| {
        (state.len() > 36).then(|| f32::from_le_bytes(state[16..20].try_into().unwrap()))
    };
    view.states
        .wait_for(|state| at(state).is_some_and(|now| (now - x).abs() < 1e-5))
        .await
        .unwrap();
}

async fn reply(player: &mut Player) -> Value {
    serde_json::from_str(&player.replies.recv().await.unwrap()).unwrap()
}

async fn farewell(view: &mut View) -> Value {
    let text = view.farewell.wait_for(Option::is_some).await.unwrap().clone();
    serde_json::from_str(&text.unwrap()).unwrap()
}

#[tokio::test]
async fn a_play_moves_until_its_player_leaves() {
    let ((plays, _stop), host) = (plays(limits()), Arc::<Mover>::default());
    let player = begin(&plays, &host).await.unwrap();
    let mut view = player.view();
    say(&player, json!({"type": "move", "grippers": [{"index": 0, "position": [0.1, 0, 0]}]}));
    reaches(&mut view, 0.1).await;
    let play = id(&view);
    assert!(plays.get(play).is_ok());
    drop(player);
    assert_eq!(farewell(&mut view).await, json!({"type": "ended", "problem": null}));
    assert!(matches!(plays.get(play), Err(Error::Ended(_))));
    plays.ended().await;
    assert_eq!([&host.opened, &host.closed].map(|n| n.load(Ordering::SeqCst)), [1, 1]);
}

#[tokio::test]
async fn plays_and_watchers_have_limits() {
    let ((plays, stop), host) = (plays(limits()), Arc::<Mover>::default());
    let first = begin(&plays, &host).await.unwrap();
    let second = begin(&plays, &host).await.unwrap();
    assert!(matches!(begin(&plays, &host).await, Err(Error::Full { most: 2, .. })));
    let play = id(&first.view());
    let mut watcher = plays.watch(play).unwrap();
    assert!(matches!(plays.watch(play), Err(Error::Full { most: 1, .. })));
    // Its player's view is not one of a watcher.
    drop(first.view());
    assert!(plays.watch(play).is_err());
    stop.cancel();
    assert_eq!(farewell(&mut watcher).await["problem"]["reason"], "STOPPING");
    plays.ended().await;
    drop((watcher, first, second));
}

#[tokio::test]
async fn a_wrong_command_is_refused_and_changes_nothing() {
    let ((plays, _stop), host) = (plays(limits()), Arc::<Mover>::default());
    let mut player = begin(&plays, &host).await.unwrap();
    let mut view = player.view();
    let number = |state: &[u8]| {
        state.get(4..8).map_or(0, |number| u32::from_le_bytes(number.try_into().unwrap()))
    };
    let before = view.states.wait_for(|state| number(state) > 0).await.unwrap().clone();
    say(&player, json!({"type": "grasp", "gripper": 99, "node": 0}));
    let refused = reply(&mut player).await;
    assert_eq!(
        (&refused["type"], &refused["problem"]["reason"]),
        (&json!("refused"), &json!("INVALID_FIELD"))
    );
    say(&player, json!({"type": "replay"}));
    assert_eq!(reply(&mut player).await["problem"]["reason"], "NOTHING_RECORDED");
    assert!(read("{\"type\": \"speed\", \"factor\": 99}").is_err());
    // The next one is of a frame after the commands.
    let newest = number(&view.states.borrow());
    let after = view.states.wait_for(|state| number(state) > newest).await.unwrap().clone();
    assert_eq!((&after[..4], &after[8..]), (&before[..4], &before[8..]), "all but its number");
}

#[tokio::test]
async fn what_was_recorded_is_shown_again_and_travels_as_a_document() {
    let ((plays, _stop), host) = (plays(limits()), Arc::<Mover>::default());
    let mut player = begin(&plays, &host).await.unwrap();
    let mut view = player.view();
    say(&player, json!({"type": "record", "on": true}));
    say(&player, json!({"type": "move", "grippers": [{"index": 0, "position": [0.2, 0, 0]}]}));
    reaches(&mut view, 0.2).await;
    say(&player, json!({"type": "record", "on": false}));
    say(&player, json!({"type": "reset"}));
    say(&player, json!({"type": "replay"}));
    let replayed = reply(&mut player).await;
    assert_eq!(replayed["event"], "replayed", "{replayed}");
    reaches(&mut view, 0.2).await;
    assert_eq!(host.reset.load(Ordering::SeqCst), 1);

    let play = plays.get(id(&view)).unwrap();
    let recording = play.recording().unwrap();
    let text = recording.write(play.twin(), play.frame_s()).unwrap();
    let document: Document = serde_json::from_slice(&text).unwrap();
    let again = Recording::read(document, play.twin()).unwrap();
    assert_eq!(again.write(play.twin(), play.frame_s()).unwrap(), text);
    let document: Document = serde_json::from_slice(&text).unwrap();
    assert!(Recording::read(document, TwinId::generate()).is_err(), "of another twin");
}

#[tokio::test]
async fn a_lost_worker_is_replaced_and_a_defect_ends_the_play() {
    let ((plays, _stop), host) = (plays(limits()), Arc::<Mover>::default());
    let mut player = begin(&plays, &host).await.unwrap();
    let mut view = player.view();
    let fault = |category, reason: &str| Fault {
        category,
        reason: reason.to_owned(),
        message: "gone".to_owned(),
    };
    let host_error = |fault| Error::Host { fault, retry_after: None };
    *host.fails.lock().unwrap() = Some(host_error(fault(Category::Unavailable, "WORKER_LOST")));
    assert_eq!(reply(&mut player).await["event"], "reopening");
    assert_eq!(reply(&mut player).await["event"], "reopened");
    assert_eq!(host.opened.load(Ordering::SeqCst), 2);
    say(&player, json!({"type": "move", "grippers": [{"index": 0, "position": [0.3, 0, 0]}]}));
    reaches(&mut view, 0.3).await;
    *host.fails.lock().unwrap() = Some(host_error(fault(Category::Internal, "X")));
    assert_eq!(farewell(&mut view).await["problem"]["detail"], "gone");
}

#[tokio::test]
async fn a_goal_is_planned_and_followed() {
    let ((plays, _stop), host) = (plays(limits()), Arc::<Mover>::default());
    let player = begin(&plays, &host).await.unwrap();
    let mut view = player.view();
    let target = json!({"node": 1, "position": [0.5, 0, 0]});
    say(&player, json!({"type": "goal", "targets": [target], "frames": 10}));
    let is_reached = |facts: &Arc<str>| {
        let facts: Value = serde_json::from_str(facts).unwrap_or_default();
        facts["goal"]["state"] == "reached"
    };
    view.facts.wait_for(is_reached).await.unwrap();
}

#[tokio::test]
async fn a_search_ends_before_the_session_of_a_player_who_left() {
    let ((plays, _stop), host) = (plays(limits()), Arc::<Mover>::default());
    host.searches_on.store(true, Ordering::SeqCst);
    let player = begin(&plays, &host).await.unwrap();
    let mut view = player.view();
    let target = json!({"node": 1, "position": [0.5, 0, 0]});
    say(&player, json!({"type": "goal", "targets": [target], "frames": 10}));
    let is_planning = |facts: &Arc<str>| {
        let facts: Value = serde_json::from_str(facts).unwrap_or_default();
        facts["goal"]["state"] == "planning"
    };
    view.facts.wait_for(is_planning).await.unwrap();
    assert_eq!(host.searches(), 1);
    drop(player);
    plays.ended().await;
    assert_eq!(host.closed.load(Ordering::SeqCst), 1);
    assert_eq!(host.searches_at_close.load(Ordering::SeqCst), 0);
}

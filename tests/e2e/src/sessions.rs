//! Sessions as planners use them: over HTTP and from Rust, past the loss of their worker, and beside
//! clients that open them and go away.

use std::time::Duration;

use bendtwin_client::{
    Client, NewSession, PictureCamera, Point, Prop, Rendering, Rollout, SessionId, Shape, State,
};
use bendtwin_core::Category;
use bendtwin_proto::v1::{
    AdvanceSessionRequest, ForkSessionRequest, GetSessionStatesRequest, Grasp, OpenSessionRequest,
    ResetSessionRequest, Session, Sphere, Twin, grasp::Region,
};
use futures::StreamExt as _;
use reqwest::{Method, StatusCode};
use serde_json::{Value, json};

use crate::{
    harness::{
        Setup, TestCluster, cluster::Memory, http::Http, reference::reference, until, within,
    },
    rollouts,
};

const SOON: Duration = Duration::from_secs(60);

/// A twin at a server, and the way of its control points over frames.
struct Story {
    server: TestCluster,
    twin: Twin,
    rest: Vec<Point>,
}

impl Story {
    async fn begin() -> Self {
        Self::with(Setup::default()).await
    }

    async fn with(setup: Setup) -> Self {
        let file = reference().await.file;
        let server = TestCluster::start(setup).await;
        let twin = server.api().import(&file).await.unwrap();
        Self { server, twin, rest: rollouts::rest_controls(&file) }
    }

    /// The way from one frame to another, shape [1, frames, C].
    fn path(&self, frames: std::ops::RangeInclusive<usize>) -> ([usize; 3], Vec<Point>) {
        let shape = [1, frames.clone().count(), self.rest.len()];
        let at = |frame: usize| {
            let up = 1e-3 * frame as f32;
            self.rest.iter().map(move |p| [p[0], p[1], p[2] + up])
        };
        (shape, frames.flat_map(at).collect())
    }

    fn rollout(&self, frames: std::ops::RangeInclusive<usize>) -> Rollout {
        let (shape, positions) = self.path(frames);
        let twin = self.twin.name.parse().unwrap();
        Rollout::of(twin).trajectories(shape, positions).final_state()
    }

    async fn client(&self) -> Client {
        Client::connect_with_token(&self.server.url(), None).await.unwrap()
    }

    /// State at the end of one rollout of all these frames.
    async fn whole(&self, client: &Client, frames: usize) -> State {
        let reply = client.rollouts().run(self.rollout(0..=frames)).await.unwrap();
        reply.state(0).unwrap()
    }
}

async fn post(http: &Http, path: &str, body: &Value) -> (StatusCode, Value) {
    let reply = http.request(Method::POST, path).json(body).send().await.unwrap();
    (reply.status(), reply.json().await.unwrap())
}

#[tokio::test]
async fn a_session_over_http_goes_where_one_rollout_goes() {
    let story = Story::begin().await;
    let (http, client) = (story.server.http(), story.client().await);
    let open = json!({"twin": story.twin.name, "slots": 3, "idle_timeout_s": 60});
    let opened = http.request(Method::POST, "/v1/sessions").json(&open).send().await.unwrap();
    assert_eq!(opened.status(), StatusCode::CREATED);
    let path = opened.headers()["location"].to_str().unwrap().to_owned();
    let opened: Value = opened.json().await.unwrap();
    assert_eq!(path, format!("/v1/{}", opened["name"].as_str().unwrap()));
    assert_eq!((&opened["slots"], &opened["fidelity"]), (&json!(3), &json!("EXACT")));

    for frames in [0..=3, 3..=5] {
        let (shape, positions) = story.path(frames);
        let rows: Vec<_> = positions.chunks(shape[2]).collect();
        let rollout =
            json!({"trajectories": {"positions": [rows]}, "returns": {"final_state": true}});
        let advance = json!({"slots": [1], "rollout": rollout});
        let (status, reply) = post(&http, &format!("{path}/advance"), &advance).await;
        assert_eq!(status, StatusCode::OK, "{reply}");
    }
    assert_eq!(http.get_json(&path).await["frames"], json!([0, 5, 0]));
    let states = http.get_json(&format!("{path}/states?slots=1")).await;
    assert_eq!((&states["slots"], &states["frames"]), (&json!([1]), &json!([5])));
    let ends = story.whole(&client, 5).await;
    let positions: Vec<Vec<Point>> =
        serde_json::from_value(states["states"]["positions"].clone()).unwrap();
    assert_eq!(positions, [ends.positions]);

    let (status, forked) =
        post(&http, &format!("{path}/fork"), &json!({"from": 1, "to": [0]})).await;
    assert_eq!((status, &forked["frames"]), (StatusCode::OK, &json!([5, 5, 0])));
    let ahead = json!({
        "trajectories": {"positions": [story.path(5..=7).1.chunks(story.rest.len()).collect::<Vec<_>>()]},
        "initial": {"session": {"session": opened["name"]}},
        "returns": {"final_state": true},
    });
    let (status, reply) = post(&http, &format!("/v1/{}/rollouts", story.twin.name), &ahead).await;
    assert_eq!(status, StatusCode::OK, "{reply}");
    let positions: Vec<Vec<Point>> =
        serde_json::from_value(reply["final_positions"].clone()).unwrap();
    assert_eq!(positions, [story.whole(&client, 7).await.positions]);

    let given = json!({"slots": [2], "initial": {"given": states["states"]}});
    let (status, reset) = post(&http, &format!("{path}/reset"), &given).await;
    assert_eq!((status, &reset["frames"]), (StatusCode::OK, &json!([5, 5, 0])), "{reset}");
    for (refused, body) in [
        ("advance", json!({"slots": [7], "rollout": ahead})),
        ("advance", json!({"name": "sessions/x", "rollout": {}})),
        ("fork", json!({"from": 0, "to": [1, 1]})),
        ("reset", json!({"slot": [1]})),
    ] {
        let (status, problem) = post(&http, &format!("{path}/{refused}"), &body).await;
        assert_eq!(status, StatusCode::BAD_REQUEST, "{refused}: {problem}");
    }
    let closed = http.request(Method::DELETE, &path).send().await.unwrap();
    assert_eq!(closed.status(), StatusCode::NO_CONTENT);
    let lost = http.get(&path).await;
    assert_eq!(lost.status(), StatusCode::CONFLICT);
    assert_eq!(lost.json::<Value>().await.unwrap()["reason"], "SESSION_LOST");
}

#[tokio::test]
async fn a_session_is_pictured_alike_over_grpc_and_http() {
    let story = Story::begin().await;
    let (http, client) = (story.server.http(), story.client().await);
    let sessions = client.sessions();
    let twin = story.twin.name.parse().unwrap();
    let session = sessions.open(NewSession::of(twin).slots(2)).await.unwrap();
    // From below and in front, in the middle of the object.
    let state = sessions.states(session.name, &[0]).await.unwrap().remove(0);
    let count = state.positions.len() as f32;
    let sum =
        state.positions.iter().fold([0.0; 3], |sum: Point, p| [0, 1, 2].map(|k| sum[k] + p[k]));
    let middle = sum.map(|x| x / count);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let pose = [middle[0], middle[1] - 1.0, middle[2], -half, 0.0, 0.0, half];
    let intrinsics = [60.0, 60.0, 31.5, 23.5];
    let camera = PictureCamera::new([64, 48], intrinsics, pose).background([9, 8, 7]);
    let ball = Prop::new(Shape::sphere([middle[0] + 0.3, middle[1], middle[2]], 0.1));
    let asked = Rendering::by([camera]).surface().prop(ball.color([200, 0, 0])).depths().labels();
    let taken = sessions.render(session.name, &[1, 0], asked).await.unwrap().remove(0);
    assert_eq!(taken.shape, [2, 48, 64]);
    for label in 0..=2 {
        assert!(taken.labels.contains(&label), "{label}");
    }
    assert!(taken.labels.iter().zip(&taken.depths).all(|(label, d)| (*label == 0) == (*d == 0.0)));
    assert!(taken.depths.iter().all(|d| *d == 0.0 || (0.2..3.0).contains(d)));

    let camera = json!({"width": 64, "height": 48, "intrinsics": intrinsics, "pose": pose,
        "background": [9, 8, 7]});
    let center = [middle[0] + 0.3, middle[1], middle[2]];
    let prop = json!({"sphere": {"center": center, "radius_m": 0.1}, "color": [200, 0, 0]});
    let body = json!({"cameras": [camera], "props": [prop], "look": "SURFACE", "slots": [1]});
    let path = format!("/v1/{}/render", session.name);
    let (status, reply) = post(&http, &path, &body).await;
    assert_eq!(status, StatusCode::OK, "{reply}");
    let colors: Vec<Vec<Vec<[u8; 3]>>> =
        serde_json::from_value(reply["cameras"][0]["colors"].clone()).unwrap();
    let colors = colors.concat().concat().concat();
    assert!(colors == taken.colors[..colors.len()], "the first picture of the other call");
    let gaussians = json!({"cameras": body["cameras"], "look": "GAUSSIANS"});
    let (status, problem) = post(&http, &path, &gaussians).await;
    assert_eq!((status, &problem["reason"]), (StatusCode::CONFLICT, &json!("GAUSSIANS_UNKNOWN")));
}

#[tokio::test]
async fn a_lost_session_resumes_from_the_last_state_of_a_reply() {
    let story = Story::begin().await;
    let client = story.client().await;
    let (sessions, twin) = (client.sessions(), story.twin.name.parse().unwrap());
    let expected = story.whole(&client, 6).await;
    let session = sessions.open(NewSession::of(twin)).await.unwrap();
    let reply = sessions.advance(session.name, &[], story.rollout(0..=3)).await.unwrap();
    let last = reply.state(0).unwrap();
    let found = sessions.states(session.name, &[]).await.unwrap();
    assert_eq!(found, std::slice::from_ref(&last));

    story.server.kill_workers();
    lost(&client, session.name).await;
    let again = until("a session at a new worker", SOON, async || {
        let opened = sessions.open(NewSession::of(twin).going_on(&last)).await;
        match opened {
            Ok(session) => Some(session),
            Err(error) => {
                assert!(error.is_transient(), "{error}");
                None
            }
        }
    });
    let again = again.await;
    assert_ne!((again.name, again.worker), (session.name, session.worker));
    let steps = (3..6).map(|frame| story.rollout(frame..=frame + 1)).collect::<Vec<_>>();
    let control = sessions.control(again.name, &[], futures::stream::iter(steps)).await.unwrap();
    let replies: Vec<_> = control.collect().await;
    let end = replies.last().unwrap().as_ref().unwrap().state(0).unwrap();
    assert_eq!((replies.len(), end), (3, expected));
    // A rollout that cannot be sent ends the stream with its fault.
    let wrong = Rollout::of(twin).trajectories([1, 2, 1], Vec::new());
    let control = sessions.control(again.name, &[], futures::stream::iter([wrong])).await.unwrap();
    let replies: Vec<_> = control.collect().await;
    assert_eq!(replies[0].as_ref().unwrap_err().category(), Category::InvalidArgument);
    sessions.close(again.name).await.unwrap();
    sessions.close(again.name).await.unwrap();
}

/// Waits until it is known that a session is lost.
async fn lost(client: &Client, name: SessionId) {
    until("the loss of a session", SOON, async || {
        let error = client.sessions().get(name).await.unwrap_err();
        if error.reason() == "SESSION_LOST" {
            assert_eq!(error.category(), Category::Aborted);
            return Some(());
        }
        assert!(error.is_transient(), "{error}");
        None
    })
    .await;
}

#[tokio::test]
async fn sessions_outlive_a_restart_of_the_server_if_their_worker_does() {
    let mut story = Story::with(Setup { own_workers: 0, ..Setup::default() }).await;
    story.server.start_worker().await;
    let (client, twin) = (story.client().await, story.twin.name.parse().unwrap());
    let session =
        until("a session", SOON, async || client.sessions().open(NewSession::of(twin)).await.ok())
            .await;
    client.sessions().advance(session.name, &[], story.rollout(0..=3)).await.unwrap();
    let before = client.sessions().states(session.name, &[]).await.unwrap();
    story.server.kill();
    story.server.start_again().await;
    let client = story.client().await;
    let after = until("the session after a restart", SOON, async || {
        client.sessions().states(session.name, &[]).await.ok()
    });
    assert_eq!(after.await, before);
}

#[tokio::test]
async fn clients_that_never_close_lock_no_one_out() {
    let story = Story::begin().await;
    let (client, twin) = (story.client().await, story.twin.name.parse().unwrap());
    let sessions = client.sessions();
    let mut opened = Vec::new();
    let refused = loop {
        match sessions.open(NewSession::of(twin)).await {
            Ok(session) => opened.push(session.name),
            Err(error) => break error,
        }
        assert!(opened.len() < 1000, "sessions without a bound");
    };
    assert_eq!(refused.category(), Category::ResourceExhausted, "{refused}");
    assert_eq!(refused.reason(), "TOO_MANY_SESSIONS");
    // Rollouts continue, and sessions fit again once one is closed, or has been unused for long.
    story.whole(&client, 3).await;
    sessions.close(opened.pop().unwrap()).await.unwrap();
    let short = NewSession::of(twin).idle_timeout(Duration::from_secs(1));
    let short = sessions.open(short).await.unwrap();
    let last =
        until("room for a session", SOON, async || sessions.open(NewSession::of(twin)).await.ok());
    assert_ne!(last.await.name, short.name);
    lost(&client, short.name).await;
}

#[tokio::test]
async fn states_beyond_the_memory_of_the_worker_are_refused() {
    let memory = Memory { server_mib: 256, worker_mib: 128, base_mib: 320 };
    let setup = Setup { own_workers: 0, memory: Some(memory), ..Setup::default() };
    let mut story = Story::with(setup).await;
    story.server.start_worker().await;
    let (client, twin) = (story.client().await, story.twin.name.parse().unwrap());
    let sessions = client.sessions();
    let new = |slots| sessions.open(NewSession::of(twin).slots(slots));
    until("a session", SOON, async || new(8).await.ok()).await;
    let refused = within("a refusal", SOON, new(4096)).await.unwrap_err();
    assert_eq!(refused.reason(), "MEMORY_TOO_SMALL", "{refused}");
}

#[tokio::test]
async fn wishes_beyond_all_bounds_are_refused() {
    let story = Story::begin().await;
    let mut sessions = story.server.api().sessions();
    let open = OpenSessionRequest {
        twin: story.twin.name.clone(),
        slots: 4,
        ..OpenSessionRequest::default()
    };
    let far = Grasp {
        gripper: u32::MAX,
        region: Some(Region::Sphere(Sphere { center: Vec::new(), radius_m: 0.1 })),
        ..Grasp::default()
    };
    for wrong in [
        OpenSessionRequest { slots: u32::MAX, ..open.clone() },
        OpenSessionRequest { idle_timeout_s: f64::NAN, ..open.clone() },
        OpenSessionRequest { idle_timeout_s: 1e300, ..open.clone() },
        OpenSessionRequest { grasps: vec![far; 4], ..open.clone() },
    ] {
        let status = sessions.open_session(wrong).await.unwrap_err();
        assert_eq!(status.code(), tonic::Code::InvalidArgument, "{status}");
    }
    let Session { name, .. } = sessions.open_session(open).await.unwrap().into_inner();
    let many = vec![0; 1 << 20];
    let asked = GetSessionStatesRequest { name: name.clone(), slots: many.clone() };
    let states = sessions.get_session_states(asked).await.unwrap_err();
    let fork = ForkSessionRequest { name: name.clone(), from: 1, to: many.clone() };
    let fork = sessions.fork_session(fork).await.unwrap_err();
    let reset = ResetSessionRequest { name: name.clone(), slots: many.clone(), initial: None };
    let reset = sessions.reset_session(reset).await.unwrap_err();
    let rollout = Some(story.rollout(0..=1).into_request().unwrap());
    let advance = AdvanceSessionRequest { name: name.clone(), slots: many, rollout };
    let advance = sessions.advance_session(advance).await.unwrap_err();
    for status in [states, fork, reset, advance] {
        assert_eq!(status.code(), tonic::Code::InvalidArgument, "{status}");
    }
    // A stream of controls that is begun and left keeps nobody from the session.
    let silent = futures::stream::pending::<AdvanceSessionRequest>();
    let _silent = sessions.control_session(silent).await.unwrap();
    let rollout = Some(story.rollout(0..=1).into_request().unwrap());
    let advance = AdvanceSessionRequest { name, slots: vec![3], rollout };
    within("an advance", SOON, sessions.advance_session(advance)).await.unwrap();
}

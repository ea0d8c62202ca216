//! Plays as a browser has them: dragging, grasping, recording and repeating, a goal, watchers, a worker
//! that is lost, and messages that no browser sends.

mod demo;
mod hostile;

use std::time::Duration;

use bendtwin_proto::v1::Twin;
use reqwest::{Method, StatusCode};
use serde_json::{Value, json};

use crate::harness::{
    Setup, TestCluster,
    play::{Event, Play, ShownState},
    reference::reference,
    until,
};

const SOON: Duration = Duration::from_secs(60);

/// A twin at a server.
struct Story {
    server: TestCluster,
    twin: Twin,
}

impl Story {
    async fn begin() -> Self {
        let file = reference().await.file;
        let server = TestCluster::start(Setup::default()).await;
        let twin = server.api().import(&file).await.unwrap();
        Self { server, twin }
    }

    async fn play(&self, begin: Value) -> Play {
        Play::begin(&self.server.url(), &self.twin.name, begin).await
    }

    async fn post(&self, path: &str, body: &Value) -> (StatusCode, Value) {
        let reply = self.server.http().request(Method::POST, path).json(body).send().await.unwrap();
        (reply.status(), reply.json().await.unwrap())
    }
}

fn begin() -> Value {
    json!({"type": "begin"})
}

fn place(shown: &ShownState, gripper: usize) -> [f32; 3] {
    std::array::from_fn(|i| shown.grippers[gripper][i])
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>().sqrt()
}

fn farthest(nodes: &[[f32; 3]], from: [f32; 3]) -> usize {
    let by = |i: &usize, j: &usize| apart(nodes[*i], from).total_cmp(&apart(nodes[*j], from));
    (0..nodes.len()).max_by(by).unwrap()
}

#[tokio::test]
async fn what_was_done_is_recorded_and_repeats_what_was_shown() {
    let story = Story::begin().await;
    let mut play = story.play(begin()).await;
    let hands =
        play.ready["grippers"].as_array().unwrap().iter().filter(|g| !g["hand"].is_null()).count();
    assert!(hands >= 1 && play.ready["fps"].as_f64().unwrap() > 1.0, "{}", play.ready);
    let first = play.shown("a state", |_| true).await;
    assert_eq!(first.nodes.len() as u64, play.ready["nodes"].as_u64().unwrap());
    play.send(json!({"type": "pause", "paused": true})).await;
    let first = play.shown("a pause", |s| s.flags & 1 == 1).await;
    play.send(json!({"type": "record", "on": true})).await;
    let mut seen: Vec<ShownState> = Vec::new();
    let mut last = first.clone();
    // Paused, so that every state is one of these frames.
    let grasped = hands;
    let end = farthest(&first.nodes, place(&first, 0));
    for frame in 1..=24u32 {
        let lift = |x: [f32; 3]| [x[0], x[1] + 0.002, x[2] + 0.004];
        match frame {
            8 => {
                play.send(
                    json!({"type": "grasp", "gripper": grasped, "node": end, "input": frame}),
                )
                .await;
            }
            12 => {
                let world = json!({"gravity": [0, 0, -3], "colliders": [{"name": "ball", "margin_m": 0.005,
                    "sphere": {"radius_m": 0.05}, "pose": [0, 0, -0.5, 0, 0, 0, 1]}]});
                play.send(json!({"type": "world", "world": world, "vary": {"damping": 1.5}})).await;
            }
            16 => play.send(json!({"type": "release", "gripper": 0})).await,
            20 => {
                let ball = json!([{"index": 0, "position": [0, 0, -0.3]}]);
                play.send(json!({"type": "move", "colliders": ball})).await;
            }
            _ => {}
        }
        let moved = if frame > 10 { grasped } else { 0 };
        play.aim(frame, moved, lift(place(&last, moved))).await;
        play.send(json!({"type": "step"})).await;
        let shown =
            play.shown("a step", |s| s.number == first.number + frame && s.input == frame).await;
        seen.push(shown.clone());
        last = shown;
    }
    assert!(apart(place(&seen[6], 0), place(&first, 0)) > 0.01, "the hand follows");
    // Grasped at the node, and moved for thirteen frames, in eight of which the whole rope hangs on
    // it: the grip yields as far as the twin is soft.
    let (stretch, way) = (
        apart(seen[23].nodes[end], place(&seen[23], grasped)),
        apart(place(&seen[23], grasped), place(&seen[9], grasped)),
    );
    assert!(way > 0.03 && stretch < 0.8 * way, "the node follows: {stretch} m of {way} m");
    assert_eq!((seen[23].grippers[0][10], seen[23].grippers[grasped][10]), (0.0, 1.0));
    assert!(seen[23].colliders[0][2] > -0.5 && seen[5].colliders.is_empty());
    play.send(json!({"type": "record", "on": false})).await;
    play.message("a recording", |t| t["recorded"] == 24).await;

    // Each segment is a rollout; one after another they give the displayed states.
    let path = play.ready["recording"].as_str().unwrap().to_owned();
    let recording = story.server.http().get_json(&path).await;
    let segments = recording["segments"].as_array().unwrap();
    assert!((2..=4).contains(&segments.len()), "{}", segments.len());
    let mut shown = seen.iter();
    for segment in segments {
        let path = format!("/v1/{}/rollouts", story.twin.name);
        let (status, reply) = story.post(&path, segment).await;
        assert_eq!(status, StatusCode::OK, "{reply}");
        for frame in reply["positions"][0].as_array().unwrap() {
            let shown = shown.next().unwrap();
            for (node, x) in frame.as_array().unwrap().iter().zip(&shown.nodes) {
                for (i, x) in x.iter().enumerate() {
                    let exact = node[i].as_f64().unwrap() as f32;
                    assert!((exact - x).abs() <= shown.scale, "{exact} {x} in {}", shown.number);
                }
            }
        }
    }
    assert!(shown.next().is_none());

    // The play shows the same again, bit for bit.
    play.send(json!({"type": "replay"})).await;
    let from = seen[23].number;
    for (k, before) in (1u32..).zip(&seen) {
        let again = play.shown("a replay", |s| s.number == from + k).await;
        assert_eq!(
            (&again.nodes, &again.grippers, &again.colliders),
            (&before.nodes, &before.grippers, &before.colliders),
            "frame {k}"
        );
    }
    play.message("the end of the replay", |t| t["event"] == "replayed").await;

    // As a document it can be put into another play.
    drop(play);
    let mut other = story.play(json!({"type": "begin", "initial": {"settled": {}}})).await;
    let path = other.ready["recording"].as_str().unwrap().to_owned();
    let put =
        |document: &Value| story.server.http().request(Method::PUT, &path).json(document).send();
    assert_eq!(put(&recording).await.unwrap().status(), StatusCode::NO_CONTENT);
    other.send(json!({"type": "replay"})).await;
    let again = other.shown("a replay", |s| s.flags & 4 == 4 && s.nodes == seen[23].nodes).await;
    assert_eq!(again.colliders, seen[23].colliders);
    let mut foreign = recording.clone();
    foreign["twin"] = json!("twins/0190a000-0000-7000-8000-00000000dead");
    let refused = put(&foreign).await.unwrap();
    assert_eq!(refused.status(), StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn it_runs_in_real_time_goes_back_and_refuses_worlds_that_cannot_be() {
    let story = Story::begin().await;
    let mut play = story.play(begin()).await;
    let first = play.shown("a state", |_| true).await;
    play.shown("frames by themselves", |s| s.number > first.number + 5).await;
    let far = [first.grippers[0][0], first.grippers[0][1], first.grippers[0][2] + 0.3];
    play.aim(7, 0, far).await;
    let there = play.shown("the hand at its target", |s| apart(place(s, 0), far) < 1e-4).await;
    assert_eq!(there.input, 7);
    // A rope that is held is felt.
    let force =
        play.shown("a force", |s| s.grippers[0][7..10].iter().any(|f| f.abs() > 1e-6)).await;
    assert!(force.grippers[0][7..10].iter().all(|f| f.is_finite()));
    play.send(json!({"type": "world", "world": {"ground_friction": 7}})).await;
    let refused = play.message("a refusal", |t| t["type"] == "refused").await;
    assert!(
        refused["problem"]["detail"].as_str().unwrap().contains("ground_friction"),
        "{refused}"
    );
    let frame = play.shown("a frame", |_| true).await.number;
    play.shown("that it continues", |s| s.number > frame + 3).await;
    play.send(json!({"type": "speed", "factor": 0.25})).await;
    play.message("the speed", |t| t["speed"] == 0.25).await;
    play.send(json!({"type": "pause", "paused": true})).await;
    play.send(json!({"type": "reset"})).await;
    let back = play.shown("the first state", |s| apart(place(s, 0), place(&first, 0)) < 1e-6).await;
    assert_eq!(back.nodes.len(), first.nodes.len());
    play.message("a pause", |t| t["paused"] == true && t["speed"] == 0.25).await;
    // From a state that another play has shown, with a hand that holds no more.
    let nodes = json!(there.nodes);
    let mut again = story
        .play(json!({"type": "begin", "initial": {"given": {"positions": nodes}}, "dropped": [0]}))
        .await;
    let shown = again.shown("the given state", |_| true).await;
    assert!(apart(shown.nodes[0], there.nodes[0]) < 0.05);
    assert_eq!(shown.grippers[0][10], 0.0);
}

#[tokio::test]
async fn the_planner_brings_a_point_to_its_goal() {
    let story = Story::begin().await;
    let mut play = story.play(json!({"type": "begin", "initial": {"settled": {}}})).await;
    let first = play.shown("a state", |s| s.number > 2).await;
    let end = farthest(&first.nodes, place(&first, 0));
    let near = first.nodes[end];
    let goal = json!([{"node": end, "position": [near[0], near[1] + 0.05, near[2] + 0.05]}]);
    play.send(json!({"type": "goal", "targets": goal, "tolerance_m": 0.03, "frames": 15})).await;
    let planning = play.message("a plan", |t| t["goal"]["state"] == "planning").await;
    let begun = planning["goal"]["distance_m"].as_f64().unwrap();
    let done = |t: &Value| t["goal"]["state"] == "reached" || t["goal"]["state"] == "not_reached";
    let ended = play.message("the end of the way", done).await;
    let distance = ended["goal"]["distance_m"].as_f64().unwrap();
    assert!(distance < 0.8 * begun && ended["goal"]["simulated"].as_u64().unwrap() > 0, "{ended}");
    play.send(json!({"type": "goal", "targets": [{"node": 9999, "position": [0, 0, 0]}]})).await;
    play.message("a refusal", |t| t["type"] == "refused").await;
}

#[tokio::test]
async fn a_play_resumes_from_its_last_state_when_its_worker_is_lost() {
    let story = Story::begin().await;
    let mut play = story.play(begin()).await;
    let first = play.shown("a state", |s| s.number > 3).await;
    let held = place(&first, 0);
    let target = [held[0], held[1], held[2] + 0.1];
    play.aim(1, 0, target).await;
    let before = play.shown("the hand at its target", |s| apart(place(s, 0), target) < 1e-4).await;
    story.server.kill_workers();
    play.message("another worker", |t| t["event"] == "reopened").await;
    assert!(play.replies.iter().any(|t| t["event"] == "reopening"));
    let after = play.shown("a state", |s| s.number > before.number + 10).await;
    assert!(apart(place(&after, 0), target) < 1e-4);
    let pinned = farthest(&before.nodes, [held[0], held[1], held[2] + 100.0]);
    assert!(apart(after.nodes[pinned], before.nodes[pinned]) < 0.2, "it is the same motion");
}

#[tokio::test]
async fn watchers_see_the_same_and_move_nothing() {
    let story = Story::begin().await;
    let mut play = story.play(begin()).await;
    let path = play.ready["watch"].as_str().unwrap().to_owned();
    let mut watcher = Play::watch(&story.server.url(), &path).await;
    assert_eq!(watcher.ready, play.ready);
    play.message("a watcher", |t| t["watchers"] == 1).await;
    watcher.aim(1, 0, [0.0; 3]).await;
    watcher.message("a refusal", |t| t["type"] == "refused").await;
    play.send(json!({"type": "pause", "paused": true})).await;
    let own = play.shown("a pause", |s| s.flags & 1 == 1).await;
    let seen = watcher.shown("a pause", |s| s.flags & 1 == 1).await;
    assert_eq!((own.number, &own.nodes, own.input), (seen.number, &seen.nodes, 0));
    // One that draws nothing is sent a few states, and then the newest when it draws again.
    watcher.draws = false;
    play.send(json!({"type": "pause", "paused": false})).await;
    let later = play.shown("more frames", |s| s.number > own.number + 60).await;
    let mut sent = Vec::new();
    let newest = until("the newest", SOON, async || {
        if let Event::Shown(shown) = watcher.next().await {
            sent.push(shown.number);
            if sent.len() == 8 {
                watcher.send(json!({"type": "seen", "frame": shown.number})).await;
            }
            return (shown.number >= later.number).then_some(shown);
        }
        None
    })
    .await;
    // A state of the pause may be among the first eight. Those that were on their way come before the newest.
    assert!(sent.len() <= 17, "{sent:?}");
    assert!(newest.number >= later.number && sent[7] < later.number, "{sent:?}");
    // With the one that plays the play ends.
    drop(play);
    watcher.closed().await;
    assert!(watcher.replies.iter().any(|t| t["type"] == "ended"), "{:?}", watcher.replies);
    let gone = story.server.http().get(&path.replace("watch", "recording")).await;
    assert_eq!(gone.status(), StatusCode::NOT_FOUND);
}

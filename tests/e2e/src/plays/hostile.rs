//! Sockets that no browser would open, and messages that no page sends.

use serde_json::json;

use super::{SOON, Story, begin};
use crate::harness::{
    play::{Event, Play, refused},
    within,
};

#[tokio::test]
async fn other_sites_cannot_open_sockets() {
    let story = Story::begin().await;
    let (url, path) = (story.server.url(), format!("/v1/{}/play", story.twin.name));
    let host = url.strip_prefix("http://").unwrap();
    assert_eq!(refused(&url, &path, &[("origin", "https://evil.example")]).await, 403);
    assert_eq!(refused(&url, &path, &[("origin", "null")]).await, 403);
    assert_eq!(refused(&url, &path, &[("origin", &format!("http://{host}"))]).await, 101);
    assert_eq!(
        refused(&url, "/v1/twins/0190a000-0000-7000-8000-00000000dead/play", &[]).await,
        404
    );
    assert_eq!(
        refused(&url, "/v1/plays/0190a000-0000-7000-8000-00000000dead/watch", &[]).await,
        404
    );
    assert_eq!(story.server.http().get(&path).await.status().as_u16(), 426);
}

#[tokio::test]
async fn invalid_first_messages_end_the_socket_with_the_fault() {
    let story = Story::begin().await;
    let (url, path) = (story.server.url(), format!("/v1/{}/play", story.twin.name));
    let firsts = [
        "{}x".to_owned(),
        json!({"type": "move"}).to_string(),
        json!({"type": "begin", "initial": {"given": {"positions": [[0, 0, 0]]}}}).to_string(),
        json!({"type": "begin", "world": {"gravity": [0]}}).to_string(),
        json!({"type": "begin", "dropped": [77]}).to_string(),
    ];
    for first in firsts {
        let mut play = Play::connect(&url, &path, &[]).await;
        play.send_text(first.clone()).await;
        play.closed().await;
        let last = play.replies.last().unwrap_or_else(|| panic!("{first}"));
        assert_eq!(last["type"], "ended", "{first}");
        assert!(last["problem"]["detail"].is_string(), "{first}: {last}");
    }
    // Larger than anything that is read.
    let mut play = Play::connect(&url, &path, &[]).await;
    play.send_text("x".repeat(5 << 20)).await;
    play.closed().await;
}

#[tokio::test]
async fn hostile_messages_are_refused_and_a_flood_ends_the_play() {
    let story = Story::begin().await;
    let mut play = story.play(begin()).await;
    let messages = [
        "null".to_owned(),
        "[".repeat(10_000),
        json!({"type": "grasp", "gripper": 4_000_000_000u32, "node": 0}).to_string(),
        json!({"type": "grasp", "gripper": 1, "node": 4_000_000_000u32}).to_string(),
        json!({"type": "world", "world": {"colliders": vec![json!({}); 1000]}}).to_string(),
        json!({"type": "world", "world": {"colliders": [{"sphere": {"radius_m": -1}}]}})
            .to_string(),
        json!({"type": "world", "vary": {"stiffness": 1e30}}).to_string(),
        json!({"type": "replay"}).to_string(),
        "x".repeat(100_000),
    ];
    for message in &messages {
        let before = play.replies.len();
        play.send_text(message.clone()).await;
        let what = &message[..message.len().min(60)];
        within(what, SOON, async {
            while !play.replies[before..].iter().any(|t| t["type"] == "refused") {
                assert!(!matches!(play.next().await, Event::Closed), "{what}");
            }
        })
        .await;
    }
    play.send_bytes(vec![0; 100]).await;
    play.message("a refusal", |t| t["type"] == "refused").await;
    let frame = play.shown("a frame", |_| true).await.number;
    play.shown("that it continues", |s| s.number > frame + 3).await;
    for input in 0..2_000u32 {
        play.aim(input, 0, [0.0; 3]).await;
    }
    play.closed().await;
    let last = play.replies.last().unwrap();
    assert_eq!(last["problem"]["reason"], "PLAY_TOO_FAST", "{last}");
}

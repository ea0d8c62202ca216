//! `bendtwin demo --open` on a machine without a screen, and a link to its twin.

use std::{io::BufRead as _, process::Stdio, time::Duration};

use serde_json::{Value, json};

use super::apart;
use crate::harness::{command::bendtwin, play::Play, process::signal, within};

const SOON: Duration = Duration::from_secs(300);

/// Somebody without a token plays with the twin until the link is revoked, and cannot search.
async fn others_play_through_a_link(url: &str, twin: &str, token: &str) {
    let ask = |arguments: &[&str]| -> Value {
        let mut command = bendtwin();
        command.args(["--json"]).args(arguments).args(["--server", url]);
        let output = command.env("BENDTWIN_TOKEN", token).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let made = ask(&["twin", "share", twin, "--days", "1", "--for", "a friend"]);
    let page = format!("{url}/#/{}?key=", twin.replace("twins/", "shared/"));
    let key = made["link"].as_str().unwrap().strip_prefix(&page).unwrap();
    let protocols = format!("bendtwin.play.v1, bendtwin.token, {key}");
    let path = format!("/v1/{twin}/play");
    let mut play = Play::connect(url, &path, &[("sec-websocket-protocol", &protocols)]).await;
    play.send(json!({"type": "begin"})).await;
    play.shown("a state", |_| true).await;
    play.send(json!({"type": "goal", "targets": [{"node": 0, "position": [0, 0, 1]}]})).await;
    let refused = play.message("a refusal", |text| text["type"] == "refused").await;
    assert_eq!(refused["problem"]["reason"], "SHARE_LIMITED", "{refused}");
    let shares = ask(&["twin", "shares", twin]);
    let share = &shares[0];
    assert_eq!(
        (&share["display_name"], &share["allow_export"]),
        (&json!("a friend"), &json!(false))
    );
    ask(&["twin", "unshare", share["name"].as_str().unwrap()]);
    play.closed().await;
    assert_eq!(play.replies.last().unwrap()["problem"]["reason"], "SHARE_ENDED");
}

#[tokio::test]
async fn the_demo_stays_with_a_rope_that_can_be_dragged() {
    let mut command = bendtwin();
    command.args(["demo", "--open", "--json"]).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let pid = child.id();
    let output = child.stdout.take().unwrap();
    let line = tokio::task::spawn_blocking(move || {
        let mut line = String::new();
        std::io::BufReader::new(output).read_line(&mut line).map(|_| line)
    });
    let line = within("the address of the playground", SOON, line).await.unwrap().unwrap();
    let report: Value = serde_json::from_str(&line).unwrap();
    let address = report["address"].as_str().unwrap();
    let (url, page) = address.split_once("/#/").unwrap();
    let (path, token) = page.split_once("?token=").unwrap();
    let protocols = format!("bendtwin.play.v1, bendtwin.token, {token}");
    let path = format!("/v1/{path}");
    let mut play = Play::connect(url, &path, &[("sec-websocket-protocol", &protocols)]).await;
    play.send(json!({"type": "begin"})).await;
    let first = play.shown("a state", |_| true).await;
    let from: [f32; 3] = std::array::from_fn(|i| first.grippers[0][i]);
    let target = [from[0], from[1], from[2] + 0.1];
    play.aim(1, 0, target).await;
    play.shown("the hand at its target", |s| {
        apart(std::array::from_fn(|i| s.grippers[0][i]), target) < 1e-4
    })
    .await;
    drop(play);
    let twin = path.strip_prefix("/v1/").unwrap().strip_suffix("/play").unwrap();
    others_play_through_a_link(url, twin, token).await;
    signal(pid, "INT");
    let ended = tokio::task::spawn_blocking(move || child.wait());
    let status = within("the end of the demo", SOON, ended).await.unwrap().unwrap();
    assert!(status.success(), "{status}");
}

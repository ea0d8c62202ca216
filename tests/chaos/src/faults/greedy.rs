//! Clients that ask for as much as they may, and for more.

use std::time::Duration;

use bendtwin_contract::rollout::MOST_SLOTS;
use bendtwin_proto::{
    json::{TensorFormat, Write},
    v1::{OpenSessionRequest, Returns, RollOutRequest},
};
use futures::{StreamExt as _, future::join_all};
use tokio::time::timeout;

use super::{GREEDY, http, rollouts, sessions};
use crate::{run::Run, schedule::Greed};

/// Time that a greedy client waits.
const PATIENCE: Duration = Duration::from_secs(30);
/// Sizes of large bodies that are sent together [bytes].
const SIZES: [usize; 4] = [48 << 20, 12 << 20, 12 << 20, 6 << 20];
/// Requests at a time.
const BATCHES: usize = 6;
/// Sessions that are opened and left, and the time after which they end [s].
const SESSIONS: usize = 600;
const IDLE_S: f64 = 10.0;
/// Uploads that are begun and left.
const UPLOADS: usize = 100;

pub(super) async fn ask(run: &Run, greed: Greed) -> anyhow::Result<()> {
    let asked = async {
        match greed {
            Greed::Batches => batches(run).await,
            Greed::LargeJson => large_json(run).await,
            Greed::LargeReply => large_reply(run).await,
            Greed::Uploads => uploads(run).await,
            Greed::Sessions => open_and_leave(run).await,
        }
    };
    run.tally.count(format!("faults: greedy clients, {greed:?}"));
    // Answers are the server's business, as long as there are others for the honest.
    timeout(PATIENCE, asked).await.unwrap_or(Ok(()))
}

async fn batches(run: &Run) -> anyhow::Result<()> {
    let client = rollouts(run, GREEDY).await?;
    let request = run.references.batch(run.twin(), 2000, 200);
    let ask = |number| {
        let (mut client, request) = (client.clone(), request.clone());
        async move {
            let answer = client.roll_out(request).await;
            run.tally.log(format_args!("greedy batch {number}: {:?}", answer.err()));
        }
    };
    join_all((0..BATCHES).map(ask)).await;
    Ok(())
}

async fn post(run: &Run, body: String) -> anyhow::Result<()> {
    let url = format!("{}/v1/{}/rollouts", run.system.url(), run.twin());
    let request = http(GREEDY)?.post(url).header("content-type", "application/json").body(body);
    let reply = request.send().await?;
    let (status, mut bytes) = (reply.status(), 0);
    let mut chunks = reply.bytes_stream();
    while let Some(chunk) = chunks.next().await {
        bytes += chunk?.len();
    }
    run.tally.log(format_args!("a greedy rollout: {status}, {bytes} bytes"));
    Ok(())
}

async fn large_json(run: &Run) -> anyhow::Result<()> {
    let body = |size: usize| {
        let mut body = String::with_capacity(size + 100);
        body.push_str("{\"trajectories\": {\"positions\": [[[[0,0,0]]");
        while body.len() < size {
            body.push_str(",[[0,0,0]]");
        }
        body.push_str("]]}}");
        body
    };
    join_all(SIZES.map(|size| post(run, body(size)))).await.into_iter().collect()
}

async fn large_reply(run: &Run) -> anyhow::Result<()> {
    let returns = Returns { every_frames: 1, ..Returns::default() };
    let request =
        RollOutRequest { returns: Some(returns), ..run.references.batch(String::new(), 200, 500) };
    post(run, serde_json::to_string(&Write { message: &request, tensors: TensorFormat::Lists })?)
        .await
}

async fn open_and_leave(run: &Run) -> anyhow::Result<()> {
    let client = sessions(run, GREEDY).await?;
    for number in 0..SESSIONS {
        let request = OpenSessionRequest {
            twin: run.twin(),
            // Some fill the memory for states, the others the number of sessions.
            slots: if number % 2 == 0 { MOST_SLOTS } else { 1 },
            idle_timeout_s: IDLE_S,
            ..OpenSessionRequest::default()
        };
        if let Err(refusal) = client.clone().open_session(request).await {
            run.tally.log(format_args!("greedy session {number}: {refusal}"));
        }
    }
    Ok(())
}

async fn uploads(run: &Run) -> anyhow::Result<()> {
    let client = http(GREEDY)?;
    let url = format!("{}/v1/uploads", run.system.url());
    for _ in 0..UPLOADS {
        let request = client.post(&url).header("tus-resumable", "1.0.0");
        request.header("upload-length", 1 << 20).send().await?;
    }
    Ok(())
}

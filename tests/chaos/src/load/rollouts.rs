//! Clients that ask for rollouts, over gRPC and as JSON, whose answers have to repeat to the bit.

use std::{sync::Arc, time::Duration};

use bendtwin_proto::v1::{RollOutRequest, RollOutResponse};
use rand::RngExt as _;
use reqwest::Method;
use tokio::time::sleep;

use crate::{
    honest::{Answer, send},
    load::json,
    reference::{lasting, lasting_document},
    run::Run,
};

const PROMISE: &str = "a rollout repeats bit for bit";

pub(super) async fn grpc_client(run: Arc<Run>, number: u64) {
    let mut random = run.chance(number);
    while run.is_under_load() {
        over_grpc(&run, random.random_range(0..run.references.rollouts.len())).await;
        sleep(Duration::from_millis(random.random_range(50..400))).await;
    }
}

pub(super) async fn json_client(run: Arc<Run>, number: u64) {
    let mut random = run.chance(number);
    while run.is_under_load() {
        as_json(&run, random.random_range(0..run.references.rollouts.len())).await;
        sleep(Duration::from_millis(random.random_range(50..400))).await;
    }
}

/// Asks for a rollout and compares it.
pub(crate) async fn over_grpc(run: &Run, number: usize) {
    let (api, rollout) = (run.api(), &run.references.rollouts[number]);
    let request = RollOutRequest { twin: run.twin(), ..rollout.request.clone() };
    let ask = async || -> Answer<RollOutResponse> { Ok(api.roll_out(request.clone()).await?) };
    let Some(answer) = run.expect("a rollout", ask).await else { return };
    run.tally.count("acknowledged: rollouts over gRPC");
    if lasting(answer) != rollout.reply {
        run.tally.broken(PROMISE, format_args!("number {number} over gRPC"));
    }
}

/// A rollout as JSON.
pub(crate) async fn as_json(run: &Run, number: usize) {
    let (http, rollout) = (run.http(), &run.references.rollouts[number]);
    let path = format!("/v1/{}/rollouts", run.twin());
    let answer = run.expect("a rollout", async || {
        let request = http.request(Method::POST, &path);
        let request = request.header("content-type", "application/json");
        json(&send(request.body(rollout.body.clone())).await?.1)
    });
    let Some(answer) = answer.await else { return };
    run.tally.count("acknowledged: rollouts as JSON");
    if lasting_document(answer) != rollout.document {
        run.tally.broken(PROMISE, format_args!("number {number} as JSON"));
    }
}

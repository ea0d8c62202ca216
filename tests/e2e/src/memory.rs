//! Server and worker under a limit of the system a little above their budgets of memory: the
//! largest accepted requests, all together, end neither.
//!
//! The limit is `RLIMIT_DATA`, what a process may write. `RLIMIT_AS` would count what threads and
//! the allocator only reserve, gigabytes for a handful of threads.

mod requests;

use std::{collections::BTreeMap, time::Duration};

use bendtwin_harness::{Api, Isolation, Setup, TestCluster, cluster::Memory};
use bendtwin_proto::{fault, v1::RollOutRequest};
use futures::{StreamExt as _, future::BoxFuture, stream::FuturesUnordered};
use prost::Message as _;
use reqwest::Method;

use self::requests::{Twins, gradients, long_reply, many_controls, many_frames, many_knots};

/// Budgets, and the memory of a process beyond its own: its program, stacks of threads, and what the
/// allocator keeps of freed memory.
const MEMORY: Memory = Memory { server_mib: 256, worker_mib: 512, base_mib: 320 };
const DEADLINE: Duration = Duration::from_secs(120);
/// Requests of those that are answered on the slowest machine.
const LEAST_ANSWERED: usize = 5;
const PROTOBUF: &str = "application/x-protobuf";
/// Reasons to refuse a request that are no failures.
const REFUSALS: [&str; 4] = ["MEMORY_IN_USE", "MEMORY_TOO_SMALL", "WORKERS_BUSY", "WORKER_BUSY"];

/// The outcome of a request: a reason, or none if it was answered.
type Outcome = Option<String>;

/// Sends a rollout over gRPC; its connection is its own.
async fn grpc(cluster: String, request: RollOutRequest, streamed: bool) -> Outcome {
    let mut rollouts = Api::new(&cluster).rollouts();
    let status = if streamed {
        match rollouts.stream_roll_out(request).await {
            Err(status) => status,
            Ok(parts) => {
                let mut parts = parts.into_inner();
                loop {
                    match parts.message().await {
                        Ok(Some(_)) => {}
                        Ok(None) => return None,
                        Err(status) => break status,
                    }
                }
            }
        }
    } else {
        match rollouts.roll_out(request).await {
            Err(status) => status,
            Ok(_) => return None,
        }
    };
    Some(fault::fault(&status).reason)
}

/// Sends a body over HTTP.
async fn http(url: String, kind: &'static str, body: Vec<u8>) -> Outcome {
    let client = reqwest::Client::builder().pool_max_idle_per_host(0).build().unwrap();
    let call = client.request(Method::POST, url).header("content-type", kind).body(body);
    let reply = call.timeout(DEADLINE).send().await.unwrap();
    let is_ok = reply.status().is_success();
    let content = reply.bytes().await.unwrap();
    if is_ok {
        return None;
    }
    let problem: serde_json::Value = serde_json::from_slice(&content).unwrap();
    Some(problem["reason"].as_str().unwrap().to_owned())
}

#[tokio::test(flavor = "multi_thread")]
async fn the_largest_requests_together_end_no_process() {
    let isolation = Isolation::Exclusive;
    let setup = Setup { own_workers: 0, isolation, memory: Some(MEMORY), ..Setup::default() };
    let mut cluster = TestCluster::start(setup).await;
    cluster.start_worker().await;
    let twins = Twins::import(&cluster.api()).await;
    let pids = (cluster.pid(), cluster.worker_pids());
    let address = cluster.url().strip_prefix("http://").unwrap().to_owned();
    let small = many_knots(&twins.chain, 1, 2);
    assert_eq!(grpc(address.clone(), small.clone(), false).await, None);

    // What asks for gigabytes is refused, however small it is.
    let monstrous = many_controls(&twins.controls, 100_000);
    assert!(monstrous.encoded_len() < 300_000);
    let refused = grpc(address.clone(), monstrous, false).await;
    assert_eq!(refused.as_deref(), Some("ROLLOUT_TOO_LARGE"));
    let base = cluster.url();
    let lists = |twin: &str| format!("{base}/v1/{twin}/rollouts");
    let long = many_frames(&twins.chain, 150);
    let json = requests::as_json(&long);
    let refused = http(lists(&twins.chain), "application/json", json.clone()).await;
    assert_eq!(refused.as_deref(), Some("ROLLOUT_TOO_LARGE"));

    let mut calls: FuturesUnordered<BoxFuture<'_, (&str, Outcome)>> = FuturesUnordered::new();
    let add = |name: &'static str, call: BoxFuture<'static, Outcome>| {
        calls.push(Box::pin(async move { (name, call.await) }));
    };
    let at = |query: &str| lists(&twins.chain) + query;
    let knots = many_knots(&twins.chain, 8, 100_000);
    let text = requests::as_json(&knots);
    assert!((7 << 20..10 << 20).contains(&text.len()), "{}", text.len());
    for _ in 0..4 {
        add("body of JSON", Box::pin(http(at(""), "application/json", text.clone())));
        let call = grpc(address.clone(), many_controls(&twins.controls, 250), false);
        add("dense controls", Box::pin(call));
        let call = grpc(address.clone(), gradients(&twins.controls, 80), false);
        add("gradients", Box::pin(call));
    }
    for _ in 0..3 {
        let large = many_knots(&twins.chain, 30_000, 46);
        add("body of gRPC", Box::pin(grpc(address.clone(), large.clone(), false)));
        add("body of protobuf", Box::pin(http(at(""), PROTOBUF, large.encode_to_vec())));
        let url = format!("{base}/v1/twins");
        add("twin", Box::pin(http(url, "application/octet-stream", twins.large.clone())));
    }
    for _ in 0..2 {
        add(
            "reply in base64",
            Box::pin(http(at("?tensors=base64"), "application/json", json.clone())),
        );
        add("reply in protobuf", Box::pin(http(at(""), PROTOBUF, long.encode_to_vec())));
        let lists = requests::as_json(&long_reply(&twins.chain));
        add("reply in lists", Box::pin(http(at(""), "application/json", lists)));
        add("reply over gRPC", Box::pin(grpc(address.clone(), long.clone(), false)));
        add("reply in parts", Box::pin(grpc(address.clone(), long.clone(), true)));
    }
    let mut answered = BTreeMap::new();
    while let Some((name, outcome)) = calls.next().await {
        let refused = outcome.as_ref().is_some_and(|reason| !REFUSALS.contains(&&**reason));
        assert!(!refused, "{name}: {outcome:?}\n{}", cluster.log());
        *answered.entry(name).or_insert(0) += usize::from(outcome.is_none());
    }
    println!("answered: {answered:?}");
    // The others were refused after a wait: how many depends on the speed of the machine.
    assert!(answered.values().sum::<usize>() >= LEAST_ANSWERED, "{answered:?}");
    assert!(cluster.is_alive(), "{}", cluster.log());
    assert_eq!((cluster.pid(), cluster.worker_pids()), pids, "{}", cluster.log());

    // One after another each of them is accepted.
    let alone = [
        ("body of JSON", http(at(""), "application/json", text).await),
        ("reply in base64", http(at("?tensors=base64"), "application/json", json).await),
        ("twin", http(format!("{base}/v1/twins"), "application/octet-stream", twins.large).await),
    ];
    for (name, outcome) in alone {
        assert_eq!(outcome, None, "{name}");
    }
    for request in
        [many_controls(&twins.controls, 250), gradients(&twins.controls, 80), long, small]
    {
        assert_eq!(grpc(address.clone(), request, false).await, None);
    }
    assert_eq!((cluster.pid(), cluster.worker_pids()), pids, "{}", cluster.log());
}

//! Sign-ins of several networks: none of them keeps the others from signing in.

use std::net::{IpAddr, Ipv4Addr};

use serde_json::Value;

use super::{NONCE, proof, provider::Provider, server, signed_in, start};
use crate::harness::{Server, read};

/// A client with another address on this machine.
fn client(last: u8) -> reqwest::Client {
    let address = IpAddr::from(Ipv4Addr::new(127, 0, 0, last));
    reqwest::Client::builder().local_address(address).build().unwrap()
}

async fn post(client: &reqwest::Client, server: &Server, path: &str, body: Value) -> (u16, Value) {
    read(client.post(server.url(path)).json(&body).send().await.unwrap()).await
}

#[tokio::test]
async fn slow_calls_of_one_network_do_not_stop_the_others() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    signed_in(&server, &provider).await;
    provider.with(|answers| answers.token_hangs = true);
    let attacker = client(2);
    let calls: Vec<_> = (0..40)
        .map(|_| {
            let request = attacker.post(server.url("/v1/sign-in")).json(&proof(NONCE));
            tokio::spawn(async move { request.send().await.unwrap().status().as_u16() })
        })
        .collect();
    tokio::time::sleep(std::time::Duration::from_secs(1)).await;
    let busy = calls.iter().filter(|call| call.is_finished()).count();
    assert!((1..40).contains(&busy), "{busy}");
    let token = provider.key.sign(&provider.claims(NONCE));
    provider.with(|answers| answers.token_hangs = false);
    provider.issue(&token);
    let other = client(3);
    let (status, started) = post(&other, &server, "/v1/sign-in/start", start()).await;
    assert_eq!(status, 200, "{started}");
    let (status, made) = post(&other, &server, "/v1/sign-in", proof(NONCE)).await;
    assert_eq!(status, 201, "{made}");
    // What was known before is enough to start.
    let (status, started) = post(&attacker, &server, "/v1/sign-in/start", start()).await;
    assert_eq!(status, 200, "{started}");
    calls.iter().for_each(tokio::task::JoinHandle::abort);
}

#[tokio::test]
async fn two_networks_do_not_use_up_the_rate_of_a_third() {
    let provider = Provider::start().await;
    let server = server(&provider, |_| ()).await;
    signed_in(&server, &provider).await;
    for (path, body, otherwise) in
        [("/v1/sign-in/start", start(), 200), ("/v1/sign-in", proof(NONCE), 201)]
    {
        for attacker in [client(2), client(3)] {
            let mut statuses = Vec::new();
            while statuses.last() != Some(&429) && statuses.len() < 3000 {
                statuses.push(post(&attacker, &server, path, body.clone()).await.0);
            }
            assert_eq!(statuses.last(), Some(&429), "{path}");
        }
        let (status, answer) = post(&client(4), &server, path, body).await;
        assert_eq!(status, otherwise, "{path}: {answer}");
    }
}

//! A client that uploads captures, downloads them, adds files to them, repeats requests, deletes and restores.

use std::{collections::VecDeque, sync::Arc, time::Duration};

use rand::RngExt as _;
use reqwest::Method;
use tokio::time::sleep;

use crate::{honest::send, run::Run};

/// Most captures that a client keeps.
const KEPT: usize = 40;

pub(super) async fn client(run: Arc<Run>, number: u64) {
    let mut random = run.chance(number);
    let mut mine: VecDeque<(String, usize)> = VecDeque::new();
    while run.is_under_load() {
        let archive = random.random_range(0..run.references.archives.len());
        let (display_name, request_id) = (run.fresh("capture"), run.fresh("request"));
        let over_http = random.random();
        let Some(name) = run.upload(over_http, archive, &display_name, &request_id).await else {
            continue;
        };
        run.ledger.capture(&name, &run.references.archives[archive].digest, false);
        run.tally.count("acknowledged: captures");
        if random.random_bool(0.3) {
            // The answer was lost, as far as this client knows.
            let again = run.upload(random.random(), archive, &display_name, &request_id).await;
            run.tally.count("acknowledged: repeated creations");
            if again.as_ref().is_some_and(|again| *again != name) {
                let case = format_args!("{name} and {again:?} of {request_id}");
                run.tally.broken("a repeated creation makes nothing new", case);
            }
        }
        mine.push_back((name, archive));
        let any = random.random_range(0..mine.len());
        let (name, archive) = &mine[any];
        if let Some(content) = run.content(name).await {
            run.tally.count("acknowledged: downloads");
            if content != run.references.archives[*archive].content {
                run.tally.broken("content is what was stored", name);
            }
        }
        if random.random_bool(0.3) {
            add(&run, name, *archive).await;
        }
        if mine.len() > KEPT || random.random_bool(0.3) {
            let gone = random.random_range(0..mine.len());
            if let Some((name, archive)) = mine.remove(gone) {
                let deleted = run.delete(&name, random.random_bool(0.3)).await;
                if deleted && random.random_bool(0.4) && run.restore(&name).await {
                    mine.push_back((name, archive));
                }
            }
        }
        sleep(Duration::from_millis(random.random_range(300..1200))).await;
    }
}

/// Adds an archive to a capture, always the same one, unless it is being read.
async fn add(run: &Run, name: &str, archive: usize) {
    let content = &run.references.archives[archive].content;
    let path = format!("/v1/{name}/supplements/masks");
    let added = run.insist("a supplement", async || {
        let request = run.http().request(Method::PUT, &path).body(content.clone());
        send(request).await.map(drop)
    });
    match added.await {
        Some(Ok(())) => {
            run.ledger.supplement(name, archive);
            run.tally.count("acknowledged: supplements");
        }
        Some(Err(refusal)) if refusal.is("INGEST_UNDER_WAY") => {
            run.tally.count("honest calls: supplements that came too early");
        }
        Some(Err(refusal)) => {
            let case = format_args!("a supplement of {name}: {refusal:?}");
            run.tally.broken("honest calls are not refused", case);
        }
        None => {}
    }
}

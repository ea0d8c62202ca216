//! A client that orders fits, cancels a few, and takes their twins.

use std::{sync::Arc, time::Duration};

use bendtwin_harness::api::has_ended;
use bendtwin_proto::v1::{CreateFitRequest, Fit, job::State};
use rand::RngExt as _;
use tokio::time::sleep;

use crate::{honest::Answer, run::Run};

/// Most captures for fits; then they are fitted again.
const CAPTURES: usize = 12;

pub(super) async fn client(run: Arc<Run>, number: u64) {
    let mut random = run.chance(number);
    let mut captures: Vec<(String, usize)> = Vec::new();
    let mut under_way: Vec<(String, usize)> = Vec::new();
    while run.is_under_load() {
        sleep(Duration::from_millis(random.random_range(100..500))).await;
        let mut waiting = Vec::new();
        for (name, work) in under_way {
            match get(&run, &name).await {
                Some(fit) if has_ended(&fit) => {
                    take(&run, &fit, work).await;
                    if random.random_bool(0.3) {
                        let deleted = run.delete(&name, random.random_bool(0.3)).await;
                        if deleted && random.random_bool(0.4) {
                            run.restore(&name).await;
                        }
                    }
                }
                _ => waiting.push((name, work)),
            }
        }
        under_way = waiting;
        if under_way.len() >= run.fits_under_way() {
            continue;
        }
        let work = random.random_range(0..run.references.works.len());
        let archive = run.references.works[work].archive;
        let known: Vec<_> = captures.iter().filter(|(_, a)| *a == archive).cloned().collect();
        let capture = if captures.len() < CAPTURES || known.is_empty() {
            let display_name = &run.references.archives[archive].name;
            let request_id = run.fresh("request");
            let stored = run.upload(random.random(), archive, display_name, &request_id).await;
            let Some(name) = stored else { continue };
            run.ledger.capture(&name, &run.references.archives[archive].digest, false);
            run.tally.count("acknowledged: captures");
            captures.push((name.clone(), archive));
            name
        } else {
            known[random.random_range(0..known.len())].0.clone()
        };
        let again = random.random_bool(0.3);
        let Some(fit) = order(&run, &capture, work, again).await else { continue };
        if random.random_bool(0.1) {
            sleep(Duration::from_millis(random.random_range(0..1000))).await;
            cancel(&run, &fit).await;
        }
        under_way.push((fit, work));
    }
}

async fn order(run: &Run, capture: &str, work: usize, again: bool) -> Option<String> {
    let api = run.api();
    let request = CreateFitRequest {
        capture: capture.to_owned(),
        settings_json: run.references.works[work].settings.to_owned(),
        priority: 0,
        request_id: run.fresh("fit"),
        ..CreateFitRequest::default()
    };
    let create =
        async || -> Answer<Fit> { Ok(api.fits().create_fit(request.clone()).await?.into_inner()) };
    let fit = run.expect("the creation of a fit", create).await?;
    run.ledger.fit(&fit.name, work);
    run.tally.count("acknowledged: fits");
    if again {
        let second = run.expect("the creation of a fit", create).await?;
        run.tally.count("acknowledged: repeated creations");
        if second.name != fit.name {
            let case = format_args!("{} and {}", fit.name, second.name);
            run.tally.broken("a repeated creation makes nothing new", case);
        }
    }
    Some(fit.name)
}

pub(crate) async fn get(run: &Run, name: &str) -> Option<Fit> {
    let api = run.api();
    run.expect("a look at a fit", async || Ok(api.get_fit(name).await?)).await
}

async fn cancel(run: &Run, name: &str) {
    let api = run.api();
    run.ledger.cancelled(name);
    let cancelled = run.expect("a cancellation", async || Ok(api.cancel(name).await?)).await;
    if cancelled.is_some() {
        run.tally.count("acknowledged: cancellations");
    }
}

/// Compares the twin of a fit that has succeeded.
async fn take(run: &Run, fit: &Fit, work: usize) {
    if fit.state() != State::Succeeded {
        return;
    }
    if let Some(twin) = run.content(&fit.twin).await {
        run.tally.count("acknowledged: twins");
        if twin != run.references.works[work].twin {
            run.tally.broken("a disturbed fit makes the undisturbed twin", &fit.name);
        }
    }
}

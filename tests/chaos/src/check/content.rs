//! Captures and twins: there, complete, and not there twice.

use std::collections::BTreeMap;

use super::Listed;
use crate::{
    ledger::{Fate, Stored},
    run::Run,
};

const LOST: &str = "nothing that was acknowledged is lost";
const DELETED: &str = "what was deleted stays deleted";
const DOUBLE: &str = "nothing is made twice";

/// Compares captures with the ledger, and their content with what was sent.
pub(super) async fn captures(run: &Run, listed: &Listed) {
    let known = run.ledger.things().captures.clone();
    for (name, stored) in &known {
        let digest = listed.captures.get(name).map(|capture| capture.digest.as_str());
        compare(run, name, stored, digest).await;
        if let (Fate::Kept, Some(archive)) = (stored.fate, stored.supplement) {
            let content = run.part(name, "supplements/masks").await;
            if content.is_none_or(|content| content != run.references.archives[archive].content) {
                run.tally.broken(LOST, format_args!("{name} has another supplement"));
            }
            run.tally.count("checked: supplements");
        }
    }
    for (name, capture) in &listed.captures {
        // Of a hostile capture the answer may have been lost; it is not asked for again.
        if !known.contains_key(name) && capture.display_name != "hostile" {
            run.tally.broken(DOUBLE, format_args!("{name}, {}", capture.display_name));
        }
    }
}

/// Compares twins with the ledger, and with those of an undisturbed server.
pub(super) async fn twins(run: &Run, listed: &Listed) {
    let (imported, ordered) = {
        let things = run.ledger.things();
        (things.twins.clone(), things.fits.clone())
    };
    for (name, stored) in &imported {
        let digest = listed.twins.get(name).map(|twin| twin.digest.as_str());
        compare(run, name, stored, digest).await;
    }
    let mut of_fit: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, twin) in &listed.twins {
        if imported.contains_key(name) {
            continue;
        }
        let Some(fit) = ordered.get(&twin.fit) else {
            if twin.display_name != "hostile" {
                run.tally.broken(DOUBLE, format_args!("{name} of {:?}", twin.fit));
            }
            continue;
        };
        of_fit.entry(&twin.fit).or_default().push(name);
        let Some(content) = run.content(name).await else { continue };
        let work = &run.references.works[fit.work];
        if content != work.twin || twin.digest != work.digest {
            let case = format_args!("{name} of {}", twin.fit);
            run.tally.broken("a disturbed fit makes the undisturbed twin", case);
        }
        run.tally.count("checked: twins of fits");
    }
    for (fit, twins) in of_fit {
        if twins.len() > 1 {
            run.tally.broken(DOUBLE, format_args!("{fit} has {twins:?}"));
        }
    }
}

/// Compares one thing, whose digest is given if it is listed.
async fn compare(run: &Run, name: &str, stored: &Stored, digest: Option<&str>) {
    match (stored.fate, digest) {
        (Fate::Kept, None) => run.tally.broken(LOST, name),
        (Fate::Deleted, Some(_)) => run.tally.broken(DELETED, name),
        (Fate::Kept, Some(digest)) => {
            let content = run.content(name).await;
            let is_whole =
                |content: bytes::Bytes| blake3::hash(&content).to_hex().as_str() == stored.digest;
            if digest != stored.digest || !content.is_some_and(is_whole) {
                run.tally.broken(LOST, format_args!("{name} has other content"));
            }
            run.tally.count("checked: contents");
        }
        (Fate::Deleted, None) => run.tally.count("checked: deletions"),
        (Fate::Leaving, _) => {}
    }
}

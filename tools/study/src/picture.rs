//! Pictures of what twins predict against what was observed: on each capture, two configurations
//! that are compared.

use bendtwin_core::{CancelToken, Capture, Problem, Sequence, Twin};
use bendtwin_engine::Backend;
use bendtwin_eval::{
    picture::{Model, Picture},
    predict,
};

use crate::{
    Error, Plan,
    plan::Source,
    suite::{CaptureEntry, RunId},
};

/// Frames side by side.
const COLUMNS: usize = 4;

/// Draws `pictures/CAPTURE.FIRST.SECOND.png` for every pair of configurations that the suite
/// compares (the first two if it compares none), with the first seed of which both have a twin, on
/// every capture of a selected run. Returns what could not be drawn and why.
///
/// # Errors
/// If a picture cannot be written.
pub fn draw_pictures(
    plan: &Plan<'_>,
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<Vec<String>, Error> {
    let mut complaints = Vec::new();
    for capture in &plan.suite.captures {
        let Some(source) = plan.sources.get(capture.name.as_str()) else { continue };
        for names in pairs(plan) {
            if cancel.is_cancelled() {
                return Ok(complaints);
            }
            let Some(twins) = twins(plan, source, capture, &names) else { continue };
            let name = format!("pictures/{}.{}.png", capture.name, names.join("."));
            match draw(source, &twins, &names, backend, cancel) {
                Ok(png) => plan.folder.write(&name, &png)?,
                Err(why) => complaints.push(format!("{name}: {why}")),
            }
        }
    }
    Ok(complaints)
}

/// Configurations that stand in one picture.
fn pairs<'a>(plan: &Plan<'a>) -> Vec<Vec<&'a str>> {
    let known = |name: &str| plan.suite.configurations.iter().any(|c| c.name == name);
    let mut pairs: Vec<Vec<&str>> = Vec::new();
    for c in &plan.suite.compare {
        let mut pair: Vec<&str> = [&c.of, &c.against]
            .into_iter()
            .map(|row| row.split_once(':').map_or(row.as_str(), |(name, _)| name))
            .filter(|name| known(name))
            .collect();
        pair.dedup();
        let seen = pairs.iter().any(|p| pair.iter().all(|name| p.contains(name)));
        if !pair.is_empty() && !seen {
            pairs.push(pair);
        }
    }
    if pairs.is_empty() {
        pairs.push(plan.suite.configurations.iter().take(2).map(|c| c.name.as_str()).collect());
    }
    pairs
}

/// The twins of the first seed that all of them have.
fn twins(
    plan: &Plan<'_>,
    source: &Source,
    capture: &CaptureEntry,
    names: &[&str],
) -> Option<Vec<Twin>> {
    let twin = |name: &&str, seed: u64| {
        let run = RunId { capture: capture.name.clone(), configuration: (*name).to_owned(), seed };
        plan.kept.get(&run)?.finished()?;
        let bytes = std::fs::read(plan.folder.twin_path(&run)).ok()?;
        Twin::decode(&bytes).ok().filter(|t| t.provenance.capture_digest == source.digest)
    };
    plan.suite.seeds.iter().find_map(|&seed| names.iter().map(|name| twin(name, seed)).collect())
}

fn draw(
    source: &Source,
    twins: &[Twin],
    names: &[&str],
    backend: &dyn Backend,
    cancel: &CancelToken,
) -> Result<Vec<u8>, String> {
    let capture = source.capture.as_ref().map_err(|fault| fault.message.clone())?;
    let capture = shown(capture).ok_or("the capture has no sequence")?;
    let failed = |e: bendtwin_eval::Error| e.fault().message;
    let mut predictions = Vec::with_capacity(twins.len());
    for twin in twins {
        predictions.extend(predict(backend, twin, &capture, cancel).map_err(failed)?);
    }
    let models: Vec<Model<'_>> = names
        .iter()
        .zip(twins)
        .zip(&predictions)
        .map(|((name, twin), trajectory)| Model { name, twin, trajectory })
        .collect();
    Picture { capture: &capture, sequence: 0, models: &models, columns: COLUMNS }
        .to_png()
        .map_err(failed)
}

/// The capture with one sequence alone: one that fits did not see, if there is one.
fn shown(capture: &Capture) -> Option<Capture> {
    let held_out = capture.sequences.iter().find(|s| Sequence::is_held_out(s));
    let sequence = held_out.or(capture.sequences.first())?.clone();
    Some(Capture {
        name: capture.name.clone(),
        fps: capture.fps,
        environment: capture.environment,
        source_to_world: capture.source_to_world,
        object: capture.object.clone(),
        sequences: vec![sequence],
        others: Vec::new(),
    })
}

//! Times of a user's twin: batches as planners send them, whose costs come back, with or without
//! gradients, of the exact twin, of its fast variant and of its planner's twin. The wire and the queue
//! of a server are not included.

use std::{
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::Context as _;
use bendtwin_core::{CancelToken, Twin};
use bendtwin_engine::{
    Backend, Loaded, Model, Objective, PointLoss, PointSet, Term,
    backend::{GradientRequest, Instance},
    fidelity::Reduction,
    model::State,
    objective::WeightedTerm,
};
use bendtwin_terminal::measurement::Size;
use serde::Serialize;

use crate::{failure, table::Table};

/// Most repeats of one measurement.
const MOST_REPEATS: usize = 200;

/// Measurements to take, and their durations.
pub(super) struct Plan {
    pub(super) sizes: Vec<Size>,
    /// Repeats of one measurement end after this.
    pub(super) measurement: Duration,
    /// A measurement whose single call should take longer than this is left out.
    pub(super) patience: Duration,
}

/// The measurements.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    device: String,
    nodes: usize,
    springs: usize,
    triplets: usize,
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    fidelity: &'static str,
    substeps: u32,
    size: Size,
    gradients: bool,
    /// `None` if a call would take longer than the patience.
    time: Option<Time>,
}

/// Time of a call.
#[derive(Clone, Copy, Debug, Serialize)]
struct Time {
    repeats: usize,
    best_s: f64,
    median_s: f64,
}

/// Measures a twin file.
///
/// # Errors
/// If the file is no twin, the device fails, or on cancellation.
pub(super) fn measure(
    file: &Path,
    plan: &Plan,
    backend: &dyn Backend,
    cancel: &CancelToken,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Report> {
    let name = || file.display().to_string();
    let content = std::fs::read(file).with_context(name)?;
    let twin = Twin::decode(&content).with_context(name)?;
    let exact = Model::from(&twin);
    let mut variants = vec![("exact", exact.clone())];
    variants.extend(twin.quality.fast.map(|fast| ("fast", Reduction::from(&fast).apply(&exact))));
    variants.extend(twin.planner.as_ref().map(|planner| ("planner", Model::from(&*planner.twin))));
    let mut rows = Vec::new();
    for (fidelity, model) in variants {
        let substeps = model.timing.substeps;
        let loaded = backend.load(Arc::new(model)).map_err(failure::failed)?;
        for gradients in [false, true] {
            // Seconds that an instance's frame took in the last measurement: at worst a larger batch
            // is as slow as its instances one by one.
            let mut pace_s = 0.0;
            for size in &plan.sizes {
                let frames = size.instances as f64 * f64::from(size.frames);
                let time = if pace_s * frames > plan.patience.as_secs_f64() {
                    None
                } else {
                    say(&format!("{fidelity} {size}{}", if gradients { " gradients" } else { "" }));
                    let batch = batch(&loaded, size);
                    let call = || call(backend, &batch, gradients, cancel);
                    Some(time(plan.measurement, call)?)
                };
                if let Some(time) = time {
                    pace_s = time.best_s / frames;
                }
                rows.push(Row { fidelity, substeps, size: *size, gradients, time });
            }
        }
    }
    let device = backend.device();
    Ok(Report {
        device: format!("{} ({})", device.name, device.kind),
        nodes: twin.graph.node_count(),
        springs: twin.graph.springs.len(),
        triplets: twin.graph.triplets.len(),
        rows,
    })
}

fn call(
    backend: &dyn Backend,
    batch: &[Instance],
    gradients: bool,
    cancel: &CancelToken,
) -> anyhow::Result<()> {
    if gradients {
        let request = GradientRequest { controls: true, ..GradientRequest::default() };
        backend.gradients(batch, &request, cancel).map(drop).map_err(failure::failed)
    } else {
        backend.losses(batch, cancel).map(drop).map_err(failure::failed)
    }
}

/// Instances that are held still from rest, with a cost after the last frame: the mean distance of
/// the nodes from where they were.
fn batch(loaded: &Loaded, size: &Size) -> Vec<Instance> {
    let graph = &loaded.model().graph;
    let frames = size.frames as usize;
    let controls: Vec<_> = std::iter::repeat_n(&graph.control_rest, frames + 1).flatten().collect();
    let controls = Arc::new(controls.into_iter().copied().collect());
    let nodes: Vec<u32> = (0..graph.node_count() as u32).collect();
    let targets = graph.rest_positions.clone();
    let term =
        Term::Track { of: PointSet::Nodes, points: nodes, targets, loss: PointLoss::Distance };
    let terms = Arc::new(vec![WeightedTerm { frame: frames, weight: 1.0, group: 0, term }]);
    let instance = Instance {
        model: loaded.clone(),
        initial: Arc::new(State::rest(graph)),
        controls,
        frames,
        objective: Objective { groups: vec!["distance".into()], terms },
        world: Arc::default(),
        motion: Arc::default(),
    };
    vec![instance; size.instances]
}

/// Repeats a call until the budget is spent, at least once after a first one that pays for what
/// happens once.
fn time(budget: Duration, mut call: impl FnMut() -> anyhow::Result<()>) -> anyhow::Result<Time> {
    let began = Instant::now();
    call()?;
    let first = began.elapsed();
    let mut times = Vec::new();
    let began = Instant::now();
    while times.is_empty() || (began.elapsed() + first < budget && times.len() < MOST_REPEATS) {
        let started = Instant::now();
        call()?;
        times.push(started.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let best_s = times.first().copied().unwrap_or_default();
    let median_s = times.get(times.len() / 2).copied().unwrap_or(best_s);
    Ok(Time { repeats: times.len(), best_s, median_s })
}

/// The report as text: a row for each size.
pub(super) fn text(report: &Report) -> String {
    let Report { device, nodes, springs, triplets, rows } = report;
    let columns: Vec<(&str, bool, u32)> = rows.iter().fold(Vec::new(), |mut columns, row| {
        let column = (row.fidelity, row.gradients, row.substeps);
        if !columns.contains(&column) {
            columns.push(column);
        }
        columns
    });
    let names: Vec<String> = columns
        .iter()
        .map(|(fidelity, gradients, substeps)| {
            let what = if *gradients { "gradients" } else { "costs" };
            format!("{what}, {fidelity} ({substeps} substeps)")
        })
        .collect();
    let header = std::iter::once("instances x frames").chain(names.iter().map(String::as_str));
    let mut table = Table::new(header);
    let mut sizes: Vec<Size> = Vec::new();
    for row in rows {
        if !sizes.contains(&row.size) {
            sizes.push(row.size);
        }
    }
    for size in sizes {
        let cells = columns.iter().map(|(fidelity, gradients, _)| {
            let row = rows
                .iter()
                .find(|r| r.size == size && r.fidelity == *fidelity && r.gradients == *gradients);
            row.and_then(|r| r.time)
                .map_or_else(|| "-".to_owned(), |t| format!("{:.1} ms", 1e3 * t.median_s))
        });
        table.row(std::iter::once(size.to_string()).chain(cells).collect::<Vec<_>>());
    }
    format!(
        "{nodes} nodes, {springs} springs, {triplets} triplets, on {device}\n\
         Median time of a call; - would take longer than --patience\n\n{}",
        table.markdown()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twin_is_timed_with_a_row_for_each_size() {
        let backend = bendtwin_engine::cpu_with_threads(1);
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/core/testdata");
        let file = Path::new(data).join("twin-v2.safetensors");
        let plan = Plan {
            sizes: ["1x1", "2x3"].iter().map(|s| s.parse().unwrap()).collect(),
            measurement: Duration::ZERO,
            patience: Duration::from_secs(60),
        };
        let report = measure(&file, &plan, &*backend, &CancelToken::default(), |_| {}).unwrap();
        let text = text(&report);
        for size in ["1 x 1", "2 x 3"] {
            let row = text.lines().find(|l| l.starts_with(&format!("| {size}"))).unwrap();
            assert!(row.contains("ms") && !row.contains("| - "), "{text}");
        }
        let cancel = CancelToken::default();
        cancel.cancel();
        assert!(measure(&file, &plan, &*backend, &cancel, |_| {}).is_err());
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let error = measure(&file, &plan, &*backend, &CancelToken::default(), |_| {}).unwrap_err();
        assert!(format!("{error:#}").contains("Cargo.toml"), "{error:#}");
    }
}

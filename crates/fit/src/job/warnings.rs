//! Warnings for the user about a fit or its data.

use super::model_fit::ModelFit;
use crate::{built_graph::BuiltGraph, task::Task};

/// Warnings about the graph and the search's result.
pub(crate) fn of_fit(task: &Task<'_>, model: &ModelFit) -> Vec<String> {
    let Some((point, built)) = model.refined(task) else { return Vec::new() };
    let mut warnings = Vec::new();
    let loose = loose_controls(&built);
    if loose > 0 {
        warnings.push(format!(
            "{loose} of {} control points hold nothing: they are farther from the object than \
             graph.control_radius_m",
            built.graph.control_count()
        ));
    }
    let notes = built.notes.to_string();
    if !notes.is_empty() {
        warnings.push(notes);
    }
    let left_out = task.sample.left_out;
    if left_out.total() > 0 {
        warnings.push(format!(
            "{} points could not become nodes ({} not finite, {} never visible, {} hidden at the start, {} in the place of \
             another)",
            left_out.total(),
            left_out.not_finite,
            left_out.never_visible,
            left_out.hidden_at_start,
            left_out.coincident
        ));
    }
    for (variable, value) in model.space.at_bounds(point) {
        warnings.push(format!(
            "the search left {variable} at {value:.3e}, an end of its range: the capture may not \
             determine it"
        ));
    }
    warnings
}

/// Control points without a spring or a pin.
fn loose_controls(built: &BuiltGraph) -> usize {
    let graph = &built.graph;
    let n = graph.node_count();
    let mut holds = vec![false; graph.control_count()];
    for &[_, b] in &graph.springs {
        if let Some(c) = (b as usize).checked_sub(n) {
            holds[c] = true;
        }
    }
    graph.pins.iter().for_each(|p| holds[p.control as usize] = true);
    holds.iter().filter(|h| !**h).count()
}

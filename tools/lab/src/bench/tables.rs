//! The report as tables for people; `-` for numbers that are unknown or were left out.

use bendtwin_bench::{
    Report, SceneName, Scheme,
    fit::FitRun,
    report::{Measured, Run, SceneReport},
};
use bendtwin_terminal::{output, table::Table};

/// The table of scenes.
pub(super) fn names() -> String {
    let mut table = Table::new(["scene", "nodes", "control points"]);
    for name in SceneName::ALL {
        let row =
            [name.to_string(), name.node_count().to_string(), name.control_count().to_string()];
        table.row(row);
    }
    table.text()
}

/// The whole report.
pub(super) fn report(report: &Report) -> String {
    let device = &report.device;
    let bound = match &report.bound {
        Some(bound) => bound.how.as_str(),
        None => "unknown for this device",
    };
    let mut parts = vec![
        format!("{}, on {} ({})", report.build, device.name, device.kind),
        format!("Issue bound: {bound}."),
        report.method.clone(),
    ];
    let scenes = &report.scenes;
    if !scenes.is_empty() {
        parts.push(section("Scenes", &sizes(scenes)));
        parts.push(section("Rollouts", &batches(scenes, |s| &s.forward)));
        parts.push(section("Gradients, windows of one frame", &batches(scenes, |s| &s.gradient)));
    }
    if scenes.iter().any(|s| !s.fits.is_empty()) {
        parts.push(section("Whole fits [s]", &fits(scenes)));
    }
    parts.join("\n\n")
}

fn section(title: &str, table: &Table) -> String {
    format!("{title}\n\n{}", table.markdown())
}

fn sizes(scenes: &[SceneReport]) -> Table {
    let header = [
        "scene",
        "nodes",
        "springs",
        "to controls",
        "triplets",
        "stiffness",
        "dt [s]",
        "load [ms]",
        "memory",
    ];
    let mut table = Table::new(header);
    for scene in scenes {
        table.row([
            title(scene),
            scene.nodes.to_string(),
            scene.springs.to_string(),
            scene.control_springs.to_string(),
            scene.triplets.to_string(),
            scene.stiffness.to_string(),
            format!("{:.2e}", scene.dt_s),
            significant(1e3 * scene.load_s),
            or_dash(scene.memory_bytes, output::bytes),
        ]);
    }
    table
}

fn batches(scenes: &[SceneReport], list: impl Fn(&SceneReport) -> &[Measured]) -> Table {
    let header = [
        "scene",
        "batch",
        "us/substep",
        "ms/frame",
        "frames/s",
        "of bound",
        "of axial time",
        "shape",
    ];
    let mut table = Table::new(header);
    for scene in scenes {
        let axial = scenes.iter().find(|s| scene.bending && !s.bending && s.name == scene.name);
        for measured in list(scene) {
            let (name, batch) = (title(scene), measured.batch.to_string());
            let Some(run) = &measured.run else {
                table.row([name, batch, measured.left_out.clone().unwrap_or_default()]);
                continue;
            };
            let beside = axial.and_then(|a| SceneReport::run_of(list(a), measured.batch));
            table.row([
                name,
                batch,
                significant(run.us_per_substep),
                significant(run.frame_ms),
                significant(run.frames_per_s),
                or_dash(run.of_bound, |x| format!("{:.1}%", 100.0 * x)),
                or_dash(beside, |axial: &Run| format!("{:.2}", run.frame_ms / axial.frame_ms)),
                or_dash(run.shape.clone(), |shape| shape),
            ]);
        }
    }
    table
}

fn fits(scenes: &[SceneReport]) -> Table {
    let mut table = Table::new([
        "scene",
        "steps",
        "candidates",
        "passes",
        "frames",
        "search",
        "rollouts",
        "loading",
        "host",
        "passes",
        "gradients",
        "scoring",
        "Adam",
        "parameters",
        "host",
        "evaluation",
        "total",
        "initial loss",
        "search's loss",
        "final loss",
        "memory",
    ]);
    for scene in scenes {
        for fit in &scene.fits {
            table.row(fit_row(scene, fit));
        }
    }
    table
}

fn fit_row(scene: &SceneReport, fit: &FitRun) -> [String; 21] {
    let (plan, search, refine) = (&fit.plan, &fit.search, &fit.refine);
    let loss = |loss: Option<f64>| or_dash(loss, |x| format!("{x:.3e}"));
    [
        title(scene),
        match plan.scheme {
            Scheme::Cut => "a pass, cut".to_owned(),
            scheme => format!("a {}", scheme.as_str()),
        },
        format!("{} of {}", search.rollouts, plan.generations as usize * plan.candidates),
        plan.passes.to_string(),
        plan.frames.to_string(),
        significant(search.total_s),
        significant(search.forward_s),
        significant(search.load_s),
        significant(search.host_s),
        significant(refine.total_s),
        significant(refine.gradient_s),
        significant(refine.forward_s),
        significant(refine.step_s),
        significant(refine.params_s),
        significant(refine.host_s),
        significant(fit.evaluate_s),
        significant(fit.total_s),
        loss(fit.initial_loss),
        loss(fit.search_loss),
        loss(fit.final_loss),
        or_dash(fit.memory_bytes, output::bytes),
    ]
}

fn title(scene: &SceneReport) -> String {
    if scene.bending { format!("{} bending", scene.name) } else { scene.name.to_owned() }
}

fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), text)
}

/// Three significant digits, or more before the decimal point.
fn significant(value: f64) -> String {
    let decimals = match value.abs() {
        0.0..1e-3 => 5,
        1e-3..1.0 => 3,
        1.0..10.0 => 2,
        10.0..100.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_have_three_digits() {
        let texts = [0.0, 0.1234, 1.234, 12.34, 1234.5].map(significant);
        assert_eq!(texts, ["0.00000", "0.123", "1.23", "12.3", "1234"]);
    }
}

//! `bendtwin rollout`: predicts the outcome of actions on a twin.

mod actions;
mod fits;
mod implausible;
mod npy;
mod recording;

use std::path::{Path, PathBuf};

use bendtwin_client::{Cost, Point, Reply, TwinId};
use bendtwin_terminal::fidelity::Mode;
use clap::Args;
use serde_json::json;

use self::{
    actions::Actions,
    fits::Fits,
    recording::{Recording, RecordingOptions},
};
use crate::{failure::Usage, global::Global, output, table::Table};

/// Most rows of a batch that are printed.
const ROWS_SHOWN: usize = 10;

#[derive(Debug, Args)]
pub(crate) struct Rollout {
    /// twins/{uuid}
    twin: TwinId,
    /// Control points over time: .npy or .json of shape [B, K, C, 3], or [K, C, 3] for one
    /// [default: a test motion]
    #[arg(long, value_name = "FILE")]
    actions: Option<PathBuf>,
    /// Test motion: the control points swing this far along x and back [m]
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 0.05,
        conflicts_with = "actions",
        allow_hyphen_values = true
    )]
    sway: f32,
    /// Test motion: the control points move by x,y,z instead [m]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, conflicts_with = "actions", allow_hyphen_values = true)]
    shift: Option<Point>,
    /// Horizon in frames [default: one frame per row of the actions; 30 for the test motion]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Smooth curves through the rows instead of straight lines
    #[arg(long)]
    cubic: bool,
    /// Start in this frame of the twin's capture instead of at rest
    #[arg(long, value_name = "FRAME")]
    from_frame: Option<u32>,
    /// Score by the distance to a target cloud: .npy of shape [M, 3]
    #[arg(long, value_name = "FILE")]
    target: Option<PathBuf>,
    /// Record the positions of every k-th frame
    #[arg(long, value_name = "K", default_value_t = 1)]
    every: u32,
    #[command(flatten)]
    recording: RecordingOptions,
    /// Use the twin as fitted (exact), its fast variant (fast) or its planner's twin (planner); the
    /// latter two also report their deviation
    #[arg(long, value_enum, default_value_t = Mode::Exact)]
    fidelity: Mode,
    /// Keep the positions of the best instances only
    #[arg(long, value_name = "N")]
    best: Option<u32>,
    /// Also simulate the twin's other fits, and say how far their predictions are apart
    #[arg(long, conflicts_with = "fidelity")]
    spread: bool,
    /// Predict the mean motion of the twin and its other fits, weighted by how well they fit
    #[arg(long, conflicts_with = "fidelity")]
    mean: bool,
}

fn point(text: &str) -> Result<Point, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let numbers = numbers.map_err(|e| format!("{e}: write x,y,z in metres"))?;
    Point::try_from(numbers).map_err(|_| "write three numbers: x,y,z in metres".to_owned())
}

pub(crate) async fn run(args: Rollout, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    let actions = match &args.actions {
        Some(path) => Actions::read(path)?,
        None => {
            let twin = client.twins().download(args.twin).await?;
            let rest = &twin.graph.control_rest;
            let frames = args.frames.unwrap_or(30) as usize;
            match args.shift {
                Some(by) => Actions::shift(rest, by, frames),
                None => Actions::sway(rest, args.sway, frames),
            }
        }
    };
    let instances = actions.shape[0];
    let recording = Recording::of(args.recording, instances, args.best)?;
    let mut request =
        bendtwin_client::Rollout::of(args.twin).trajectories(actions.shape, actions.positions);
    request = request.fidelity(args.fidelity.into());
    if args.cubic {
        request = request.cubic();
    }
    // Without a horizon there is a frame per row, which the server works out.
    request = request.frames(args.frames.unwrap_or(0)).diagnostics();
    if let Some(frame) = args.from_frame {
        request = request.from_capture_frame(None, 0, frame);
    }
    if let Some(path) = &args.target {
        request = request.cost(Cost::target_cloud("target", 1.0, &cloud(path)?));
    }
    if let Some(recording) = &recording {
        request = recording.ask(request.record_every(args.every.max(1)));
    }
    if let Some(best) = args.best {
        request = request.best(best);
    }
    let mut fits = Fits::of(&client, args.twin, args.spread, args.mean).await?;
    if let Some(fits) = &fits {
        request = fits.ask(request, args.every.max(1));
    }
    let mut reply = client.rollouts().run(request).await?;
    if let Some(fits) = &mut fits {
        fits.fold(&mut reply);
    }
    if let Some(recording) = &recording {
        recording.write(&client, args.twin, &reply).await?;
    }
    let out = recording.as_ref().map(Recording::path);
    output::print(global, &document(&reply), || text(&reply, instances, fits.as_ref(), out))
}

fn cloud(path: &Path) -> anyhow::Result<Vec<Point>> {
    let array = npy::read(path)?;
    match array.shape[..] {
        [_, 3] => Ok(array.values.as_chunks::<3>().0.to_vec()),
        _ => {
            let fault = format!("has shape {:?}, not [M, 3]", array.shape);
            Err(Usage::error(format!("{}: {fault}", path.display())))
        }
    }
}

fn document(reply: &Reply) -> serde_json::Value {
    // JSON has no infinity: a diverged instance's cost is null, and it is named in `diverged`.
    json!({
        "costs": reply.costs,
        "cost_names": reply.cost_names,
        "cost_terms": reply.cost_terms,
        "best": reply.best(),
        "instances": reply.instances,
        "frames": reply.frames,
        "diagnostics": reply.diagnostics,
        "member_costs": reply.member_costs,
        "successes": reply.successes,
        "spread_m": if reply.spread.is_empty() { Vec::new() } else { Fits::by_frame(reply) },
        "diverged": reply.diverged,
        "implausible": reply.implausible,
        "timing": reply.timing,
        "fidelity": reply.fidelity,
        "substeps": reply.substeps,
        "deviation": reply.deviation,
        "worker": reply.worker,
    })
}

fn text(reply: &Reply, instances: usize, fits: Option<&Fits>, out: Option<&Path>) -> String {
    let mut order: Vec<usize> = (0..reply.costs.len()).collect();
    order.sort_by(|a, b| reply.costs[*a].total_cmp(&reply.costs[*b]));
    let mut table = Table::new(["INSTANCE", "COST", "MAX STRAIN", "MAX SPEED", "ON THE GROUND"]);
    for i in order.iter().take(ROWS_SHOWN) {
        let d = reply.diagnostics.get(*i).copied().unwrap_or_default();
        let cost = if reply.cost_names.is_empty() {
            "-".to_owned()
        } else {
            format!("{:.4e}", reply.costs[*i])
        };
        table.row([
            i.to_string(),
            cost,
            format!("{:.1}%", 100.0 * d.max_strain),
            format!("{:.2} m/s", d.max_speed_m_s),
            format!("{} nodes", d.ground_contacts),
        ]);
    }
    let mut text = table.text();
    if instances > ROWS_SHOWN {
        text += &format!("\n... and {} more", instances - ROWS_SHOWN);
    }
    for d in &reply.diverged {
        text +=
            &format!("\ninstance {} diverged in frame {} at node {}", d.instance, d.frame, d.node);
    }
    text += &implausible::warnings(&reply.implausible);
    if let Some(fits) = fits {
        text += &fits.text(reply);
    }
    text += &format!(
        "\n{instances} rollouts in {:.0} ms ({:.0} ms waiting)",
        1e3 * reply.timing.compute_s,
        1e3 * reply.timing.queue_s
    );
    if let Some(d) = reply.deviation {
        text += &format!(
            "\nfast: {} substeps a frame; on its own capture {:.2} mm from the exact twin on average, {:.1} mm at most, which does not hold for other motions",
            reply.substeps,
            1e3 * d.mean_m,
            1e3 * d.max_m
        );
    }
    match out {
        Some(path) => text + &format!("\npositions in {}", path.display()),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_parse() {
        assert_eq!(point("0.1, 0,-2"), Ok([0.1, 0.0, -2.0]));
        assert!(point("1,2").is_err() && point("a,b,c").is_err());
    }
}

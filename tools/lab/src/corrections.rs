//! `bendtwin-lab corrections`: predictions of a twin from states that are corrected by observed points,
//! beside those that are not.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use bendtwin_core::{CancelToken, Twin};
use bendtwin_engine::Backend;
use bendtwin_eval::{CorrectionPlan, CorrectionScore, corrections, in_recording};
use bendtwin_register::CorrectOptions;
use bendtwin_terminal::{
    backend::BackendArgs,
    failure::{self, Failed},
    global::Global,
    observation, output, signals, twin_file,
};
use clap::Args;
use serde_json::{Value, json};

#[derive(Clone, Debug, Args)]
pub(crate) struct Corrections {
    /// Captures: folders, ZIP archives, or motion capture as .npz with its .json
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// The twin file. On another recording of its object the twin is registered to the first frame
    #[arg(long, value_name = "FILE")]
    twin: PathBuf,
    #[command(flatten)]
    backend: BackendArgs,
    /// Frames to predict from, for example 30,60,70, with states corrected by the points observed up to
    /// there
    #[arg(long, value_name = "FRAMES", value_delimiter = ',', required = true)]
    at: Vec<usize>,
    /// Frames to predict from each corrected state
    #[arg(long, value_name = "N", default_value_t = 30)]
    horizon: usize,
    /// Percentages of the visible points that are observed
    #[arg(long, value_name = "PERCENT", value_delimiter = ',', default_value = "10,30,100")]
    observe: Vec<f64>,
    /// Frames between corrections, in the frames before those; 0 for a single correction in each
    #[arg(long, value_name = "N", default_value_t = 5)]
    every: usize,
    /// Frames over which the velocities of the points are observed as well; 0 for only positions
    #[arg(long, value_name = "N", default_value_t = 2)]
    velocity_frames: usize,
    /// Percentage of each correction that the twin's rest shape takes over, less where the points
    /// are within their noise
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0)]
    carry: f64,
}

impl Corrections {
    fn plan(&self) -> CorrectionPlan {
        CorrectionPlan {
            frames: self.at.clone(),
            horizon: self.horizon.max(1),
            shares: self.observe.iter().map(|p| (p / 100.0).clamp(0.0, 1.0)).collect(),
            every: self.every,
            velocity_frames: self.velocity_frames,
            carry: (self.carry / 100.0).clamp(0.0, 1.0),
            options: CorrectOptions::default(),
        }
    }
}

pub(crate) async fn run(args: Corrections, global: &Global) -> anyhow::Result<()> {
    let cancel = signals::cancellation();
    let (args, quiet) = (Arc::new(args), global.json);
    let opening = Arc::clone(&args);
    let opened = tokio::task::spawn_blocking(move || {
        anyhow::Ok((opening.backend.open()?, twin_file::read(&opening.twin)?))
    });
    let (backend, twin) = opened.await??;
    let twin = Arc::new(twin);
    for path in args.paths.clone() {
        let name = path.display().to_string();
        let (args, backend, twin) = (args.clone(), backend.clone(), twin.clone());
        let cancel = cancel.clone();
        let compared = tokio::task::spawn_blocking(move || {
            compare(&path, &twin, &args.plan(), &*backend, &cancel, quiet)
        });
        let scores = compared.await??;
        let document = json!({ "path": name, "corrections": document(&scores) });
        output::print(global, &document, || format!("{name}\n\n{}", table(&scores)))?;
    }
    Ok(())
}

fn compare(
    path: &Path,
    twin: &Twin,
    plan: &CorrectionPlan,
    backend: &dyn Backend,
    cancel: &CancelToken,
    quiet: bool,
) -> anyhow::Result<Vec<CorrectionScore>> {
    let (capture, _) = observation::read(path, cancel, quiet).map_err(Failed)?;
    // Elsewhere the twin has the recording's control points.
    let there = in_recording(twin, &capture, cancel).map_err(failure::failed)?;
    let (twin, recording) =
        there.as_ref().map_or((twin, &capture), |(twin, recording)| (twin, recording));
    corrections(backend, twin, recording, plan, cancel).map_err(failure::failed)
}

/// The comparisons as JSON, errors in metres.
fn document(scores: &[CorrectionScore]) -> Value {
    let one = |s: &CorrectionScore| {
        json!({
            "frame": s.frame,
            "share": s.share,
            "points": s.points,
            "sequences": s.sequences,
            "refused": s.refused,
            "residual_mm": s.residual_mm,
            "open_loop": s.open_loop,
            "last_residual": s.last_residual,
            "corrected": s.corrected,
        })
    };
    scores.iter().map(one).collect()
}

/// The comparisons as a table.
fn table(scores: &[CorrectionScore]) -> String {
    let mut text = String::from(
        "| corrected at | points | median residual, mm | CD open / corrected, mm | | track open / last residual / corrected, mm | |\n\
         |---|---|---|---|---|---|---|\n",
    );
    let mm = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.2}", 1e3 * x));
    let change = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) if a > 0.0 => format!("{:+.0} %", 100.0 * (b / a - 1.0)),
        _ => "-".to_owned(),
    };
    for s in scores {
        let (open, held, corrected) = (s.open_loop, s.last_residual, s.corrected);
        let refused =
            if s.refused > 0 { format!(" ({} refused)", s.refused) } else { String::new() };
        text += &format!(
            "| {}{refused} | {:.0} | {:.1} to {:.1} | {} / {} | {} | {} / {} / {} | {} |\n",
            s.frame,
            s.points,
            s.residual_mm[0],
            s.residual_mm[1],
            mm(open.chamfer_l1_m),
            mm(corrected.chamfer_l1_m),
            change(open.chamfer_l1_m, corrected.chamfer_l1_m),
            mm(open.track_m),
            mm(held.track_m),
            mm(corrected.track_m),
            change(open.track_m, corrected.track_m),
        );
    }
    text
}

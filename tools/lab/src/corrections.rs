//! `bendtwin eval --correct-at`: predictions from states that are corrected by what is seen.

use bendtwin_core::{CancelToken, Capture, Twin};
use bendtwin_engine::Backend;
use bendtwin_eval::{CorrectionPlan, CorrectionScore, corrections};
use bendtwin_register::CorrectOptions;
use clap::Args;
use serde_json::{Value, json};

use crate::failure;

#[derive(Clone, Debug, Args)]
pub(super) struct CorrectArgs {
    /// Also predict from these frames, for example 30,60,70, with states corrected by the points
    /// observed up to there
    #[arg(long, value_name = "FRAMES", value_delimiter = ',')]
    correct_at: Vec<usize>,
    /// Frames to predict from each corrected state
    #[arg(long, value_name = "N", default_value_t = 30, requires = "correct_at")]
    horizon: usize,
    /// Percentages of the visible points that are observed
    #[arg(
        long,
        value_name = "PERCENT",
        value_delimiter = ',',
        default_value = "10,30,100",
        requires = "correct_at"
    )]
    observe: Vec<f64>,
    /// Frames between corrections, in the frames before those; 0 for a single correction in each
    #[arg(long, value_name = "N", default_value_t = 5, requires = "correct_at")]
    correct_every: usize,
    /// Frames over which the velocities of the points are observed as well; 0 for only positions
    #[arg(long, value_name = "N", default_value_t = 2, requires = "correct_at")]
    velocity_frames: usize,
    /// Percentage of each correction that the twin's rest shape takes over, less where the points
    /// are within their noise
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0, requires = "correct_at")]
    carry: f64,
}

impl CorrectArgs {
    /// Comparisons that were asked for.
    pub(super) fn compare(
        &self,
        backend: &dyn Backend,
        twin: &Twin,
        capture: &Capture,
        cancel: &CancelToken,
    ) -> anyhow::Result<Vec<CorrectionScore>> {
        if self.correct_at.is_empty() {
            return Ok(Vec::new());
        }
        let plan = CorrectionPlan {
            frames: self.correct_at.clone(),
            horizon: self.horizon.max(1),
            shares: self.observe.iter().map(|p| (p / 100.0).clamp(0.0, 1.0)).collect(),
            every: self.correct_every,
            velocity_frames: self.velocity_frames,
            carry: (self.carry / 100.0).clamp(0.0, 1.0),
            options: CorrectOptions::default(),
        };
        corrections(backend, twin, capture, &plan, cancel).map_err(failure::failed)
    }
}

/// The comparisons as JSON, errors in metres.
pub(super) fn document(scores: &[CorrectionScore]) -> Value {
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
pub(super) fn table(scores: &[CorrectionScore]) -> String {
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

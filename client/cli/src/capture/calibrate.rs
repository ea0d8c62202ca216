//! `bendtwin capture calibrate`: poses of the cameras from a board, a file of another program, COLMAP
//! or the correction that a report measures; and the ground from depth.

use std::path::{Path, PathBuf};

use bendtwin_calibrate::{
    board::{self, BoardView},
    colmap, files, ground,
};
use bendtwin_capture::{
    CheckReport, Limits,
    raw::{self, CALIBRATION_FILE, Calibration, Recording},
};
use bendtwin_core::{CancelToken, Finding, settings::ingest::BoardSettings};
use clap::{ArgGroup, Args, ValueEnum};
use serde_json::json;

use super::check::lines;
use crate::{
    failure::{self, Usage},
    global::Global,
    output,
    table::Table,
};

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("way").args(["board", "from", "correct", "ground"]).multiple(true).required(true))]
pub(super) struct Calibrate {
    /// A raw recording: a folder, an archive or an MCAP file
    recording: PathBuf,
    /// The board that all cameras see: charuco:7x5:30mm:22mm:DICT_5X5_100 (columns x rows, square,
    /// marker, dictionary; `:legacy` for layouts before OpenCV 4.6), or apriltag:6x6:22mm:6.6mm (a
    /// grid of Kalibr: tag, gap)
    #[arg(long, value_name = "BOARD", value_parser = board::parse, conflicts_with_all = ["from", "correct"])]
    board: Option<BoardSettings>,
    /// Kalibr's camchain.yaml, OpenCV's file storage or ROS's camera_info, one file or one for each
    /// camera; or COLMAP's folder sparse/0
    #[arg(long, value_name = "PATH", num_args = 1.., conflicts_with = "correct")]
    from: Vec<PathBuf>,
    /// Apply the correction of the camera that contradicts the others (CAMERA_OFF)
    #[arg(long)]
    correct: bool,
    /// Source of the ground: `detected` takes the largest plane outside the masks as z = 0
    #[arg(long, value_enum)]
    ground: Option<Ground>,
    /// Unit of translations in a file
    #[arg(long, value_enum, default_value_t = Unit::M, requires = "from")]
    unit: Unit,
    /// The file to write [default: calibration.json in the recording's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace a file that exists
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Ground {
    Detected,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Unit {
    M,
    Cm,
    Mm,
}

/// A calibration, or why it is missing.
#[derive(Default)]
struct Outcome {
    calibration: Option<Calibration>,
    views: Vec<BoardView>,
    /// Frames in which a board was looked for.
    frames: usize,
    findings: Vec<Finding>,
}

pub(super) async fn run(args: Calibrate, global: &Global) -> anyhow::Result<()> {
    let target = target(&args)?;
    if target.exists() && !args.force {
        let at = target.display();
        let what = format!("{at} exists: write elsewhere with --out, or replace it with --force");
        return Err(Usage::error(what));
    }
    let outcome = tokio::task::spawn_blocking(move || measure(&args)).await??;
    let mut written = None;
    if let Some(calibration) = &outcome.calibration {
        let failed = |source| raw_io(&target, source);
        std::fs::write(&target, calibration.to_json()).map_err(failed)?;
        written = Some(&target);
    }
    let document = outcome.calibration.as_ref().map(Calibration::to_json);
    let document: Option<serde_json::Value> =
        document.map(|text| serde_json::from_str(&text)).transpose()?;
    let cameras: Vec<_> = outcome
        .views
        .iter()
        .map(|view| {
            json!({
                "name": view.name,
                "frames": view.frames,
                "corners": view.corners,
                "reprojection_px": view.reprojection_px,
            })
        })
        .collect();
    let result = json!({
        "path": written,
        "calibration": document,
        "frames": outcome.frames,
        "cameras": cameras,
        "findings": outcome.findings,
    });
    output::print(global, &result, || text(&outcome, written))?;
    let report = CheckReport { findings: outcome.findings, ..CheckReport::default() };
    if outcome.calibration.is_none() {
        report.require().map_err(failure::shown)?;
    }
    Ok(())
}

fn raw_io(at: &Path, source: std::io::Error) -> anyhow::Error {
    failure::failed(bendtwin_capture::Error::Io { at: at.display().to_string(), source })
}

/// The file to write.
fn target(args: &Calibrate) -> anyhow::Result<PathBuf> {
    match &args.out {
        Some(out) => Ok(out.clone()),
        None if args.recording.is_dir() => Ok(args.recording.join(CALIBRATION_FILE)),
        None => {
            let what = "nothing is written into an archive or an MCAP file: name a file with --out";
            Err(Usage::error(what))
        }
    }
}

fn measure(args: &Calibrate) -> anyhow::Result<Outcome> {
    let cancel = CancelToken::default();
    let recording = raw::open(&args.recording, &Limits::default()).map_err(failure::failed)?;
    let mut outcome = if let Some(board) = &args.board {
        let found = board::calibrate(&recording, board, &mut |_| {}, &cancel);
        let found = found.map_err(failure::failed)?;
        Outcome {
            calibration: found.calibration,
            views: found.cameras,
            frames: found.frames,
            findings: found.findings,
        }
    } else if !args.from.is_empty() {
        import(args, &recording, &cancel)?
    } else if args.correct {
        correct(&recording, &cancel)?
    } else {
        Outcome { calibration: Some(Calibration::of(&recording, "ground")), ..Outcome::default() }
    };
    if args.ground == Some(Ground::Detected)
        && let Some(calibration) = outcome.calibration.take()
    {
        level(&recording, calibration, &mut outcome, &cancel)?;
    }
    Ok(outcome)
}

fn import(
    args: &Calibrate,
    recording: &Recording,
    cancel: &CancelToken,
) -> anyhow::Result<Outcome> {
    let imported = match args.from.as_slice() {
        [folder] if folder.is_dir() => colmap::read(folder, recording, cancel),
        paths => {
            let unit = match args.unit {
                Unit::M => files::Unit::Metres,
                Unit::Cm => files::Unit::Centimetres,
                Unit::Mm => files::Unit::Millimetres,
            };
            let read: Result<Vec<_>, _> = paths.iter().map(|path| files::read(path)).collect();
            read.and_then(|read| files::calibration(recording, &read, unit, cancel))
        }
    };
    let imported = imported.map_err(failure::failed)?;
    Ok(Outcome {
        calibration: Some(imported.calibration),
        findings: imported.findings,
        ..Outcome::default()
    })
}

/// The correction of a report, if there is one.
fn correct(recording: &Recording, cancel: &CancelToken) -> anyhow::Result<Outcome> {
    let inspection = bendtwin_inspect::inspect(recording, &Default::default(), cancel, &mut |_| {});
    let inspection = inspection.map_err(failure::failed)?;
    match inspection.correction(recording) {
        Some(calibration) => Ok(Outcome { calibration: Some(calibration), ..Outcome::default() }),
        None => Err(Usage::error(
            "no camera contradicts the others in a way that a motion would correct: see `bendtwin capture check`",
        )),
    }
}

/// Takes the ground from depth.
fn level(
    recording: &Recording,
    calibration: Calibration,
    outcome: &mut Outcome,
    cancel: &CancelToken,
) -> anyhow::Result<()> {
    let mut calibrated = recording.clone();
    calibration.apply(&mut calibrated).map_err(failure::failed)?;
    let found = ground::detect(&calibrated, cancel).map_err(failure::failed)?;
    let Some(found) = found else {
        return Err(Usage::error(
            "no plane outside the masks is large enough to be the ground: record depth with the table in view \
             (docs/use/cameras.md#ground)",
        ));
    };
    let level = ground::level(&calibrated, &found, false);
    let calibration = ground::with_poses(calibration, &level);
    let message =
        format!("the ground is a plane with {:.0} % of what the cameras see", 100.0 * found.share);
    outcome.findings.push(Finding::info("GROUND_DETECTED", message));
    outcome.calibration = Some(calibration);
    Ok(())
}

fn text(outcome: &Outcome, written: Option<&PathBuf>) -> String {
    let mut text = String::new();
    if !outcome.views.is_empty() {
        let mut table = Table::new(["CAMERA", "FRAMES", "CORNERS", "REPROJECTION"]);
        for view in &outcome.views {
            let px = view.reprojection_px.map_or("-".to_owned(), |px| format!("{px:.2} px"));
            let frames = format!("{} of {}", view.frames, outcome.frames);
            table.row([view.name.clone(), frames, view.corners.to_string(), px]);
        }
        text += table.text().trim_end();
        text += "\n";
    }
    text += &lines(&outcome.findings);
    match written {
        Some(path) => text + &format!("wrote {}", path.display()),
        None => text + "The cameras are not calibrated.",
    }
}

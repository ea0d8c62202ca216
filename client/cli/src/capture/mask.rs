//! `bendtwin capture mask`: masks of a raw recording from clicks.

mod click;
mod write;

use std::{path::PathBuf, time::Instant};

use bendtwin_capture::{Limits, raw};
use bendtwin_client::JobProgress;
use bendtwin_core::{
    CancelToken, Finding,
    settings::ingest::{IngestSettings, Part, Stroke},
};
use bendtwin_segment::{Segmented, segment};
use clap::Args;
use serde_json::json;

use self::{click::Click, write::Target};
use super::check;
use crate::{
    failure::{self, Usage},
    global::Global,
    output,
    progress::FitBar,
    signals,
};

#[derive(Debug, Args)]
pub(super) struct Mask {
    /// A raw recording: a folder, an archive or an MCAP file
    recording: PathBuf,
    /// A click on the object, as in 0:120,88: the camera by its number or name, the column and the row. A
    /// frame other than 0 follows the camera, as in 0@12:120,88
    #[arg(long, value_name = "CAMERA[@FRAME]:X,Y", num_args = 1..)]
    object: Vec<Click>,
    /// A click on a hand or gripper; one for each hand
    #[arg(long, value_name = "CAMERA[@FRAME]:X,Y", num_args = 1..)]
    hand: Vec<Click>,
    /// A click on what is neither, where it was taken for one of them
    #[arg(long, value_name = "CAMERA[@FRAME]:X,Y", num_args = 1..)]
    background: Vec<Click>,
    /// Radius of the clicks [px]
    #[arg(long, value_name = "PX", default_value_t = 4.0)]
    radius: f64,
    /// Strokes as JSON, in addition to clicks: a list as in the settings of an ingest, or the
    /// mask/following.json that this command wrote
    #[arg(long, value_name = "FILE")]
    strokes: Option<PathBuf>,
    /// Folder or ZIP archive to write [default: the recording's folder]
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Folder for pictures of all frames with the masks drawn over them: the object green, hands blue
    #[arg(long, value_name = "FOLDER")]
    preview: Option<PathBuf>,
    /// Replace masks that are there
    #[arg(long)]
    force: bool,
}

pub(super) async fn run(args: Mask, global: &Global) -> anyhow::Result<()> {
    let (cancel, quiet) = (signals::cancellation(), global.json);
    let made = tokio::task::spawn_blocking(move || make(&args, &cancel, quiet)).await??;
    output::print(global, &made.document(), || made.text())
}

/// What the command did.
struct Made {
    path: PathBuf,
    preview: Option<PathBuf>,
    frames: usize,
    seconds: f64,
    cameras: Vec<CameraDoubt>,
    findings: Vec<Finding>,
}

/// Doubt of a camera's masks.
struct CameraDoubt {
    name: String,
    mean: f64,
    most: f64,
    /// The frame of the most doubtful masks.
    frame: usize,
}

fn make(args: &Mask, cancel: &CancelToken, quiet: bool) -> anyhow::Result<Made> {
    let target = Target::new(&args.recording, args.out.as_deref(), args.force)?;
    let recording = raw::open(&args.recording, &Limits::default()).map_err(failure::failed)?;
    let strokes = strokes(args, &recording)?;
    let started = Instant::now();
    let mut bar = FitBar::new(quiet);
    let mut progress = |fraction: f64| {
        bar.show(&JobProgress { stage: "masks".to_owned(), fraction, ..JobProgress::default() });
    };
    let made = segment(&recording, &strokes, &mut progress, cancel);
    bar.finish();
    let made = made.map_err(failure::failed)?;
    let seconds = started.elapsed().as_secs_f64();
    let document = made.document(&strokes).to_string().into_bytes();
    let path = target.write(&recording, &made.masks, document, cancel)?;
    if let Some(folder) = &args.preview {
        write::preview(&recording, &made.masks, folder, cancel)?;
    }
    let Segmented { doubt, findings, .. } = made;
    let cameras = recording.cameras.iter().zip(&doubt);
    let cameras = cameras.map(|(camera, doubt)| CameraDoubt::of(&camera.name, doubt)).collect();
    let frames = recording.frame_count;
    Ok(Made { path, preview: args.preview.clone(), frames, seconds, cameras, findings })
}

/// The clicks and strokes of the command line.
fn strokes(args: &Mask, recording: &raw::Recording) -> anyhow::Result<Vec<Stroke>> {
    let mut strokes = match &args.strokes {
        Some(path) => click::read(path)?,
        None => Vec::new(),
    };
    let names: Vec<&str> = recording.cameras.iter().map(|camera| camera.name.as_str()).collect();
    for (part, clicks) in [
        (Part::Object, &args.object),
        (Part::Hand, &args.hand),
        (Part::Background, &args.background),
    ] {
        for click in clicks {
            strokes.push(click.stroke(part, args.radius, &names)?);
        }
    }
    if strokes.is_empty() {
        return Err(Usage::error(
            "nothing is marked: click on the object, as in --object 0:120,88, and on the hand, as in --hand 0:210,60 \
             (docs/use/cameras.md#masks)",
        ));
    }
    let settings = IngestSettings { strokes, ..IngestSettings::default() };
    match settings.validate() {
        Ok(()) => Ok(settings.strokes),
        Err(faults) => Err(Usage::error(faults.join("; "))),
    }
}

impl CameraDoubt {
    fn of(name: &str, doubt: &[Option<f32>]) -> Self {
        let known = || {
            let all = doubt.iter().enumerate();
            all.filter_map(|(frame, d)| Some((frame, f64::from((*d)?))))
        };
        let sum: f64 = known().map(|(_, d)| d).sum();
        let most = known().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        let mean = sum / known().count().max(1) as f64;
        Self { name: name.to_owned(), mean, most: most.1, frame: most.0 }
    }
}

impl Made {
    fn document(&self) -> serde_json::Value {
        let camera = |c: &CameraDoubt| {
            json!({
                "name": c.name,
                "mean_doubt": c.mean,
                "most_doubt": c.most,
                "most_doubtful_frame": c.frame,
            })
        };
        json!({
            "path": self.path,
            "preview": self.preview,
            "frames": self.frames,
            "seconds": self.seconds,
            "cameras": self.cameras.iter().map(camera).collect::<Vec<_>>(),
            "findings": self.findings,
        })
    }

    fn text(&self) -> String {
        let mut text = check::lines(&self.findings);
        for CameraDoubt { name, mean, most, frame } in &self.cameras {
            text += &format!(
                "camera {name}: {:.0} % of the masks are doubtful, {:.0} % at most, in frame {frame}\n",
                100.0 * mean,
                100.0 * most
            );
        }
        if let Some(folder) = &self.preview {
            text += &format!("pictures: {}\n", folder.display());
        }
        let per_frame = self.seconds / self.frames.max(1) as f64;
        text + &format!("{} ({} frames, {per_frame:.2} s each)", self.path.display(), self.frames)
    }
}

#[cfg(test)]
mod tests;

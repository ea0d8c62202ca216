//! `bendtwin eval`: fits captures on this machine and scores the twins, without a server.

mod leave_out;
mod local;
mod video;

use std::{path::PathBuf, sync::Arc};

use bendtwin_core::{CancelToken, Quality, Twin, quality::Assessment};
use bendtwin_engine::Backend;
use bendtwin_eval::{
    EvaluateOptions, TableStyle, evaluate, fast_variant, format_table, in_recording,
};
use bendtwin_fit::{Look, LookInput};
use bendtwin_terminal::twin_file;
use clap::Args;
use serde_json::json;

use self::local::{Fitted, fit};
use crate::{
    backend::BackendArgs,
    failure::{self, Failed, Usage},
    global::Global,
    observation, output,
    quality::{self, identifiability, picture},
    settings::SettingsArgs,
    signals,
};

#[derive(Debug, Args)]
pub(crate) struct Eval {
    /// Captures: folders, ZIP archives, or motion capture as .npz with its .json
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    backend: BackendArgs,
    /// Score this twin file instead of fitting one, and find its fast variant. On another recording
    /// of its object the twin is registered to the first frame
    #[arg(long, value_name = "FILE", conflicts_with_all = ["settings", "overrides", "axial", "phystwin"])]
    twin: Option<PathBuf>,
    /// Refine this twin file without a search instead of fitting one anew; on another recording of
    /// its object it is registered to the first frame
    #[arg(long, value_name = "FILE", conflicts_with_all = ["twin", "axial", "phystwin"])]
    from: Option<PathBuf>,
    /// Write the twin, with its quality table, to this file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Treat the captures as recordings of one object, leave out each in turn, and report how well
    /// twins of the others predict it: twins of one other recording, and one of all others
    /// together. All frames of the others are fitted
    #[arg(long, conflicts_with_all = ["twin", "from", "axial", "out", "picture", "video", "pairs", "per_frame"])]
    leave_out: bool,
    /// Draw predicted against observed into this PNG file
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write videos into this folder: for each camera of a raw recording the recorded images, the
    /// rendered prediction and their difference, as animated PNG, which browsers play
    #[arg(long, value_name = "DIR")]
    video: Option<PathBuf>,
    /// Write every recorded image of a raw recording beside its rendering into this folder, as the
    /// measures compare them, for other measures. A folder with pairs of an earlier run is refused
    #[arg(long, value_name = "DIR")]
    pairs: Option<PathBuf>,
    /// Include the errors of every frame (with --json)
    #[arg(long)]
    per_frame: bool,
}

pub(crate) async fn run(args: Eval, global: &Global) -> anyhow::Result<()> {
    let files = [&args.out, &args.picture, &args.video, &args.pairs];
    if args.paths.len() > 1 && files.into_iter().any(Option::is_some) {
        return Err(Usage::error(
            "--out, --picture, --video and --pairs take one capture at a time",
        ));
    }
    let cancel = signals::cancellation();
    let settings = args.settings.resolve()?;
    let opening = args.backend.clone();
    let backend = tokio::task::spawn_blocking(move || opening.open()).await??;
    let (args, quiet) = (Arc::new(args), global.json);
    if args.leave_out {
        return leave_out::run(args, settings, backend, cancel, global).await;
    }
    for path in args.paths.clone() {
        let (args, settings, cancel) = (args.clone(), settings.clone(), cancel.clone());
        let backend = Arc::clone(&backend);
        let name = path.display().to_string();
        let scored = tokio::task::spawn_blocking(move || {
            score(&path, &args, settings, &backend, &cancel, quiet)
        })
        .await??;
        let document = json!({
            "path": name,
            "quality": scored.quality,
            "assessment": scored.assessment,
            "substeps": scored.substeps,
            "fit_s": scored.fit_s,
            "videos": scored.videos,
        });
        output::print(global, &document, || text(&name, &scored))?;
    }
    Ok(())
}

/// Result of a capture.
struct Scored {
    quality: Quality,
    assessment: Assessment,
    /// Substeps of the twin [per frame].
    substeps: u32,
    fit_s: Option<f64>,
    /// Videos that were written.
    videos: Vec<PathBuf>,
}

fn score(
    path: &std::path::Path,
    args: &Eval,
    settings: bendtwin_core::FitSettings,
    backend: &Arc<dyn Backend>,
    cancel: &CancelToken,
    quiet: bool,
) -> anyhow::Result<Scored> {
    let (capture, views) = observation::read(path, cancel, quiet).map_err(Failed)?;
    let rasteriser = args.backend.rasteriser();
    let look = views.as_ref().map(|views| Look { views, rasteriser });
    let filmed = video::into("--video", args.video.as_deref(), look.as_ref())?;
    let paired = video::into_pairs(args.pairs.as_deref(), look.as_ref())?;
    let (fitted, fit_s) = match &args.twin {
        Some(file) => (Fitted { twin: twin_file::read(file)?, axial: None }, None),
        None => {
            let start = args.from.as_deref().map(twin_file::read).transpose()?;
            let (fitted, took) =
                fit(&capture, settings, start.as_ref(), look.clone(), backend, cancel, quiet)?;
            (fitted, Some(took.as_secs_f64()))
        }
    };
    // Elsewhere the twin has the recording's control points.
    let there = in_recording(&fitted.twin, &capture, cancel).map_err(failure::failed)?;
    let (shown, recording) =
        there.as_ref().map_or((&fitted.twin, &capture), |(twin, recording)| (twin, recording));
    let drawn = |twin| {
        let moved = if there.is_some() { shown } else { twin };
        LookInput { twin, moved, capture: recording, backend: &**backend }
    };
    let again = || {
        let options = EvaluateOptions { axial: fitted.axial.as_ref(), per_frame: args.per_frame };
        let measured = evaluate(&**backend, &fitted.twin, &capture, &options, cancel);
        let mut measured = measured.map_err(failure::failed)?;
        for twin in std::iter::once(&fitted.twin).chain(&fitted.axial) {
            let Some(look) = &look else { break };
            let rendered = look.score(drawn(twin), args.per_frame, cancel);
            let own = twin.quality.scores.first().map(|score| score.predictor);
            if let Some(row) = measured.scores.iter_mut().find(|s| Some(s.predictor) == own) {
                row.rendered = rendered.map_err(failure::failed)?;
            }
        }
        Ok::<_, anyhow::Error>(measured)
    };
    let fast = || fast_variant(&**backend, shown, recording, cancel).map_err(failure::failed);
    // A fit has scored its twin already; again only for what it did not keep.
    let kept = &fitted.twin.quality;
    let quality = match (&args.twin, args.per_frame) {
        (Some(_), _) => {
            let (identifiability, planner) = (kept.identifiability.clone(), kept.planner);
            Quality { fast: fast()?, identifiability, planner, ..again()? }
        }
        (None, true) => Quality {
            fast: kept.fast,
            planner: kept.planner,
            choice: kept.choice.clone(),
            identifiability: kept.identifiability.clone(),
            ..again()?
        },
        (None, false) => kept.clone(),
    };
    if let Some(file) = &args.out {
        let measured = if args.twin.is_some() { &quality } else { kept };
        let twin = Twin { quality: measured.clone(), ..fitted.twin.clone() };
        std::fs::write(file, twin.encode().map_err(failure::failed)?)?;
    }
    if let Some(file) = &args.picture {
        let axial = fitted.axial.as_ref();
        picture::draw(file, shown, axial, recording, &**backend, cancel)?;
    }
    let mut videos = Vec::new();
    let twins = std::iter::once(("", &fitted.twin));
    for (kind, twin) in twins.chain(fitted.axial.as_ref().map(|axial| ("-axial", axial))) {
        if let Some(filmed) = &filmed {
            videos.extend(filmed.videos(kind, drawn(twin), cancel)?);
        }
        if let Some(paired) = &paired {
            paired.pairs(kind, drawn(twin), cancel)?;
        }
    }
    let assessment = quality::of_twin(&fitted.twin, &quality);
    let substeps = fitted.twin.timing.substeps;
    Ok(Scored { quality, assessment, substeps, fit_s, videos })
}

fn text(name: &str, scored: &Scored) -> String {
    let mut text = format!("{name}\n\n{}", format_table(&scored.quality, TableStyle::Markdown));
    text += &format!("\n{}\n", scored.assessment);
    if let Some(line) = quality::fast(&scored.quality, scored.substeps) {
        text += &format!("\nFast: {line}.\n");
    }
    if let Some(line) = quality::planner(&scored.quality) {
        text += &format!("\nPlanner's twin: {line}.\n");
    }
    if let Some(sentences) = identifiability::sentences(&scored.quality) {
        text += &format!("\n{sentences}\n");
    }
    for video in &scored.videos {
        text += &format!("\nwrote {}", video.display());
    }
    match scored.fit_s {
        Some(seconds) => text + &format!("\nFitted in {}.\n", output::duration(seconds)),
        None => text + "\n",
    }
}

//! `bendtwin capture export`: images of one frame for trainers of Gaussian splatting.

use std::path::{Path, PathBuf};

use bendtwin_capture::{
    Limits,
    raw::{self, write_nerfstudio},
};
use bendtwin_ingest::views_of_frame;
use clap::Args;
use serde_json::json;

use crate::{
    failure::{self, Usage},
    global::Global,
    output,
};

#[derive(Debug, Args)]
pub(super) struct Export {
    /// A raw recording: a folder, an archive or an MCAP file
    recording: PathBuf,
    /// The folder to create
    folder: PathBuf,
    /// The frame, counted from 0: in frame 0 the object has the shape of its twin at rest
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u32,
}

pub(super) async fn run(args: Export, global: &Global) -> anyhow::Result<()> {
    let Export { recording, folder, frame } = args;
    let to = folder.clone();
    let images = tokio::task::spawn_blocking(move || write(&recording, &to, frame)).await??;
    let written = json!({ "path": folder, "images": images, "frame": frame });
    output::print(global, &written, || format!("{} ({images} images)", folder.display()))
}

/// Writes the folder and returns the number of images.
fn write(recording: &Path, folder: &Path, frame: u32) -> anyhow::Result<usize> {
    let recording = raw::open(recording, &Limits::default()).map_err(failure::failed)?;
    let Some(views) = views_of_frame(&recording, frame as usize) else {
        let last = recording.frame_count.saturating_sub(1);
        let what = format!(
            "no camera sees the object in frame {frame} of 0 to {last}: choose another with --frame"
        );
        return Err(Usage::error(what));
    };
    write_nerfstudio(&views, frame, folder).map_err(failure::failed)
}

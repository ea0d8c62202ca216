//! `bendtwin capture add` and `capture remove`: files that are added to a capture after its upload.

use std::path::{Path, PathBuf};

use bendtwin_client::{CaptureId, Captures, SupplementKind};
use clap::{Args, ValueEnum};
use tempfile::NamedTempFile;

use super::{archive::Listing, shown};
use crate::{global::Global, output, progress};

#[derive(Debug, Args)]
pub(super) struct Add {
    /// captures/{uuid}
    name: CaptureId,
    /// Masks in place of those of the recording: an archive with a folder `mask`, or a folder, which is
    /// packed
    #[arg(long, value_name = "FILE|FOLDER", required_unless_present = "calibration")]
    masks: Option<PathBuf>,
    /// Calibration in place of the recording's own: a document of `bendtwin capture calibrate`
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(super) struct Remove {
    /// captures/{uuid}
    name: CaptureId,
    /// Files to remove
    #[arg(required = true, value_enum)]
    kinds: Vec<Kind>,
}

/// Kind of an added file, as an argument.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    Masks,
    Calibration,
}

impl From<Kind> for SupplementKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Masks => Self::Masks,
            Kind::Calibration => Self::Calibration,
        }
    }
}

pub(super) async fn run(args: Add, global: &Global) -> anyhow::Result<()> {
    let Add { name, masks, calibration } = args;
    let client = global.connect().await?;
    let captures = client.captures();
    if let Some(path) = &masks {
        let packed = pack(path, global.json).await?;
        let file = packed.as_ref().map_or(path.as_path(), NamedTempFile::path);
        send(&captures, name, SupplementKind::Masks, file, global.json).await?;
    }
    if let Some(file) = &calibration {
        send(&captures, name, SupplementKind::Calibration, file, global.json).await?;
    }
    let capture = captures.get(name).await?;
    output::print(global, &capture, || {
        format!("{}\nnext: bendtwin capture ingest {name} --keep --watch", shown(&capture))
    })
}

pub(super) async fn remove(args: Remove, global: &Global) -> anyhow::Result<()> {
    let client = global.connect().await?;
    for kind in args.kinds {
        client.captures().delete_supplement(args.name, kind.into()).await?;
    }
    let capture = client.captures().get(args.name).await?;
    output::print(global, &capture, || shown(&capture))
}

/// Sends a file with a progress bar.
async fn send(
    captures: &Captures,
    name: CaptureId,
    kind: SupplementKind,
    file: &Path,
    quiet: bool,
) -> anyhow::Result<()> {
    let size = std::fs::metadata(file).map_or(0, |m| m.len());
    let bar = progress::byte_bar("uploading", size, quiet);
    let sent = bar.clone();
    let added = captures.add_supplement(name, kind, file, move |bytes| sent.set_position(bytes));
    let added = added.await;
    bar.finish_and_clear();
    added?;
    Ok(())
}

/// A folder of masks as an archive in a temporary file; none if it is an archive already.
async fn pack(path: &Path, quiet: bool) -> anyhow::Result<Option<NamedTempFile>> {
    if !path.is_dir() {
        return Ok(None);
    }
    // Owned here and not by the thread that fills it: an interruption is to leave none behind.
    let file = tempfile::Builder::new().prefix("bendtwin-").suffix(".zip").tempfile()?;
    let (path, into) = (path.to_owned(), file.path().to_owned());
    let packing =
        tokio::task::spawn_blocking(move || Listing::of_masks(&path)?.pack_to(&into, quiet));
    packing.await??;
    Ok(Some(file))
}

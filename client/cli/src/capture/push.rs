//! `bendtwin capture push`: checks here, packs what is no archive yet, uploads.

use std::path::{Path, PathBuf};

use bendtwin_capture::{Limits, Severity};
use bendtwin_client::Client;
use clap::Args;
use tempfile::NamedTempFile;

use super::check::{check_locally, text};
use crate::{args::Global, failure, output, progress};

#[derive(Debug, Args)]
pub(crate) struct Push {
    /// A folder, a ZIP archive, or motion capture as .npz with its .json
    path: PathBuf,
    /// What to call it [default: the file's name]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Upload without the check on this machine
    #[arg(long)]
    no_check: bool,
}

pub(super) async fn run(args: Push, global: &Global) -> anyhow::Result<()> {
    if !args.no_check {
        let report = check_locally(&args.path).await?;
        if !report.is_usable() {
            eprintln!("{}", text(&report));
            return report.require().map_err(failure::failed);
        }
        for finding in report.of(Severity::Warning) {
            eprintln!("warning: {}", finding.message);
        }
    }
    let client = global.connect().await?;
    let name = args.name.unwrap_or_else(|| display_name(&args.path));
    let capture = upload(&client, &args.path, &name, global.json).await?;
    output::print(global, &capture, || {
        format!("{}\nnext: bendtwin fit start {} --watch", capture.name, capture.name)
    })
}

/// Uploads a capture with a progress bar.
pub(crate) async fn upload(
    client: &Client,
    path: &Path,
    name: &str,
    quiet: bool,
) -> anyhow::Result<bendtwin_client::Capture> {
    let packed = pack(path).await?;
    let archive = packed.as_ref().map_or(path, NamedTempFile::path);
    let size = std::fs::metadata(archive).map_or(0, |m| m.len());
    let bar = progress::upload_bar(size, quiet);
    let sent = bar.clone();
    let uploaded =
        client.captures().upload_with(archive, name, move |bytes| sent.set_position(bytes)).await;
    bar.finish_and_clear();
    Ok(uploaded?)
}

/// A folder or an .npz as a bundle in a temporary file; nothing for what is an archive already.
async fn pack(path: &Path) -> anyhow::Result<Option<NamedTempFile>> {
    let is_npz = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"));
    let is_document = path.file_name().is_some_and(|n| n == "capture.json");
    if !path.is_dir() && !is_npz && !is_document {
        return Ok(None);
    }
    let path = path.to_owned();
    let packed = tokio::task::spawn_blocking(move || {
        let capture = bendtwin_capture::read(&path, &Limits::default()).map_err(failure::failed)?;
        let file = tempfile::Builder::new().prefix("bendtwin-").suffix(".zip").tempfile()?;
        bendtwin_capture::write_bundle_file(&capture, file.path()).map_err(failure::failed)?;
        Ok::<_, anyhow::Error>(file)
    });
    packed.await?.map(Some)
}

fn display_name(path: &Path) -> String {
    // `.` has no name of its own.
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let name = absolute.file_stem().unwrap_or(absolute.as_os_str());
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_from_files() {
        assert_eq!(display_name(Path::new("cases/rope.zip")), "rope");
        assert_eq!(display_name(Path::new("cases/rope/")), "rope");
        assert!(!display_name(Path::new(".")).is_empty());
    }
}

//! `bendtwin capture push`: checks a capture, packs what is read of it if it is no archive yet, and
//! uploads it. An interrupted upload is resumed by the same command.

use std::{
    fs::File,
    path::{Path, PathBuf},
};

use bendtwin_capture::{FilesRead, Limits};
use bendtwin_client::{Capture, CaptureFacts, Captures};
use bendtwin_core::Severity;
use clap::Args;
use tempfile::NamedTempFile;

use super::{
    archive::Listing,
    check::{check_locally, text},
    reading::follow,
};
use crate::{
    args::requirements::RequirementArgs, failure, global::Global, output, progress, signals,
};

#[derive(Debug, Args)]
pub(crate) struct Push {
    /// A folder, of which only the needed files are sent; a ZIP or tar archive; an MCAP file; or
    /// motion capture as .npz with its .json, C3D, CSV of OptiTrack or TRC
    path: PathBuf,
    #[command(flatten)]
    facts: CaptureFacts,
    /// Do not check the capture on this machine first
    #[arg(long)]
    no_check: bool,
    #[command(flatten)]
    requirements: RequirementArgs,
    /// Follow the ingest on the server and show its findings
    #[arg(long)]
    watch: bool,
}

pub(super) async fn run(args: Push, global: &Global) -> anyhow::Result<()> {
    if !args.no_check {
        let report = check_locally(&args.path).await?;
        if !report.is_usable() {
            if !global.json {
                eprintln!("{}", text(&report));
            }
            return report.require().map_err(failure::shown);
        }
        for finding in report.of(Severity::Warning) {
            eprintln!("warning: {}", finding.sentence());
        }
    }
    let client = global.connect().await?;
    let captures = client.captures();
    let mut facts = args.facts;
    facts.display_name.get_or_insert_with(|| display_name(&args.path));
    facts.ingest_requirements = args.requirements.into();
    let capture = tokio::select! {
        capture = upload(&captures, &args.path, facts, global.json) => capture?,
        () = signals::shutdown().cancelled_owned() => {
            anyhow::bail!("interrupted: push it again to resume the upload")
        }
    };
    if args.watch {
        return follow(&client, capture.name, global).await;
    }
    output::print(global, &capture, || {
        format!("{}\nnext: bendtwin fit start {} --watch", capture.name, capture.name)
    })
}

/// Uploads a capture with a progress bar.
pub(crate) async fn upload(
    captures: &Captures,
    path: &Path,
    facts: CaptureFacts,
    quiet: bool,
) -> anyhow::Result<Capture> {
    let packed = pack(path, quiet).await?;
    let archive = packed.as_ref().map_or(path, NamedTempFile::path);
    let size = std::fs::metadata(archive).map_or(0, |m| m.len());
    let bar = progress::byte_bar("uploading", size, quiet);
    let sent = bar.clone();
    let uploaded =
        captures.upload_resumable(archive, facts, move |bytes| sent.set_position(bytes)).await;
    bar.finish_and_clear();
    Ok(uploaded?)
}

/// A folder as an archive, or motion capture as a bundle, in a temporary file; none if it is an
/// archive already.
async fn pack(path: &Path, quiet: bool) -> anyhow::Result<Option<NamedTempFile>> {
    let folder = bendtwin_capture::root(path).to_owned();
    let described = bendtwin_capture::described(path);
    if !bendtwin_capture::is_npz(path) && !folder.is_dir() && described.is_none() {
        return Ok(None);
    }
    // Owned here and not by the thread that fills it: an interrupted push is to leave none behind.
    let file = tempfile::Builder::new().prefix("bendtwin-").suffix(".zip").tempfile()?;
    let (path, into) = (path.to_owned(), file.path().to_owned());
    let packed = tokio::task::spawn_blocking(move || {
        if folder.is_dir() {
            return archive(&folder, &into, quiet);
        }
        if let Some(read) = described {
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
            let listing = Listing::read_of(parent.unwrap_or(Path::new(".")), &read)?;
            return listing.pack(File::create(&into)?, |_| {});
        }
        let capture = bendtwin_capture::read(&path, &Limits::default()).map_err(failure::failed)?;
        bendtwin_capture::write_bundle_file(&capture, &into).map_err(failure::failed)
    });
    packed.await??;
    Ok(Some(file))
}

fn archive(folder: &Path, into: &Path, quiet: bool) -> anyhow::Result<()> {
    let listing = match bendtwin_capture::files_read(folder, &Limits::default()) {
        Ok(read) => {
            let listing = Listing::read_of(folder, &read)?;
            if !quiet {
                eprintln!("{}", selection(&listing, &read, &Listing::of(folder)?));
            }
            listing
        }
        // Without a check only the server judges the capture.
        Err(_) => Listing::of(folder)?,
    };
    if listing.skipped > 0 {
        eprintln!("warning: {} links and special files are left out", listing.skipped);
    }
    listing.pack_to(into, quiet)
}

/// A sentence about the files that are sent, out of all.
fn selection(listing: &Listing, read: &FilesRead, all: &Listing) -> String {
    let [sent, there] = [listing, all].map(|l| output::bytes(l.bytes()));
    let place = match read.folder.trim_end_matches('/') {
        "" => String::new(),
        folder => format!(" in {folder}"),
    };
    format!(
        "read as {}{place}: {} of {} files are sent, {sent} of {there}",
        read.format,
        listing.len(),
        all.len(),
    )
}

fn display_name(path: &Path) -> String {
    // `.` has no name.
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let name = absolute.file_stem().unwrap_or(absolute.as_os_str()).to_string_lossy();
    // Of a .tar.gz one extension is left.
    name.strip_suffix(".tar").unwrap_or(&name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_from_files() {
        assert_eq!(display_name(Path::new("cases/rope.zip")), "rope");
        assert_eq!(display_name(Path::new("cases/rope/")), "rope");
        assert_eq!(display_name(Path::new("cases/toy.v2.tar.gz")), "toy.v2");
        assert!(!display_name(Path::new(".")).is_empty());
    }
}

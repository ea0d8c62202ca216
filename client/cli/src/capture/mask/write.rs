//! Masks into the recording's folder, another folder or an archive, and pictures of them.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use bendtwin_capture::{
    Error,
    raw::{ColorImage, Image, MaskSet, Recording, Region},
};
use bendtwin_core::CancelToken;
use bendtwin_segment::FOLLOWING_FILE;

use crate::failure::{self, Usage};

/// Where masks are written.
pub(super) enum Target {
    /// `mask` in the recording's folder, with the names of its colour images.
    Recording(PathBuf),
    /// `mask` in another folder.
    Folder(PathBuf),
    Archive(PathBuf),
}

impl Target {
    /// Checks that nothing is replaced unless it is forced.
    pub(super) fn new(recording: &Path, out: Option<&Path>, force: bool) -> anyhow::Result<Self> {
        let is_zip = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("zip"));
        let target = match out {
            Some(path) if is_zip(path) => Self::Archive(path.to_owned()),
            Some(path) if path == recording => Self::in_recording(path)?,
            Some(path) => Self::Folder(path.to_owned()),
            None => Self::in_recording(recording)?,
        };
        let there = match &target {
            Self::Archive(path) => path.clone(),
            Self::Recording(folder) | Self::Folder(folder) => folder.join("mask"),
        };
        if there.exists() && !force {
            let at = there.display();
            return Err(Usage::error(format!(
                "{at} exists: replace it with --force, or write the masks elsewhere with --out"
            )));
        }
        Ok(target)
    }

    fn in_recording(path: &Path) -> anyhow::Result<Self> {
        let has = |name: &str| path.join(name).exists();
        let other = ["capture.json", "transforms.json"].into_iter().any(has);
        if has("metadata.json") && has("color") && !other {
            return Ok(Self::Recording(path.to_owned()));
        }
        Err(Usage::error(format!(
            "{} is no folder in the layout of the README, in which masks have a place: write them to an archive with --out \
             masks.zip, and add that to the uploaded capture (docs/use/cameras.md#masks)",
            path.display()
        )))
    }

    /// Writes the masks and the document that goes with them, and returns the path.
    pub(super) fn write(
        self,
        recording: &Recording,
        masks: &MaskSet,
        document: Vec<u8>,
        cancel: &CancelToken,
    ) -> anyhow::Result<PathBuf> {
        let numbered = |_: usize, frame: usize| frame.to_string();
        match self {
            Self::Archive(path) => {
                let unfinished = path.with_extension("zip.part");
                masks
                    .write_zip(&unfinished, &[(FOLLOWING_FILE, document)])
                    .map_err(failure::failed)?;
                fs::rename(&unfinished, &path)
                    .with_context(|| format!("cannot write {}", path.display()))?;
                Ok(path)
            }
            Self::Folder(folder) => replace(&folder, masks, numbered, document, cancel),
            Self::Recording(folder) => {
                let named = |camera: usize, frame: usize| {
                    let stem = recording.source.color_stem(camera, frame);
                    stem.unwrap_or_else(|| frame.to_string())
                };
                replace(&folder, masks, named, document, cancel)
            }
        }
    }
}

/// Writes the masks beside their place, then moves them there: what was there stays until all is
/// written.
fn replace(
    folder: &Path,
    masks: &MaskSet,
    stem: impl Fn(usize, usize) -> String,
    document: Vec<u8>,
    cancel: &CancelToken,
) -> anyhow::Result<PathBuf> {
    let at = || format!("cannot write to {}", folder.display());
    fs::create_dir_all(folder).with_context(at)?;
    let unfinished =
        tempfile::Builder::new().prefix(".masks").tempdir_in(folder).with_context(at)?;
    let mut put = |name: &str, bytes: Vec<u8>| {
        let path = unfinished.path().join(name);
        let failed = |source| Error::Io { at: path.display().to_string(), source };
        if cancel.is_cancelled() {
            return Err(failed(std::io::ErrorKind::Interrupted.into()));
        }
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed)?;
        }
        fs::write(&path, bytes).map_err(failed)
    };
    let written = masks.export(stem, &mut put).and_then(|()| put(FOLLOWING_FILE, document));
    if cancel.is_cancelled() {
        return Err(failure::failed(bendtwin_segment::Error::Cancelled));
    }
    written.map_err(failure::failed)?;
    let place = folder.join("mask");
    if place.exists() {
        fs::remove_dir_all(&place).with_context(at)?;
    }
    fs::rename(unfinished.path().join("mask"), &place).with_context(at)?;
    Ok(place)
}

/// Writes a picture of every frame of every camera with its masks drawn over it.
pub(super) fn preview(
    recording: &Recording,
    masks: &MaskSet,
    folder: &Path,
    cancel: &CancelToken,
) -> anyhow::Result<()> {
    let at = || format!("cannot write to {}", folder.display());
    fs::create_dir_all(folder).with_context(at)?;
    let recording = recording.usable();
    for camera in 0..recording.cameras.len() {
        let mut frames = recording.source.frames(camera).map_err(failure::failed)?;
        for frame in 0..recording.frame_count {
            if cancel.is_cancelled() {
                return Err(failure::failed(bendtwin_segment::Error::Cancelled));
            }
            let color = frames.color(frame).map_err(failure::failed)?;
            let (Some(mut color), Some(shown)) = (color, masks.shown(camera, frame)) else {
                continue;
            };
            draw(&mut color, &shown);
            let path = folder.join(format!("{camera}_{frame:05}.png"));
            fs::write(path, color.encode().map_err(failure::failed)?).with_context(at)?;
        }
    }
    Ok(())
}

/// Tints what a mask shows, and draws its outline.
fn draw(color: &mut ColorImage, shown: &Image<Option<Region>>) {
    let width = color.width;
    for (index, pixel) in color.pixels.iter_mut().enumerate() {
        let (column, row) = (index % width, index / width);
        let own = shown.get(column, row).flatten();
        let tint = match own {
            Some(Region::Object) => [30, 220, 60],
            Some(Region::Manipulator) => [50, 110, 255],
            None => continue,
        };
        let is_rim = [(1, 0), (-1, 0), (0, 1), (0, -1)].into_iter().any(|(x, y)| {
            let beside = column.checked_add_signed(x).zip(row.checked_add_signed(y));
            beside.and_then(|(x, y)| shown.get(x, y)).flatten() != own
        });
        *pixel = if is_rim { tint } else { blend(*pixel, tint) };
    }
}

/// A third of the tint over a colour.
fn blend(color: [u8; 3], tint: [u8; 3]) -> [u8; 3] {
    std::array::from_fn(|k| ((2 * u16::from(color[k]) + u16::from(tint[k])) / 3) as u8)
}

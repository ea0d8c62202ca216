//! What cameras recorded beside what a twin predicts: videos for people, and pairs of images for other
//! measures.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use bendtwin_core::CancelToken;
use bendtwin_fit::{ComparedPair, Look, LookInput};

use crate::failure::{self, Usage};

const NO_APPEARANCE: &str =
    "the twin has no appearance, so that there is nothing to draw: fit it to this recording";

/// A folder for videos or pairs of images, and what draws them.
pub(super) struct Drawings<'a> {
    folder: &'a Path,
    look: &'a Look<'a>,
}

/// The folder of an option, made if it is not there.
///
/// # Errors
/// If there are no images, or there can be no folder.
pub(super) fn into<'a>(
    option: &str,
    folder: Option<&'a Path>,
    look: Option<&'a Look<'a>>,
) -> anyhow::Result<Option<Drawings<'a>>> {
    let Some(folder) = folder else { return Ok(None) };
    let Some(look) = look else {
        let needs = "needs a raw recording with images: this capture has only tracked points";
        return Err(Usage::error(format!("{option} {needs}")));
    };
    let shown = folder.display();
    std::fs::create_dir_all(folder).with_context(|| format!("{shown} cannot be made"))?;
    Ok(Some(Drawings { folder, look }))
}

/// The folder of `--pairs`. It must have no pairs of an earlier run, which a measure of all files in it
/// would count as well.
///
/// # Errors
/// Those of [`into`], and if the folder has pairs or cannot be read.
pub(super) fn into_pairs<'a>(
    folder: Option<&'a Path>,
    look: Option<&'a Look<'a>>,
) -> anyhow::Result<Option<Drawings<'a>>> {
    let drawings = into("--pairs", folder, look)?;
    if let Some(Drawings { folder, .. }) = &drawings {
        let shown = folder.display();
        let unreadable = || format!("{shown} cannot be read");
        for entry in std::fs::read_dir(folder).with_context(unreadable)? {
            let name = entry.with_context(unreadable)?.file_name();
            if is_pair(&name.to_string_lossy()) {
                let advice = "delete them, or choose another folder";
                let fault = format!("--pairs: {shown} has pairs of an earlier run: {advice}");
                return Err(Usage::error(fault));
            }
        }
    }
    Ok(drawings)
}

/// True for a name such as `camera0-training-00012.png`.
fn is_pair(name: &str) -> bool {
    let stem = name.strip_prefix("camera").and_then(|rest| rest.strip_suffix(".png"));
    stem.is_some_and(|stem| stem.matches('-').count() >= 2)
}

impl Drawings<'_> {
    /// Writes `camera0-training-00012.png` and so on, with `kind` behind the number of the camera.
    pub(super) fn pairs(
        &self,
        kind: &str,
        drawn: LookInput<'_>,
        cancel: &CancelToken,
    ) -> anyhow::Result<()> {
        let mut write = |pair: &ComparedPair, file: &[u8]| {
            let span = if pair.is_training { "training" } else { "future" };
            let name = format!("camera{}{kind}-{span}-{:05}.png", pair.camera, pair.frame);
            std::fs::write(self.folder.join(name), file)
        };
        let drawn = self.look.pairs(drawn, &mut write, cancel).map_err(failure::failed)?;
        drawn.ok_or_else(|| Usage::error(NO_APPEARANCE))
    }

    /// Writes the video `camera0.png` and so on, with `kind` behind the number; returns their paths.
    pub(super) fn videos(
        &self,
        kind: &str,
        drawn: LookInput<'_>,
        cancel: &CancelToken,
    ) -> anyhow::Result<Vec<PathBuf>> {
        let path = |camera: usize| self.folder.join(format!("camera{camera}{kind}.png"));
        let mut open = |camera: usize| {
            let file = File::create(path(camera))?;
            Ok(Box::new(BufWriter::new(file)) as Box<dyn Write>)
        };
        let written = self.look.videos(drawn, &mut open, cancel).map_err(failure::failed)?;
        let cameras = written.ok_or_else(|| Usage::error(NO_APPEARANCE))?;
        Ok(cameras.into_iter().map(path).collect())
    }
}

#[cfg(test)]
mod tests;

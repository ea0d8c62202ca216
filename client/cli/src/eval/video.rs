//! Videos of what cameras recorded beside what a twin predicts.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use bendtwin_core::CancelToken;
use bendtwin_fit::{Look, LookInput};

use crate::failure::{self, Usage};

/// A folder for videos, and what draws them.
pub(super) struct Videos<'a> {
    folder: &'a Path,
    look: &'a Look<'a>,
}

/// A folder for videos, made if it is not there.
///
/// # Errors
/// If there are no images, or there can be no folder.
pub(super) fn into<'a>(folder: &'a Path, look: Option<&'a Look<'a>>) -> anyhow::Result<Videos<'a>> {
    let Some(look) = look else {
        let what =
            "--video needs a raw recording with images: this capture has only tracked points";
        return Err(Usage::error(what));
    };
    let shown = folder.display();
    std::fs::create_dir_all(folder).with_context(|| format!("{shown} cannot be made"))?;
    Ok(Videos { folder, look })
}

impl Videos<'_> {
    /// Writes `camera0.png` and so on, with `kind` behind the number; returns their paths.
    pub(super) fn write(
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
        let Some(cameras) = written else {
            let what = "the twin has no appearance, so that there is nothing to draw: fit it to this recording";
            return Err(Usage::error(what));
        };
        Ok(cameras.into_iter().map(path).collect())
    }
}

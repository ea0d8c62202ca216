//! Reads the views of an observation.

use std::path::Path;

use bendtwin_core::{View, ViewCamera, Views, views::Label};

use super::{Camera, Document, FORMAT, MARKER, VERSION, arrays, place};
use crate::{
    Error, Limits,
    array::Array,
    files::{Files, at_most},
    npy,
};

/// Reads the views in the archive of an observation; none if it has no views.
///
/// # Errors
/// If they are damaged, contradict themselves, or exceed the limits.
pub fn read_views(path: &Path, limits: &Limits) -> Result<Option<Views>, Error> {
    let mut files = Files::open(path, limits)?;
    if !files.list("").has(MARKER) {
        return Ok(None);
    }
    let invalid = |fault: String| Error::Document { at: MARKER.to_owned(), fault };
    let document: Document = serde_json::from_slice(&files.read_document(MARKER)?)
        .map_err(|e| invalid(e.to_string()))?;
    if document.format != FORMAT || document.version != VERSION {
        let Document { format, version, .. } = document;
        return Err(invalid(format!("it is `{format}` of version {version}")));
    }
    at_most("cameras", document.cameras.len(), limits.cameras)?;
    let cameras = document.cameras.into_iter().enumerate();
    let cameras = cameras.map(|(index, camera)| read_camera(&mut files, index, camera));
    let views = Views { cameras: cameras.collect::<Result<_, _>>()? };
    views.check().map_err(Error::Lengths)?;
    Ok(Some(views))
}

fn read_camera(files: &mut Files<'_>, index: usize, entry: Camera) -> Result<ViewCamera, Error> {
    let poses = read(files, index, arrays::POSES, |array, files| {
        let &[_, 3, 4] = array.shape.as_slice() else { return Err(array.wrong_shape("[n, 3, 4]")) };
        array.doubles(&mut files.budget)
    })?;
    let poses = poses.as_chunks::<4>().0.as_chunks::<3>().0.to_vec();
    let rows = read(files, index, arrays::VIEWS, |array, files| {
        let &[_, 5] = array.shape.as_slice() else { return Err(array.wrong_shape("[n, 5]")) };
        array.integers(&mut files.budget)
    })?;
    let colors = read(files, index, arrays::COLORS, |array, files| {
        let &[_, 3] = array.shape.as_slice() else { return Err(array.wrong_shape("[n, 3]")) };
        array.bytes(&mut files.budget)
    })?;
    let labels = read(files, index, arrays::LABELS, |a, files| a.bytes(&mut files.budget))?;
    let depths = read(files, index, arrays::DEPTHS, |a, files| a.integers(&mut files.budget))?;
    let mut pixels = Pixels { colors: colors.as_chunks().0, labels: &labels, depths: &depths };
    let mut views = Vec::with_capacity(rows.len() / 5);
    for &row in rows.as_chunks::<5>().0 {
        let number = |x: i64| u32::try_from(x).unwrap_or(u32::MAX);
        let [frame, left, top, width, height] = row.map(number);
        let view = View { frame, corner: [left, top], size: [width, height], ..View::default() };
        views.push(pixels.take(view).ok_or_else(|| {
            Error::Lengths(format!("the views of camera `{}` lack pixels", entry.name))
        })?);
    }
    let Camera { name, size, focal, centre } = entry;
    Ok(ViewCamera { name, size, focal, centre, world_to_camera: poses, views })
}

fn read<T>(
    files: &mut Files<'_>,
    camera: usize,
    array: &str,
    decode: impl FnOnce(&Array<'_>, &mut Files<'_>) -> Result<T, Error>,
) -> Result<T, Error> {
    let at = place(camera, array);
    let bytes = files.read(&at)?;
    decode(&npy::read(&at, &bytes)?, files)
}

/// The pixels of a camera that no view has taken yet.
struct Pixels<'a> {
    colors: &'a [[u8; 3]],
    labels: &'a [u8],
    depths: &'a [i64],
}

impl Pixels<'_> {
    /// A view with its pixels; none if there are not enough, or a number that they cannot have.
    fn take(&mut self, view: View) -> Option<View> {
        let count = (view.size[0] as usize).checked_mul(view.size[1] as usize)?;
        let colors = self.colors.split_off(..count)?.to_vec();
        let labels = self.labels.split_off(..count)?;
        let labels = labels.iter().map(|l| Label::from_number(*l)).collect::<Option<_>>()?;
        let depths = self.depths.split_off(..count)?;
        let depths_mm = depths.iter().map(|d| u16::try_from(*d).ok()).collect::<Option<_>>()?;
        Some(View { colors, labels, depths_mm, ..view })
    }
}

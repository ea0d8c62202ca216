//! Writes an observation with its views.

use std::path::Path;

use bendtwin_core::{Capture, View, ViewCamera, Views, views::Label};

use super::{Camera, Document, FORMAT, MARKER, VERSION, arrays, place};
use crate::{
    Error,
    bundle::{put, write_bundle_to},
    npy,
};

/// Writes a capture as a bundle ZIP at a path, with views beside it if there are any.
///
/// # Errors
/// If the capture or the views contradict themselves, or writing fails.
pub fn write_observation(
    capture: &Capture,
    views: Option<&Views>,
    path: &Path,
) -> Result<(), Error> {
    let at = path.display().to_string();
    let failed = |source| Error::Io { at: at.clone(), source };
    if let Some(views) = views {
        views.check().map_err(Error::Lengths)?;
    }
    let file = std::fs::File::create(path).map_err(failed)?;
    let mut zip = write_bundle_to(capture, std::io::BufWriter::new(file))?;
    if let Some(views) = views {
        let cameras = views.cameras.iter().map(entry).collect();
        let document = Document { format: FORMAT.to_owned(), version: VERSION, cameras };
        let json = serde_json::to_vec_pretty(&document).map_err(|e| failed(e.into()))?;
        put(&mut zip, MARKER, &json)?;
        for (index, camera) in views.cameras.iter().enumerate() {
            for (name, array) in contents(camera) {
                put(&mut zip, &place(index, name), &array)?;
            }
        }
    }
    let file = zip.finish().map_err(|e| failed(e.into()))?;
    file.into_inner().map_err(|e| failed(e.into_error()))?;
    Ok(())
}

fn entry(camera: &ViewCamera) -> Camera {
    let ViewCamera { size, focal, centre, .. } = *camera;
    Camera { name: camera.name.clone(), size, focal, centre }
}

/// The arrays of a camera.
fn contents(camera: &ViewCamera) -> [(&'static str, Vec<u8>); 5] {
    let poses = &camera.world_to_camera;
    let numbers =
        poses.iter().flatten().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let row = |v: &View| [v.frame, v.corner[0], v.corner[1], v.size[0], v.size[1]];
    let rows = camera.views.iter().flat_map(row).flat_map(u32::to_le_bytes).collect::<Vec<_>>();
    let views = || camera.views.iter();
    let colors: Vec<u8> = views().flat_map(|v| v.colors.iter().flatten()).copied().collect();
    let labels: Vec<u8> = views().flat_map(|v| &v.labels).map(|l: &Label| *l as u8).collect();
    let depths =
        views().flat_map(|v| &v.depths_mm).flat_map(|d| d.to_le_bytes()).collect::<Vec<_>>();
    let pixels = labels.len();
    [
        (arrays::POSES, npy::write("<f8", &[poses.len(), 3, 4], &numbers)),
        (arrays::VIEWS, npy::write("<u4", &[camera.views.len(), 5], &rows)),
        (arrays::COLORS, npy::write("|u1", &[pixels, 3], &colors)),
        (arrays::LABELS, npy::write("|u1", &[pixels], &labels)),
        (arrays::DEPTHS, npy::write("<u2", &[pixels], &depths)),
    ]
}

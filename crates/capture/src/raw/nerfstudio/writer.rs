//! Writer of nerfstudio folders with what cameras saw of the object in one frame, as trainers of Gaussian
//! splatting take them. The object is all that is not transparent; masks leave hands out of the training;
//! points from depth are where it begins.

use std::{fs, path::Path};

use bendtwin_core::{Point, View, ViewCamera, Views, views::Label};
use serde_json::{Value, json};

use super::{DEPTH_UNIT_M, MARKER, document::PIXEL_CENTER};
use crate::{
    Error,
    raw::{DepthImage, Mask, encode},
};

/// Most points to begin with.
const MOST_POINTS: usize = 100_000;
/// File of the points.
const POINTS: &str = "points.ply";

/// A point of the surface and its colour.
type Colored = (Point, [u8; 3]);

/// Writes `transforms.json`, images, masks, depth and points of all views of a frame into a folder,
/// which is made. Returns the number of images.
///
/// Coordinates are those of the views: metres, z up.
///
/// # Errors
/// If a file cannot be written.
pub fn write_nerfstudio(views: &Views, frame: u32, folder: &Path) -> Result<usize, Error> {
    for part in ["images", "masks", "depth"] {
        let path = folder.join(part);
        fs::create_dir_all(&path).map_err(|e| failed(&path, e))?;
    }
    let seen = views.cameras.iter().enumerate();
    let seen: Vec<(usize, &ViewCamera, &View)> =
        seen.filter_map(|(i, camera)| Some((i, camera, camera.view(frame)?))).collect();
    let mut entries = Vec::with_capacity(seen.len());
    let mut points: Vec<Colored> = Vec::new();
    for &(index, camera, view) in &seen {
        // Their names may be anything.
        let path = |part: &str| format!("{part}/camera_{index:02}.png");
        write(folder, &path("images"), &image(camera, view)?)?;
        write(folder, &path("masks"), &mask(camera, view)?)?;
        write(folder, &path("depth"), &depth(camera, view)?)?;
        points.extend(surface(camera, view));
        let mut entry = lens(camera, frame);
        entry["file_path"] = path("images").into();
        entry["mask_path"] = path("masks").into();
        entry["depth_file_path"] = path("depth").into();
        entries.push(entry);
    }
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    let kept: Vec<Colored> = points.into_iter().step_by(step).collect();
    write(folder, POINTS, &ply(&kept))?;
    let document = json!({
        "camera_model": "OPENCV",
        // Else a training turns the world, and what it makes does not lie where the object does.
        "orientation_override": "none",
        "depth_unit_scale_factor": DEPTH_UNIT_M,
        "ply_file_path": POINTS,
        "frames": entries,
    });
    write(folder, MARKER, format!("{document:#}").as_bytes())?;
    Ok(seen.len())
}

/// A camera by nerfstudio's conventions: x right, y up, z backwards, its first pixel at (0.5, 0.5).
fn lens(camera: &ViewCamera, frame: u32) -> Value {
    let pose = camera.pose(frame);
    let middle = middle(&pose);
    let row = |i: usize| [pose[0][i], -pose[1][i], -pose[2][i], middle[i]];
    json!({
        "camera_label": camera.name,
        "fl_x": camera.focal[0],
        "fl_y": camera.focal[1],
        "cx": camera.centre[0] + PIXEL_CENTER,
        "cy": camera.centre[1] + PIXEL_CENTER,
        "w": camera.size[0],
        "h": camera.size[1],
        "transform_matrix": [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
    })
}

/// Place of a camera in the world [m].
fn middle(pose: &[[f64; 4]; 3]) -> [f64; 3] {
    std::array::from_fn(|i| -pose.iter().map(|row| row[i] * row[3]).sum::<f64>())
}

/// Pixels of the whole image, `empty` beyond the view: trainers want the principal point inside.
fn whole<T: Copy>(
    camera: &ViewCamera,
    view: &View,
    empty: T,
    pixel: impl Fn(usize) -> T,
) -> Vec<T> {
    let [width, height] = camera.size;
    let places = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    places.map(|(column, row)| view.index(column, row).map_or(empty, &pixel)).collect()
}

/// The object; everything else is transparent, and black for readers that take no notice of that.
fn image(camera: &ViewCamera, view: &View) -> Result<Vec<u8>, Error> {
    let pixels = whole(camera, view, [0; 4], |i| match (view.labels[i], view.colors[i]) {
        (Label::Object, [r, g, b]) => [r, g, b, 255],
        _ => [0; 4],
    });
    encode::transparent(size(camera), &pixels)
}

/// White where a training may look: a hand may hide the object.
fn mask(camera: &ViewCamera, view: &View) -> Result<Vec<u8>, Error> {
    let [width, height] = size(camera);
    let pixels = whole(camera, view, true, |i| view.labels[i] != Label::Hand);
    encode::mask(&Mask { width, height, pixels })
}

fn depth(camera: &ViewCamera, view: &View) -> Result<Vec<u8>, Error> {
    let [width, height] = size(camera);
    let metres = |i: usize| f32::from(view.depths_mm[i]) * DEPTH_UNIT_M as f32;
    let pixels = whole(camera, view, 0.0, metres);
    encode::depth(&DepthImage { width, height, pixels }, DEPTH_UNIT_M)
}

fn size(camera: &ViewCamera) -> [usize; 2] {
    camera.size.map(|n| n as usize)
}

/// Points of the object where its depth is known.
fn surface(camera: &ViewCamera, view: &View) -> Vec<Colored> {
    let pose = camera.pose(view.frame);
    let middle = middle(&pose);
    let width = view.size[0].max(1) as usize;
    let of_object = (0..view.labels.len()).filter(|i| view.labels[*i] == Label::Object);
    let point = |i: usize| {
        let z = DEPTH_UNIT_M * f64::from(view.depths_mm[i]);
        let pixel = [i % width, i / width];
        let along = |axis: usize| {
            let place = pixel[axis] as f64 + f64::from(view.corner[axis]);
            z * (place - camera.centre[axis]) / camera.focal[axis]
        };
        let ray = [along(0), along(1), z];
        let world = |k: usize| middle[k] + (0..3).map(|row| pose[row][k] * ray[row]).sum::<f64>();
        (std::array::from_fn(|k| world(k) as f32), view.colors[i])
    };
    of_object.filter(|i| view.depths_mm[*i] > 0).map(point).collect()
}

fn ply(points: &[Colored]) -> Vec<u8> {
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment bendtwin: metres, z up\nelement vertex {}\n",
        points.len()
    );
    for (kind, names) in [("float", ["x", "y", "z"]), ("uchar", ["red", "green", "blue"])] {
        for name in names {
            header += &format!("property {kind} {name}\n");
        }
    }
    let mut bytes = (header + "end_header\n").into_bytes();
    for (point, color) in points {
        point.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(color);
    }
    bytes
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Error> {
    let path = folder.join(name);
    fs::write(&path, bytes).map_err(|e| failed(&path, e))
}

fn failed(path: &Path, source: std::io::Error) -> Error {
    Error::Io { at: path.display().to_string(), source }
}

#[cfg(test)]
mod tests;

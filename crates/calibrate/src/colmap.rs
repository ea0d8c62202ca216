//! COLMAP's `sparse/0`, as it writes it and as VGGT, MapAnything, MASt3R-SfM and Depth Anything 3
//! export: cameras, images with poses from the world to the camera, and points. Its world has no
//! scale and no up: the scale is the median over cameras of measured depth over depth of the points
//! that a camera saw, and the ground comes from depth.

mod binary;
mod model;
mod scale;
mod text;

use std::path::{Path, PathBuf};

use bendtwin_capture::raw::{CalibratedCamera, Calibration, Recording};
use bendtwin_core::{CancelToken, Finding, Severity};

pub use self::model::{Model, ModelCamera, ModelImage, ModelPoint};
use self::scale::Scale;
use crate::{Error, files::Imported, upright};

/// Spread of the scales of cameras above which something is wrong.
const SCALE_SPREAD: f64 = 0.02;
/// Difference of focal lengths that points to a wrong pinhole.
const FOCAL_RATIO: f64 = 0.03;
/// Most bytes of a file.
const MAX_BYTES: u64 = 1 << 30;

/// The poses of a recording's cameras from the model in a folder. Lenses stay the recording's own:
/// its depth belongs to them.
///
/// # Errors
/// If there is no model, it is damaged or lacks a camera, no depth gives it a scale, or a frame
/// cannot be read.
pub fn read(folder: &Path, recording: &Recording, cancel: &CancelToken) -> Result<Imported, Error> {
    calibration(&open(folder)?, recording, cancel)
}

/// `true` if a path is a folder with a model, or with `sparse` in it.
pub fn is_model(path: &Path) -> bool {
    path.is_dir() && folder_of(path).is_some()
}

/// The folder of the model at a path: itself, `0`, `sparse/0` or `sparse` in it.
fn folder_of(path: &Path) -> Option<PathBuf> {
    let has = |folder: &Path| {
        ["bin", "txt"].iter().any(|end| folder.join(format!("images.{end}")).is_file())
    };
    ["", "0", "sparse/0", "sparse"].iter().map(|part| path.join(part)).find(|folder| has(folder))
}

/// Reads the model at a path.
///
/// # Errors
/// If it is missing or damaged.
pub fn open(path: &Path) -> Result<Model, Error> {
    let at = path.display().to_string();
    let Some(folder) = folder_of(path) else {
        let fault =
            "there is no images.bin or images.txt in it: give COLMAP's folder sparse/0".to_owned();
        return Err(Error::File { at, fault });
    };
    let read = |name: &str| -> Result<(String, Vec<u8>, bool), Error> {
        for (end, is_binary) in [("bin", true), ("txt", false)] {
            let file = folder.join(format!("{name}.{end}"));
            let at = file.display().to_string();
            let Ok(metadata) = std::fs::metadata(&file) else { continue };
            if metadata.len() > MAX_BYTES {
                let fault = format!("it has {} bytes (limit {MAX_BYTES})", metadata.len());
                return Err(Error::File { at, fault });
            }
            let io = |source| bendtwin_capture::Error::Io { at: at.clone(), source };
            return Ok((at.clone(), std::fs::read(&file).map_err(io)?, is_binary));
        }
        let at = folder.display().to_string();
        Err(Error::File { at, fault: format!("{name}.bin or {name}.txt is missing") })
    };
    let [cameras, images, points] = ["cameras", "images", "points3D"].map(read);
    let parts = [&cameras?, &images?, &points?];
    decoded(parts.map(|(at, bytes, is_binary)| (at.as_str(), bytes.as_slice(), *is_binary)))
}

/// File of a model: its path, its bytes, and `true` if these are binary.
type Part<'a> = (&'a str, &'a [u8], bool);

type Decoder<T> = fn(&[u8]) -> Result<Vec<T>, String>;

fn decoded([cameras, images, points]: [Part<'_>; 3]) -> Result<Model, Error> {
    Ok(Model {
        cameras: entries(cameras, binary::cameras, text::cameras)?,
        images: entries(images, binary::images, text::images)?,
        points: entries(points, binary::points, text::points)?,
    })
}

fn entries<T>(
    (at, bytes, is_binary): Part<'_>,
    from_binary: Decoder<T>,
    from_text: Decoder<T>,
) -> Result<Vec<T>, Error> {
    let decode = if is_binary { from_binary } else { from_text };
    decode(bytes).map_err(|fault| Error::File { at: at.to_owned(), fault })
}

/// Reads a model from the contents of its three files, each binary or text.
///
/// # Errors
/// If one is damaged.
pub fn parse(
    cameras: &[u8],
    images: &[u8],
    points: &[u8],
    is_binary: bool,
) -> Result<Model, Error> {
    decoded([cameras, images, points].map(|bytes| ("the model", bytes, is_binary)))
}

/// The poses of a recording's cameras from a model.
///
/// # Errors
/// Those of [`read`].
pub fn calibration(
    model: &Model,
    recording: &Recording,
    cancel: &CancelToken,
) -> Result<Imported, Error> {
    let images = model.images_of(recording)?;
    let scale = scale::measure(model, recording, &images, cancel)?;
    let mut findings = judged(model, recording, &images, &scale);
    let cameras = recording.cameras.iter().zip(&images).map(|(camera, image)| {
        let mut pose = image.pose().inverse();
        pose.translation = pose.translation.map(|x| x * scale.metres);
        CalibratedCamera {
            name: camera.name.clone(),
            size: [camera.width, camera.height],
            intrinsics: None,
            distortion: None,
            pose: Some(pose),
            reprojection_px: None,
        }
    });
    let calibration =
        Calibration { cameras: cameras.collect(), ground: None, source: "colmap".to_owned() };
    let checked =
        Calibration::read(calibration.to_json().as_bytes(), &bendtwin_capture::Limits::default())?;
    let imported = upright::stand(recording, checked, cancel)?;
    findings.extend(imported.findings);
    Ok(Imported { calibration: imported.calibration, findings })
}

fn judged(
    model: &Model,
    recording: &Recording,
    images: &[&ModelImage],
    scale: &Scale,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let message = format!(
        "one unit of the model is {:.4} m, from the depth of {} points of {} cameras",
        scale.metres,
        scale.points,
        scale.cameras.iter().flatten().count()
    );
    findings
        .push(Finding::new(Severity::Info, "COLMAP_SCALE", message).number("metres", scale.metres));
    let off: Vec<usize> = (0..scale.cameras.len())
        .filter(|c| {
            scale.cameras[*c].is_some_and(|own| (own / scale.metres - 1.0).abs() > SCALE_SPREAD)
        })
        .collect();
    if !off.is_empty() {
        let message = format!(
            "the depth of camera {} gives the model another scale than the others (by more than {:.0} %): check these \
             cameras' depth unit and intrinsics (docs/use/cameras.md#calibration)",
            off.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
            100.0 * SCALE_SPREAD
        );
        let finding = Finding::from_sentence(Severity::Warning, "COLMAP_SCALES_DIFFER", message);
        findings.push(finding.cameras(off));
    }
    let differs: Vec<usize> = (0..images.len())
        .filter(|index| {
            let camera = &recording.cameras[*index];
            let Some(other) = model.camera(images[*index].camera) else { return false };
            // Exporters shrink images: focal lengths are compared as shares of the width.
            let own = camera.intrinsics.fx / camera.width as f64;
            let ratio = other.focal() / other.size[0] as f64 / own;
            (ratio - 1.0).abs() > FOCAL_RATIO
        })
        .collect();
    if !differs.is_empty() {
        let message = format!(
            "the model's focal lengths differ from the recording's by more than {:.0} % in camera {}: give it the \
             recording's intrinsics, and keep them fixed (docs/use/cameras.md#calibration)",
            100.0 * FOCAL_RATIO,
            differs.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
        );
        let finding = Finding::from_sentence(Severity::Warning, "COLMAP_FOCAL_DIFFERS", message);
        findings.push(finding.cameras(differs));
    }
    findings
}

#[cfg(test)]
mod tests;

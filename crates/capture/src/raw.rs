//! A raw recording: what cameras saw, before anything is lifted to points in space.
//!
//! Readers give a [`Recording`] in one form for all formats: metres, seconds, a world with z up,
//! OpenCV cameras, depth on the grid of its colour image. Frames are decoded on request, so that
//! memory stays flat; every camera has a separate reader, so that cameras can be read side by side.

mod bundle;
mod calibration;
mod camera;
mod clock;
mod decode;
mod encode;
mod gripper;
mod image;
mod mask_set;
mod mcap;
pub(crate) mod nerfstudio;
mod numbering;
mod phystwin;
mod realign;
mod stored;
mod supplement;
#[cfg(test)]
pub(crate) mod testing;
mod tracks;
mod usable;
mod validity;

use std::{path::Path, sync::Arc};

use bendtwin_core::{Environment, Finding, Point};

pub(crate) use self::{bundle::Section, decode::label_number, phystwin::names_manipulator};
pub use self::{
    bundle::{BundleOptions, write_bundle, write_bundle_to},
    calibration::{CALIBRATION_FILE, CalibratedCamera, Calibration},
    camera::{Camera, Distortion, Intrinsics, Pose, called},
    gripper::{Gripper, Pad},
    image::{ColorImage, DepthImage, Image, Mask},
    mask_set::MaskSet,
    nerfstudio::write_nerfstudio,
    phystwin::{export_case, write_case},
    supplement::{Supplements, file_in},
};
use crate::{
    Error, Limits, Sources,
    files::{Contents, Files},
    format::{Format, Place},
};

/// Opens the raw recording at a path, a folder, an archive or an MCAP file, without reading its
/// frames. Processed data beside it is passed over.
///
/// # Errors
/// If there is no recording, its description is damaged or impossible, or it exceeds the limits.
pub fn open(path: &Path, limits: &Limits) -> Result<Recording, Error> {
    match Place::at(path) {
        Place::Mcap(file) => open_mcap(file, limits),
        Place::Markers(path) => {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let there = "which has markers and no images".to_owned();
            Err(Error::UnknownKind { name, there })
        }
        Place::Arrays(path) | Place::Files(path) => find(Files::open(path, limits)?),
    }
}

/// Opens the recording in an MCAP file.
pub(crate) fn open_mcap(file: &Path, limits: &Limits) -> Result<Recording, Error> {
    let mut recording = mcap::read_file(file, limits)?;
    validity::settle(&mut recording, limits)?;
    Ok(recording)
}

/// `true` if an MCAP file lies at a path, which may be compressed as a whole.
pub(crate) fn is_mcap_at(path: &Path) -> bool {
    mcap::is_at(path)
}

/// `true` if a file is MCAP by its name, which may be compressed as a whole.
pub(crate) fn is_mcap(name: &str) -> bool {
    mcap::is_named(name)
}

/// The recording among these files.
pub(crate) fn find(mut files: Files<'static>) -> Result<Recording, Error> {
    let limits = files.limits.clone();
    if !files.settle(Format::is_in)? {
        return Err(files.unknown());
    }
    // Points that were tracked already are passed over.
    let with_images = [Format::Mcap, Format::Bundle, Format::Nerfstudio, Format::RawPhysTwin];
    let format = Format::all(&files.list("")).find(|format| with_images.contains(format));
    let document = files.find_document(CALIBRATION_FILE)?;
    // Other programs have files of that name too.
    let is_foreign = document.as_ref().is_some_and(|bytes| !Calibration::is_one(bytes));
    let document = document.filter(|_| !is_foreign);
    let calibration = document.map(|bytes| Calibration::read(&bytes, &limits)).transpose()?;
    let mut recording = match format {
        Some(Format::Mcap) => mcap::read(files)?,
        Some(Format::Bundle) => bundle::read(files)?,
        Some(Format::Nerfstudio) => nerfstudio::read(files)?,
        Some(Format::RawPhysTwin) => phystwin::read(files, calibration.as_ref())?,
        _ => return Err(files.unknown()),
    };
    if let Some(calibration) = &calibration {
        calibration.apply(&mut recording)?;
        calibration.tell(&mut recording.sources, CALIBRATION_FILE);
    }
    if is_foreign {
        recording.sources.leave_out(CALIBRATION_FILE, "it is no calibration of BendTwin");
    }
    validity::settle(&mut recording, &limits)?;
    Ok(recording)
}

/// `true` if a folder with these files is a raw PhysTwin case.
pub(crate) fn is_case(contents: &Contents) -> bool {
    phystwin::is_case(contents)
}

/// Recording of one manipulation by cameras.
#[derive(Clone, Debug)]
pub struct Recording {
    /// A person's name for it.
    pub name: String,
    /// Frames per second.
    pub fps: f64,
    /// Number of frames T, the same for every camera; what a camera lacks is `None` when it is
    /// read.
    pub frame_count: usize,
    /// Frames `0..train_frame_count` are for fitting.
    pub train_frame_count: usize,
    /// Gravity and ground in the world.
    pub environment: Environment,
    /// Rotation from the source's frame to the world, row-major.
    pub source_to_world: [[f32; 3]; 3],
    /// The cameras; at least one.
    pub cameras: Vec<Camera>,
    /// The grippers of a robot whose motion was recorded; none where masks show what moves the object.
    pub grippers: Vec<Gripper>,
    /// Shape of the object, if it was modelled or completed.
    pub mesh: Option<MeshFile>,
    /// Clean tracks for metrics only [m], shape [T, K, 3]; NaN where unknown; empty if none.
    pub truth_tracks: Vec<Point>,
    /// Mass of the object, if it was weighed [kg].
    pub mass_kg: Option<f64>,
    /// Remarks of the reader: labels and numbers as it took them, and what it noticed without
    /// failing.
    pub notes: Vec<Finding>,
    /// What the reader took as what, and what it left out.
    pub sources: Sources,
    /// Source of the frames.
    pub source: Arc<dyn Source>,
}

impl Recording {
    /// `true` if every camera has a pose.
    pub fn is_calibrated(&self) -> bool {
        self.cameras.iter().all(|camera| !camera.poses.is_empty())
    }
}

/// A mesh as it lies in a recording, not parsed.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// File name; the extension gives the format: `glb`, `obj` or `ply`.
    pub name: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// From the mesh's own axes and units to the world at the first frame. `None`: it has to be
    /// aligned.
    pub to_world: Option<Alignment>,
}

/// Rotation, uniform scale and translation: `x` becomes `rotation · x · scale + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Rotation, row-major.
    pub rotation: [[f32; 3]; 3],
    /// Metres per unit of the mesh.
    pub scale: f32,
    /// Translation [m].
    pub translation: Point,
}

/// Part of an image that a mask shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Region {
    /// The soft object.
    Object,
    /// The hands or grippers that move it, all together.
    Manipulator,
}

/// 2D tracks of one camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tracks {
    /// Number of tracks N.
    pub count: usize,
    /// Pixels as x (column), y (row); the centre of the first pixel is (0, 0). Shape [T, N, 2].
    pub points: Vec<[f32; 2]>,
    /// `true` where the tracker saw the point, shape [T, N].
    pub visible: Vec<bool>,
}

/// Source of a recording's frames.
pub trait Source: Send + Sync + std::fmt::Debug {
    /// A reader of the frames of `camera`, an index into [`Recording::cameras`].
    ///
    /// # Errors
    /// If its files cannot be opened.
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error>;

    /// Names of the files that hold frames, from the root of what was opened; empty if frames are
    /// not separate files.
    fn files(&self) -> Vec<String> {
        Vec::new()
    }

    /// Name of the file of a colour image, without folder and extension; `None` if it was not recorded,
    /// or is no separate file.
    fn color_stem(&self, _camera: usize, _frame: usize) -> Option<String> {
        None
    }
}

/// Reads the frames of one camera. All images have the size that the camera says; readers refuse
/// others.
pub trait Frames: Send {
    /// Colour, or `None` if this frame was not recorded.
    ///
    /// # Errors
    /// If the image exists but is damaged.
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error>;
    /// Depth along the optical axis [m], 0 where nothing was measured; `None` if this frame was not
    /// recorded.
    ///
    /// # Errors
    /// If the image exists but is damaged.
    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error>;
    /// A mask, or `None` if this frame has no mask.
    ///
    /// # Errors
    /// If the mask exists but is damaged.
    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error>;
    /// 2D tracks, or `None` if no tracker ran.
    ///
    /// # Errors
    /// If the tracks exist but are damaged.
    fn tracks(&mut self) -> Result<Option<Tracks>, Error>;
}

//! The parts of a model, and which image belongs to which camera of a recording.

use bendtwin_capture::raw::{Pose, Recording};
use nalgebra::{Quaternion, UnitQuaternion};

use crate::Error;

/// A camera of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelCamera {
    /// Number in the model.
    pub id: u32,
    /// Number of its kind of lens in COLMAP.
    pub kind: i32,
    /// Columns and rows.
    pub size: [u64; 2],
    /// Parameters of the lens; the first is a focal length [px].
    pub parameters: Vec<f64>,
}

/// An image of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelImage {
    /// Rotation from the world to the camera as quaternion w, x, y, z.
    pub rotation: [f64; 4],
    /// Translation from the world to the camera.
    pub translation: [f64; 3],
    /// Number of its camera.
    pub camera: u32,
    /// File name.
    pub name: String,
    /// Numbers of the points that were seen in it.
    pub points: Vec<u64>,
}

/// A point of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelPoint {
    /// Number in the model.
    pub id: u64,
    /// Place in the model's world.
    pub at: [f64; 3],
}

/// A sparse model.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Cameras.
    pub cameras: Vec<ModelCamera>,
    /// Images.
    pub images: Vec<ModelImage>,
    /// Points, ascending by their number.
    pub points: Vec<ModelPoint>,
}

/// Numbers of parameters by kind of lens: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV,
/// OPENCV_FISHEYE, FULL_OPENCV, FOV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, THIN_PRISM_FISHEYE,
/// RAD_TAN_THIN_PRISM_FISHEYE.
const PARAMETERS: [usize; 12] = [3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12, 16];

/// Names of the kinds in text files.
const KINDS: [&str; 12] = [
    "SIMPLE_PINHOLE",
    "PINHOLE",
    "SIMPLE_RADIAL",
    "RADIAL",
    "OPENCV",
    "OPENCV_FISHEYE",
    "FULL_OPENCV",
    "FOV",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
    "RAD_TAN_THIN_PRISM_FISHEYE",
];

/// Number of parameters of a kind of lens.
pub(super) fn parameter_count(kind: i32) -> Result<usize, String> {
    let known = usize::try_from(kind).ok().and_then(|kind| PARAMETERS.get(kind).copied());
    known.ok_or_else(|| format!("camera model {kind} is unknown"))
}

/// Number of the kind of a name.
pub(super) fn kind_named(name: &str) -> Result<i32, String> {
    let known = KINDS.iter().position(|kind| *kind == name);
    let shown: String = name.chars().take(40).collect();
    known.map(|kind| kind as i32).ok_or_else(|| format!("camera model `{shown}` is unknown"))
}

impl ModelCamera {
    /// Focal length in columns [px].
    pub(super) fn focal(&self) -> f64 {
        self.parameters.first().copied().unwrap_or_default()
    }
}

impl ModelImage {
    /// From the world to the camera.
    pub(super) fn pose(&self) -> Pose {
        let [w, x, y, z] = self.rotation;
        let turn =
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        Pose {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)])),
            translation: self.translation,
        }
    }

    /// Frame of the recording that it shows: the number in its name, where that is not the camera's
    /// own.
    pub(super) fn frame(&self, frame_count: usize) -> usize {
        let (folder, file) = self.name.rsplit_once(['/', '\\']).unwrap_or(("", &self.name));
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let digits: String = stem
            .chars()
            .rev()
            .take_while(char::is_ascii_digit)
            .collect::<Vec<_>>()
            .iter()
            .rev()
            .collect();
        let number = digits.parse().ok().filter(|n| *n < frame_count && !folder.is_empty());
        number.unwrap_or(0)
    }
}

impl Model {
    /// A camera by its number.
    pub(super) fn camera(&self, id: u32) -> Option<&ModelCamera> {
        self.cameras.iter().find(|camera| camera.id == id)
    }

    /// A point by its number.
    pub(super) fn point(&self, id: u64) -> Option<&ModelPoint> {
        let index = self.points.binary_search_by_key(&id, |point| point.id).ok()?;
        self.points.get(index)
    }

    /// An image for each camera of a recording: by name, `left/0001.png` or `left.png` for camera
    /// `left` or by its number, and by their order if there is one for each. Of several images of a
    /// camera, that in which most points were seen.
    pub(super) fn images_of(&self, recording: &Recording) -> Result<Vec<&ModelImage>, Error> {
        let cameras = &recording.cameras;
        let best = |index: usize, name: &str| {
            let own = self.images.iter().filter(|image| shows(&image.name, index, name));
            own.max_by_key(|image| image.points.len())
        };
        let named: Option<Vec<&ModelImage>> =
            cameras.iter().enumerate().map(|(index, camera)| best(index, &camera.name)).collect();
        if let Some(named) = named {
            return Ok(named);
        }
        if self.images.len() == cameras.len() {
            let mut ordered: Vec<&ModelImage> = self.images.iter().collect();
            ordered.sort_by(|a, b| a.name.cmp(&b.name));
            return Ok(ordered);
        }
        let list = |names: Vec<&str>| names.join("`, `");
        Err(Error::Unsuited(format!(
            "the model has {} images (`{}`), and they do not name the recording's {} cameras (`{}`): call them \
             `CAMERA/FRAME.png`, as in the folder `color`",
            self.images.len(),
            list(self.images.iter().take(4).map(|image| image.name.as_str()).collect()),
            cameras.len(),
            list(cameras.iter().take(4).map(|camera| camera.name.as_str()).collect())
        )))
    }
}

/// `true` if an image's name says that it is of a camera.
fn shows(image: &str, index: usize, name: &str) -> bool {
    let parts: Vec<&str> = image.split(['/', '\\']).collect();
    let (file, folders) = parts.split_last().unwrap_or((&"", &[]));
    let stem = file.rsplit_once('.').map_or(*file, |(stem, _)| stem);
    let is = |part: &str| {
        let number = index.to_string();
        let plain = part.to_ascii_lowercase();
        let plain = ["camera_", "camera", "cam_", "cam"]
            .iter()
            .find_map(|prefix| plain.strip_prefix(prefix))
            .unwrap_or(&plain);
        part.eq_ignore_ascii_case(name)
            || plain.parse::<usize>().is_ok_and(|n| n.to_string() == number)
    };
    match folders {
        [] => is(stem) || stem.split_once(['_', '-']).is_some_and(|(first, _)| is(first)),
        _ => folders.iter().any(|folder| is(folder)),
    }
}

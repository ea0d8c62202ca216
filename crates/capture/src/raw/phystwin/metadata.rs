//! `metadata.json` of a raw PhysTwin case: the keys that PhysTwin writes, and those that other
//! rigs need.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{MARKER, intrinsics};
use crate::{
    Error, Limits,
    raw::{
        Camera, Distortion, Pose,
        clock::retimed::Clock,
        decode::{DepthUnit, unit_fault},
        realign::{DepthCamera, Lens},
        validity,
    },
};

#[derive(Deserialize)]
pub(super) struct Metadata {
    /// May be absent beside a `calibration.json`.
    #[serde(default)]
    pub(super) intrinsics: Vec<[[f64; 3]; 3]>,
    /// Number of cameras, by the intrinsics or the calibration.
    #[serde(skip)]
    pub(super) camera_count: usize,
    #[serde(rename = "WH")]
    pub(super) size: [usize; 2],
    fps: Each<f64>,
    pub(super) frame_num: Option<usize>,
    #[serde(default)]
    pub(super) serial_numbers: Vec<Serial>,
    pub(super) up_axis: Option<String>,
    depth_unit_m: Option<Each<f64>>,
    depth_scale: Option<Each<f64>>,
    #[serde(default)]
    pub(super) object_labels: Vec<String>,
    pub(super) depth_folder: Option<String>,
    pub(super) image_orientation: Option<String>,
    frame_offsets: Option<Each<i64>>,
    depth_intrinsics: Option<Each<[[f64; 3]; 3]>>,
    depth_pose: Option<Each<Vec<[f64; 4]>>>,
    depth_size: Option<Each<[usize; 2]>>,
    depth_distortion: Option<Each<Vec<f64>>>,
    /// Times of images before PhysTwin's alignment; other programs keep other things there.
    recording: Option<serde_json::Value>,
}

/// A camera's name, which some programs write as a number.
#[derive(Clone, Deserialize)]
#[serde(untagged, expecting = "a text or a number for each camera")]
pub(super) enum Serial {
    Text(String),
    Number(u64),
}

impl Serial {
    pub(super) fn name(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => number.to_string(),
        }
    }
}

/// A value for all cameras, or one for each.
#[derive(Deserialize)]
#[serde(untagged, expecting = "one value, or a list with one for each camera")]
enum Each<T> {
    All(T),
    One(Vec<T>),
}

impl<T> Each<T> {
    /// The values of all cameras.
    fn of(&self, key: &str, cameras: usize) -> Result<Vec<&T>, Error> {
        match self {
            Self::All(value) => Ok(vec![value; cameras]),
            Self::One(values) if values.len() == cameras => Ok(values.iter().collect()),
            Self::One(values) => Err(Error::Lengths(format!(
                "`{key}` of {MARKER} has {} values for {cameras} cameras: give one, or one for each",
                values.len()
            ))),
        }
    }
}

impl Metadata {
    /// Frames per second of each camera.
    pub(super) fn rates(&self) -> Result<Vec<f64>, Error> {
        Ok(self.fps.of("fps", self.camera_count)?.into_iter().copied().collect())
    }

    /// The cameras' clocks, if their images are not numbered by the frames of the recording.
    pub(super) fn clocks(&self) -> Result<Option<(f64, Vec<Clock>)>, Error> {
        let offsets: Vec<i64> = match &self.frame_offsets {
            None => vec![0; self.camera_count],
            Some(offsets) => {
                offsets.of("frame_offsets", self.camera_count)?.into_iter().copied().collect()
            }
        };
        Clock::of(&self.rates()?, &offsets)
    }

    /// Units of depth, camera by camera.
    pub(super) fn depth_units(&self) -> Result<Vec<DepthUnit>, Error> {
        let declared = [("depth_unit_m", &self.depth_unit_m), ("depth_scale", &self.depth_scale)];
        let Some((key, values)) = declared.into_iter().find_map(|(k, v)| Some((k, v.as_ref()?)))
        else {
            return Ok(vec![DepthUnit::Usual; self.camera_count]);
        };
        let values = values.of(key, self.camera_count)?.into_iter().copied();
        let unit =
            |unit_m| DepthUnit::declared(unit_m).ok_or_else(|| wrong(unit_fault(key, unit_m)));
        values.map(unit).collect()
    }

    /// Depth cameras beside those of colour, camera by camera; none if depth is aligned to colour.
    pub(super) fn depth_cameras(
        &self,
        cameras: &[Camera],
        limits: &Limits,
    ) -> Result<Vec<Option<DepthCamera>>, Error> {
        let Some(matrices) = &self.depth_intrinsics else {
            if self.depth_pose.is_some() {
                return Err(wrong(
                    "it has `depth_pose` and no `depth_intrinsics`: give both if depth is not aligned to colour \
                     (docs/use/cameras.md#depth)"
                        .into(),
                ));
            }
            return Ok(cameras.iter().map(|_| None).collect());
        };
        let count = cameras.len();
        let matrices = matrices.of("depth_intrinsics", count)?;
        let poses = self.depth_pose.as_ref().map(|poses| poses.of("depth_pose", count));
        let poses = poses.transpose()?;
        let sizes = self.depth_size.as_ref().map(|sizes| sizes.of("depth_size", count));
        let sizes = sizes.transpose()?;
        let lenses = self.depth_distortion.as_ref().map(|of| of.of("depth_distortion", count));
        let lenses = lenses.transpose()?;
        let mut all = Vec::with_capacity(count);
        for (index, camera) in cameras.iter().enumerate() {
            let coefficients = lenses.as_ref().map_or(&[][..], |lenses| lenses[index].as_slice());
            let distortion = Distortion::brown_conrady(coefficients).ok_or_else(|| {
                wrong(format!("`depth_distortion` has {} numbers: 4, 5 or 8", coefficients.len()))
            })?;
            let depth = Lens {
                size: sizes.as_ref().map_or(self.size, |sizes| *sizes[index]),
                intrinsics: intrinsics(&camera.name, matrices[index])?,
                distortion,
            };
            let pose = match &poses {
                None => Pose::IDENTITY,
                Some(poses) => Pose::from_rows(&camera.name, poses[index])?,
            };
            all.push(Some(validity::depth_camera(camera, depth, &pose, limits)?));
        }
        Ok(all)
    }

    /// Times of the cameras' images by their numbers, if the images are as cameras recorded them, before
    /// PhysTwin's `record_data_align.py`; shape [camera].
    pub(super) fn times(&self) -> Option<Vec<BTreeMap<u64, f64>>> {
        // The alignment declares a number of frames.
        let unaligned = self.recording.as_ref().filter(|_| self.frame_num.is_none());
        let recording = unaligned?.as_object()?;
        let of = |camera: usize| {
            let times = recording.get(&camera.to_string())?.as_object()?;
            let time = |(number, time): (&String, &serde_json::Value)| {
                Some((number.parse().ok()?, time.as_f64().filter(|t| t.is_finite())?))
            };
            times.iter().map(time).collect::<Option<BTreeMap<u64, f64>>>()
        };
        let all = (0..self.camera_count).map(of).collect::<Option<Vec<_>>>()?;
        (!all.is_empty() && all.iter().all(|times| times.len() > 1)).then_some(all)
    }
}

fn wrong(fault: String) -> Error {
    Error::Document { at: MARKER.to_owned(), fault }
}

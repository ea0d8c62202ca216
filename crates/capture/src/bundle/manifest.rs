//! `capture.json`: what the arrays mean.

use bendtwin_core::{Environment, MASSES, Plane, Point, environment::STANDARD_GRAVITY};
use serde::{Deserialize, Serialize};

use super::VERSION;
use crate::{
    Error,
    frame::{self, Frame},
    phystwin::json,
    raw::Section,
};

pub(crate) const MARKER: &str = bendtwin_core::capture_files::OBSERVATION_MARKER;

/// The word in `format`.
pub(super) const FORMAT: &str = "bendtwin-capture";

/// A vector whose length is 1 to this is one that was rounded.
const UNIT: f32 = 1e-6;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Manifest {
    pub(crate) format: String,
    pub(crate) version: u64,
    #[serde(default)]
    pub(crate) name: String,
    pub(crate) units: String,
    pub(crate) up_axis: String,
    pub(crate) handedness: String,
    pub(crate) fps: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) gravity_m_s2: Option<Point>,
    /// Must be declared: `null` for no ground.
    #[serde(deserialize_with = "Option::deserialize")]
    pub(crate) ground: Option<Ground>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) source_to_world: Option<[[f32; 3]; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) mass_kg: Option<f64>,
    /// Points that were tracked already; none where the bundle is raw.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) sequences: Vec<SequenceEntry>,
    /// Raw part: the recording of the cameras.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) raw: Option<Section>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ground {
    pub(crate) normal: Point,
    pub(crate) offset: f32,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SequenceEntry {
    #[serde(default)]
    pub(crate) name: String,
    #[serde(default)]
    pub(crate) folder: String,
    pub(crate) train_frame_count: i64,
    #[serde(default = "one")]
    pub(crate) start_frames: usize,
}

fn one() -> usize {
    1
}

impl Manifest {
    /// Parses the document; the version is checked first, so that a newer bundle is distinguished
    /// from a broken one.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let wrong =
            |fault: &str| Error::Document { at: MARKER.to_owned(), fault: fault.to_owned() };
        let document: serde_json::Value = json(bytes, MARKER)?;
        if document.get("format").and_then(|f| f.as_str()) != Some(FORMAT) {
            return Err(wrong(&format!("`format` is not \"{FORMAT}\"")));
        }
        let found = document
            .get("version")
            .and_then(serde_json::Value::as_u64)
            .ok_or_else(|| wrong("`version` is not a whole number"))?;
        if found == 0 || found > VERSION {
            return Err(Error::Version { found, known: VERSION });
        }
        for (key, example) in [
            ("units", "\"m\""),
            ("up_axis", "\"+z\""),
            ("handedness", "\"right\""),
            ("ground", "{\"normal\": [0, 0, 1], \"offset\": 0} or null"),
        ] {
            if document.get(key).is_none() {
                return Err(Error::Axes(format!(
                    "`{MARKER}` does not declare `{key}`, and BendTwin does not guess: add \"{key}\": {example}"
                )));
            }
        }
        if document.get("sequences").is_none() && document.get("raw").is_none() {
            return Err(wrong("it has neither `sequences` (tracked points) nor `raw` (cameras)"));
        }
        let manifest: Self = serde_json::from_value(document).map_err(|e| wrong(&e.to_string()))?;
        match manifest.mass_kg.filter(|mass| !MASSES.contains(mass)) {
            None => Ok(manifest),
            Some(mass) => {
                let (low, high) = (MASSES.start(), MASSES.end());
                Err(wrong(&format!(
                    "`mass_kg` is {mass}: give the object's mass in kilograms, {low} to {high}, or \
                     leave it out"
                )))
            }
        }
    }

    /// Axes and units that this build writes: metres, z up. Nothing recorded yet.
    pub(crate) fn in_world(
        name: &str,
        fps: f64,
        gravity_m_s2: Point,
        ground: Option<Ground>,
        source_to_world: [[f32; 3]; 3],
    ) -> Self {
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            name: name.to_owned(),
            units: "m".to_owned(),
            up_axis: "+z".to_owned(),
            handedness: "right".to_owned(),
            fps,
            gravity_m_s2: Some(gravity_m_s2),
            ground,
            source_to_world: Some(source_to_world),
            mass_kg: None,
            sequences: Vec::new(),
            raw: None,
        }
    }

    /// Rotation and scale to the world.
    pub(crate) fn frame(&self) -> Result<Frame, Error> {
        match self.handedness.as_str() {
            "right" => {}
            "left" => {
                return Err(Error::Axes(
                    "the frame is declared left-handed: mirror one axis (x to -x, say) of all arrays and \
                     declare \"handedness\": \"right\""
                        .to_owned(),
                ));
            }
            other => {
                return Err(Error::Axes(format!(
                    "`handedness` is `{other}`: it must be \"right\""
                )));
            }
        }
        let frame = Frame::of_up_axis(&self.up_axis)?;
        Ok(Frame { metres: Frame::metres_per(&self.units)?, ..frame })
    }

    /// Rotation from the source's frame, this bundle's own turn included.
    pub(crate) fn source_to_world(&self, frame: &Frame) -> Result<[[f32; 3]; 3], Error> {
        let Some(before) = self.source_to_world else { return Ok(frame.rotation) };
        if !frame::is_rotation(&before) {
            let mirrored = if frame::determinant(&before) < 0.0 {
                "it mirrors, so one of the frames is left-handed"
            } else {
                "its rows are not orthonormal"
            };
            return Err(Error::Axes(format!(
                "`source_to_world` is no rotation ({mirrored}): correct it"
            )));
        }
        Ok(frame::compose(&frame.rotation, &before))
    }

    /// Gravity and ground in the world.
    pub(crate) fn environment(&self, frame: &Frame) -> Result<Environment, Error> {
        let gravity =
            self.gravity_m_s2.map_or([0.0, 0.0, -STANDARD_GRAVITY], |gravity| frame.turn(gravity));
        let ground = match &self.ground {
            None => None,
            Some(Ground { normal, offset }) => {
                let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
                if !(length.is_finite() && length > 1e-6 && offset.is_finite()) {
                    return Err(Error::Axes(format!(
                        "the ground's normal {normal:?} has no direction: give a unit vector away from the ground"
                    )));
                }
                // A vector that already has unit length is left unchanged, so that writing and
                // reading give the same bits.
                let length = if (length - 1.0).abs() < UNIT { 1.0 } else { length };
                let normal = frame.turn(*normal).map(|x| x / length);
                Some(Plane { normal, offset_m: offset * frame.metres / length })
            }
        };
        Ok(Environment { gravity, ground })
    }
}

//! Clicks in the form of the command line, and strokes in files.

use std::{path::Path, str::FromStr};

use anyhow::Context as _;
use bendtwin_core::settings::ingest::{Part, Stroke};
use serde::Deserialize;

use crate::{capture::strokes::parse, failure::Usage};

/// Longest file of strokes [bytes].
const MAX_BYTES: u64 = 64 << 20;

/// A click: `CAMERA[@FRAME]:X,Y`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Click {
    /// Name or number.
    camera: String,
    frame: u32,
    at: [f64; 2],
}

impl FromStr for Click {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (camera, frame, at) = parse(text).filter(|(camera, ..)| !camera.is_empty())?;
            Some(Self { camera: camera.to_owned(), frame: frame.parse().ok()?, at })
        };
        read().ok_or_else(|| {
            format!(
                "`{text}` is no click: write CAMERA:X,Y or CAMERA@FRAME:X,Y, as in 0:120,88 or 0@12:120,88"
            )
        })
    }
}

impl Click {
    /// The stroke on a part, given the names of all cameras. A name counts more than a number.
    pub(super) fn stroke(
        &self,
        part: Part,
        radius_px: f64,
        names: &[&str],
    ) -> anyhow::Result<Stroke> {
        let named = names.iter().position(|name| *name == self.camera);
        let numbered = || self.camera.parse().ok().filter(|number| *number < names.len());
        let Some(camera) = named.or_else(numbered) else {
            return Err(Usage::error(format!(
                "there is no camera `{}`: the recording has {}, numbered from 0",
                self.camera,
                names.join(", ")
            )));
        };
        Ok(Stroke {
            part,
            camera: camera as u32,
            frame: self.frame,
            points: vec![self.at],
            radius_px,
        })
    }
}

/// Strokes in a file: a list, or an object with one.
#[derive(Deserialize)]
#[serde(untagged)]
enum Document {
    List(Vec<Stroke>),
    Following { strokes: Vec<Stroke> },
}

/// Reads strokes from a file.
pub(super) fn read(path: &Path) -> anyhow::Result<Vec<Stroke>> {
    let at = || format!("cannot read {}", path.display());
    let length = std::fs::metadata(path).with_context(at)?.len();
    if length > MAX_BYTES {
        return Err(Usage::error(format!("{} has {length} bytes: no strokes do", path.display())));
    }
    let text = std::fs::read_to_string(path).with_context(at)?;
    match serde_json::from_str(&text) {
        Ok(Document::List(strokes) | Document::Following { strokes }) => Ok(strokes),
        Err(error) => Err(Usage::error(format!(
            "{} has no strokes ({error}): write a list, as in [{{\"part\": \"object\", \"camera\": 0, \"points\": [[120, 88]]}}]",
            path.display()
        ))),
    }
}

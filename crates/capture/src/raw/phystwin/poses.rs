//! Poses of a raw PhysTwin case's cameras: a list in the cameras' order, or a dictionary by their
//! names, as a pickle or as JSON.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::layout::assign;
use crate::{
    Error,
    array::Array,
    files::{Files, at_most, shortened},
    phystwin::json,
    pickle,
    raw::Pose,
};

pub(super) const CALIBRATION: &str = "calibrate.pkl";

/// The calibration, where it was not written by Python.
const CALIBRATION_JSON: &str = "calibrate.json";

/// Camera-to-world poses in the case's own world, in the cameras' order.
pub(super) struct Poses {
    /// The file that they come from.
    pub(super) at: &'static str,
    /// The form in which they were written, in words.
    pub(super) form: &'static str,
    pub(super) poses: Vec<Pose>,
}

/// Rows of one matrix.
type Rows = Vec<[f64; 4]>;

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a list of matrices, or a dictionary from a camera's name to its matrix"
)]
enum Matrices {
    List(Vec<Rows>),
    Named(BTreeMap<String, Rows>),
}

/// Reads the poses of the cameras of these names; `None` if the case is not calibrated.
pub(super) fn read(files: &mut Files<'static>, cameras: &[String]) -> Result<Option<Poses>, Error> {
    let (at, named) = match files.find(CALIBRATION)? {
        Some(bytes) => (CALIBRATION, pickled(files, &bytes)?),
        None => {
            let Some(bytes) = files.find_document(CALIBRATION_JSON)? else { return Ok(None) };
            (CALIBRATION_JSON, json::<Matrices>(&bytes, CALIBRATION_JSON)?.poses()?)
        }
    };
    let (names, poses): (Vec<Option<String>>, Vec<Pose>) = named.into_iter().unzip();
    match names.into_iter().collect::<Option<Vec<String>>>() {
        Some(names) if !names.is_empty() => {
            let assigned = assign(&names, cameras);
            let of = |place: &Option<usize>| place.and_then(|i| poses.get(i).copied());
            let found: Option<Vec<Pose>> = assigned.0.iter().map(of).collect();
            let poses = found.filter(|_| !assigned.is_by_order()).ok_or_else(|| {
                Error::Lengths(format!(
                    "{at} has poses of {}, but the cameras are {}: name the cameras in `serial_numbers` as there",
                    shortened(&names, names.len()),
                    shortened(cameras, cameras.len())
                ))
            })?;
            Ok(Some(Poses { at, form: "camera to world, by the cameras' names", poses }))
        }
        _ => Ok(Some(Poses { at, form: "camera to world, in the cameras' order", poses })),
    }
}

impl Matrices {
    fn poses(self) -> Result<Vec<(Option<String>, Pose)>, Error> {
        let pose = |camera: &str, rows: &Rows| Pose::from_rows(camera, rows);
        match self {
            Self::List(all) => {
                let all = all.iter().enumerate();
                all.map(|(index, rows)| Ok((None, pose(&index.to_string(), rows)?))).collect()
            }
            Self::Named(all) => all
                .into_iter()
                .map(|(name, rows)| Ok((Some(name.clone()), pose(&name, &rows)?)))
                .collect(),
        }
    }
}

fn pickled(files: &mut Files<'static>, bytes: &[u8]) -> Result<Vec<(Option<String>, Pose)>, Error> {
    let data = pickle::read(CALIBRATION, bytes, &files.limits, &mut files.budget)?;
    let mut poses = Vec::new();
    let arrays: Vec<(Option<String>, Array<'_>)> = match data.named_arrays()? {
        Some(named) => named.into_iter().map(|(name, array)| (Some(name), array)).collect(),
        None => data.arrays()?.into_iter().map(|array| (None, array)).collect(),
    };
    for (name, array) in arrays {
        let rows = match *array.shape.as_slice() {
            [rows @ (3 | 4), 4] => rows,
            [_, rows @ (3 | 4), 4] if name.is_none() => rows,
            _ => return Err(array.wrong_shape("[4, 4] or [3, 4] for each camera")),
        };
        let count = poses.len() + array.len() / (4 * rows);
        at_most("cameras", count, files.limits.cameras)?;
        let flat = array.doubles(&mut files.budget)?;
        for matrix in flat.as_chunks::<4>().0.chunks_exact(rows) {
            let camera = name.clone().unwrap_or_else(|| poses.len().to_string());
            poses.push((name.clone(), Pose::from_rows(&camera, matrix)?));
        }
    }
    Ok(poses)
}

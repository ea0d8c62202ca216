//! Poses and openings as arrays: a row for each frame.

use super::{Pose, Reader, document::Numbers, settle_pose, wrong};
use crate::{Error, npy};

/// Poses of a gripper [T].
pub(super) fn poses(
    reader: &mut Reader<'_, '_>,
    numbers: Numbers,
) -> Result<Vec<Option<Pose>>, Error> {
    let (name, frames) = (reader.name, reader.setting.times_s.len());
    let (columns, numbers) = rows(reader, numbers)?;
    match columns {
        7 | 12 | 16 if numbers.len() == frames * columns => {
            numbers.chunks_exact(columns).map(|row| pose(name, row)).collect()
        }
        _ => Err(wrong(format!(
            "the poses of gripper `{name}` are {} rows of {columns} numbers: give {frames} rows, one a frame, of x, y, z and a \
             quaternion x, y, z, w, or of a 4 x 4 matrix",
            numbers.len() / columns.max(1)
        ))),
    }
}

/// Distances between the fingers [T] [m].
pub(super) fn widths(reader: &mut Reader<'_, '_>, numbers: Numbers) -> Result<Vec<f64>, Error> {
    let (name, frames) = (reader.name, reader.setting.times_s.len());
    let (_, widths) = rows(reader, numbers)?;
    if widths.len() != frames {
        let count = widths.len();
        return Err(wrong(format!(
            "gripper `{name}` has {count} widths for {frames} frames: give one a frame"
        )));
    }
    Ok(widths)
}

/// The pose of what poses refer to.
pub(super) fn base(name: &str, numbers: Numbers) -> Result<Pose, Error> {
    let row: Vec<Option<f64>> = match numbers {
        Numbers::File(_) => Vec::new(),
        Numbers::Rows(rows) => rows.into_iter().flatten().collect(),
        Numbers::Row(row) => row,
    };
    let row: Vec<f64> = row.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect();
    if !matches!(row.len(), 7 | 12 | 16) {
        return Err(wrong(format!(
            "the base of gripper `{name}` is no pose: give x, y, z and a quaternion x, y, z, w, or a 4 x 4 matrix"
        )));
    }
    let known = pose(name, &row)?;
    known.ok_or_else(|| wrong(format!("the base of gripper `{name}` is not finite")))
}

/// Numbers of a row, and all numbers, row by row; unknown ones are NaN.
fn rows(reader: &mut Reader<'_, '_>, numbers: Numbers) -> Result<(usize, Vec<f64>), Error> {
    let known = |x: Option<f64>| x.unwrap_or(f64::NAN);
    match numbers {
        Numbers::File(at) => {
            let files = reader.files(&at)?;
            let bytes = files.read(&at)?;
            let array = npy::read(&at, &bytes)?;
            // Shapes of empty arrays may be of any size.
            let columns = array.shape.iter().skip(1).fold(1_usize, |all, n| all.saturating_mul(*n));
            Ok((columns, array.doubles(&mut files.budget)?))
        }
        Numbers::Row(row) => Ok((1, row.into_iter().map(known).collect())),
        Numbers::Rows(rows) => {
            let columns = rows.first().map_or(0, Vec::len);
            if rows.iter().any(|row| row.len() != columns) {
                return Err(wrong("rows of poses have different lengths".to_owned()));
            }
            Ok((columns, rows.into_iter().flatten().map(known).collect()))
        }
    }
}

/// The pose of a row, if it is known.
pub(super) fn pose(name: &str, row: &[f64]) -> Result<Option<Pose>, Error> {
    if !row.iter().all(|x| x.is_finite()) {
        return Ok(None);
    }
    let what = format!("gripper {name}");
    let pose = match *row {
        [x, y, z, i, j, k, w] => Pose::from_quaternion([i, j, k, w], [x, y, z]),
        _ => Pose::from_rows(&what, row.as_chunks::<4>().0)?,
    };
    settle_pose(&what, &pose).map(Some)
}

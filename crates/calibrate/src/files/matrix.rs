//! Matrices, rotations, pinholes and distortions in the spellings of files.

use bendtwin_capture::raw::{Distortion, Intrinsics, Pose};
use nalgebra::{Rotation3, Vector3};

use super::value::Value;

/// Rows, columns and numbers of a matrix: a map of `rows`, `cols` and `data`, or nested lists.
pub(super) fn matrix(value: &Value) -> Option<(usize, usize, Vec<f64>)> {
    if let Some(data) = value.get(&["data"]) {
        let size = |keys: &[&str]| value.get(keys)?.text()?.trim().parse::<usize>().ok();
        let (rows, columns) = (size(&["rows"])?, size(&["cols", "columns"])?);
        let numbers = data.numbers()?;
        return (rows.checked_mul(columns)? == numbers.len()).then_some((rows, columns, numbers));
    }
    let numbers = value.numbers()?;
    match value {
        Value::List(list) if matches!(list.first(), Some(Value::List(_))) => {
            let columns = numbers.len() / list.len();
            let even = list.iter().all(|row| row.numbers().is_some_and(|row| row.len() == columns));
            even.then_some((list.len(), columns, numbers))
        }
        _ => Some((1, numbers.len(), numbers)),
    }
}

/// All numbers of a matrix or list.
pub(super) fn flat(value: &Value) -> Option<Vec<f64>> {
    matrix(value).map(|(_, _, numbers)| numbers)
}

/// A pinhole from a matrix of 3 x 3 or more.
pub(super) fn pinhole(value: &Value) -> Option<Intrinsics> {
    let numbers = flat(value)?;
    let [fx, _, cx, _, fy, cy, ..] = numbers.as_slice() else { return None };
    (numbers.len() == 9).then_some(Intrinsics { fx: *fx, fy: *fy, cx: *cx, cy: *cy })
}

/// Distortion of coefficients in OpenCV's order; more than 8 of them only if they are 0.
pub(super) fn distortion(numbers: &[f64], fisheye: bool) -> Result<Distortion, String> {
    if fisheye {
        let Ok(four) = <[f64; 4]>::try_from(numbers) else {
            return Err(format!("a fisheye lens has 4 coefficients, not {}", numbers.len()));
        };
        return Ok(Distortion::KannalaBrandt(four));
    }
    let used = numbers.iter().rposition(|k| *k != 0.0).map_or(0, |last| last + 1);
    if used > 8 || !matches!(numbers.len(), 0 | 1 | 4 | 5 | 8 | 12 | 14) {
        return Err(format!(
            "the lens has {} coefficients of distortion: 4, 5 or 8 are read; calibrate without thin prism and tilt",
            numbers.len()
        ));
    }
    let mut all = [0.0; 8];
    all.iter_mut().zip(numbers).for_each(|(k, number)| *k = *number);
    Ok(if all == [0.0; 8] { Distortion::None } else { Distortion::BrownConrady(all) })
}

/// A rotation from 9 numbers, or 3 of Rodrigues' vector.
pub(super) fn rotation(numbers: &[f64]) -> Option<[[f64; 3]; 3]> {
    match numbers {
        [x, y, z] => {
            let turn = Rotation3::new(Vector3::new(*x, *y, *z));
            Some(std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)])))
        }
        [a, b, c, d, e, f, g, h, i] => Some([[*a, *b, *c], [*d, *e, *f], [*g, *h, *i]]),
        _ => None,
    }
}

/// A rigid motion from a matrix of 4 x 4 or 3 x 4.
pub(super) fn motion(value: &Value) -> Option<Pose> {
    let numbers = flat(value)?;
    if !matches!(numbers.len(), 12 | 16) {
        return None;
    }
    let row = |i: usize| &numbers[4 * i..4 * i + 4];
    Some(Pose {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| row(i)[j])),
        translation: std::array::from_fn(|i| row(i)[3]),
    })
}

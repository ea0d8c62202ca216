//! Numbers of a request that stand alone, in threes or as a quaternion.

use std::ops::RangeInclusive;

use super::Error;

/// Shortest quaternion that has a direction, by its largest component.
pub(crate) const SHORTEST_QUATERNION: f32 = 1e-6;

/// Largest deviation of a unit vector's length from 1.
const UNIT_TOLERANCE: f32 = 1e-3;

/// Three finite numbers, none larger than `most`.
pub(super) fn vector(values: &[f32], field: &str, most: f32) -> Result<[f32; 3], Error> {
    let Ok(three) = <[f32; 3]>::try_from(values) else {
        return Err(Error::field(field, format!("has {} numbers, not 3", values.len())));
    };
    match three.iter().find(|x| !x.is_finite() || x.abs() > most) {
        Some(x) => {
            let fault = format!("has {x}: each number must lie in {:?}..={most:?}", -most);
            Err(Error::field(field, fault))
        }
        None => Ok(three),
    }
}

/// Three numbers of length about one.
pub(super) fn unit(values: &[f32], field: &str) -> Result<[f32; 3], Error> {
    let direction = vector(values, field, 2.0)?;
    let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        let fault = format!("has length {length}: divide it by that");
        return Err(Error::field(field, fault));
    }
    Ok(direction)
}

/// Refuses a given number that lies outside a range, or is NaN.
pub(super) fn within_range(
    value: Option<f32>,
    field: &str,
    range: RangeInclusive<f32>,
) -> Result<(), Error> {
    match value {
        Some(x) if !range.contains(&x) => {
            let (least, most) = (range.start(), range.end());
            Err(Error::field(field, format!("is {x}: it must lie in {least}..={most}")))
        }
        _ => Ok(()),
    }
}

/// Refuses what is not finite, or less than this.
pub(super) fn least(value: f32, field: &str, least: f32) -> Result<(), Error> {
    if value.is_finite() && value >= least {
        return Ok(());
    }
    let above = if least > 0.0 { "above 0" } else { "not negative" };
    Err(Error::field(field, format!("is {value}: it must be finite and {above}")))
}

/// True for a quaternion that is too short to have a direction.
pub(super) fn angle_free(quaternion: impl Iterator<Item = f32>) -> bool {
    quaternion.fold(0.0f32, |longest, x| longest.max(x.abs())) < SHORTEST_QUATERNION
}

//! Depth from 16-bit PNG files and .npy arrays, onto the grid of the colour image.

use super::{Size, damaged, png};
use crate::{
    Error,
    array::Array,
    limits::Budget,
    npy,
    raw::{DepthImage, Image},
};

/// Metres of each 1 where nothing is declared: depth cameras count millimetres.
const MILLIMETRES: f64 = 0.001;

/// Floats are metres if all are nearer than this [m]: in millimetres no camera measures so near.
const FARTHEST_METRES: f32 = 50.0;

/// Unit of stored numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::raw) enum DepthUnit {
    /// Metres per stored number, as declared.
    Declared(f64),
    /// Millimetres, or metres of floats that look so.
    Usual,
}

/// Numbers that depth has.
pub(super) const NEEDED: &str = "depth of 16 bits or floats: 8 bits are a picture of depth, to be looked at; record the \
     camera's own numbers (docs/use/cameras.md#depth)";

impl DepthUnit {
    /// A declared unit: metres for each 1 of the stored numbers. `None` if it cannot be one.
    pub(in crate::raw) fn declared(unit_m: f64) -> Option<Self> {
        (unit_m.is_finite() && unit_m > 0.0 && unit_m <= 1.0).then_some(Self::Declared(unit_m))
    }

    /// Metres for each 1 of integers.
    fn of_integers(self) -> f64 {
        if let Self::Declared(unit_m) = self { unit_m } else { MILLIMETRES }
    }
}

/// The fault of a unit that is refused by [`DepthUnit::declared`].
pub(in crate::raw) fn unit_fault(key: &str, unit_m: f64) -> String {
    if unit_m.is_finite() && unit_m > 1.0 {
        // What people write who count the numbers in a metre.
        let reciprocal = 1.0 / unit_m;
        return format!(
            "`{key}` is {unit_m}: it is the metres that each 1 of depth means; if there are {unit_m} to a metre, give \
             {reciprocal}"
        );
    }
    format!("`{key}` is {unit_m}: 0.001 for millimetres")
}

/// The form of a depth file in words.
///
/// # Errors
/// If its numbers are no distances.
pub(in crate::raw) fn form(
    at: &str,
    bytes: &[u8],
    unit: DepthUnit,
    budget: &mut Budget,
) -> Result<String, Error> {
    let (what, unit_m) = if bytes.starts_with(png::MAGIC) {
        png::expect_depth(at, bytes)?;
        ("16-bit PNG", unit.of_integers())
    } else {
        let array: Array<'_> = npy::read(at, bytes)?;
        expect_distances(&array, unit)?;
        let unit_m = match unit {
            DepthUnit::Usual if array.is_float() && are_metres(&array.scaled(1.0, budget)?) => 1.0,
            _ => unit.of_integers(),
        };
        (array.dtype_name(), unit_m)
    };
    let said = if unit == DepthUnit::Usual { " by default" } else { "" };
    let said = if unit_m == 1.0 && unit == DepthUnit::Usual { " by their size" } else { said };
    Ok(format!("{what}, 1 is {unit_m} m{said}"))
}

/// Refuses what is made to be looked at, and no measurement.
fn expect_distances(array: &Array<'_>, unit: DepthUnit) -> Result<(), Error> {
    if array.is_u8() && unit == DepthUnit::Usual {
        return Err(Error::Dtype {
            at: array.at.clone(),
            found: "numbers of 8 bits".to_owned(),
            needed: NEEDED,
        });
    }
    Ok(())
}

/// Depth [m] from a file.
pub(in crate::raw) fn decode(
    at: &str,
    bytes: &[u8],
    unit: DepthUnit,
    size: Size,
    budget: &mut Budget,
) -> Result<DepthImage, Error> {
    if bytes.starts_with(png::MAGIC) {
        let unit_m = unit.of_integers();
        return from_png(at, bytes, size, |n| f64::from(n) * unit_m);
    }
    let array: Array<'_> = npy::read(at, bytes)?;
    let &[height, width] = array.shape.as_slice() else {
        return Err(array.wrong_shape("[height, width]"));
    };
    alike(at, [width, height], size)?;
    expect_distances(&array, unit)?;
    let mut metres = match unit {
        DepthUnit::Declared(unit_m) => array.scaled(unit_m, budget)?,
        DepthUnit::Usual => {
            let mut numbers = array.scaled(1.0, budget)?;
            if !(array.is_float() && are_metres(&numbers)) {
                // The same product as of a declared unit: of the numbers in double precision.
                numbers.iter_mut().for_each(|x| *x = (f64::from(*x) * MILLIMETRES) as f32);
            }
            numbers
        }
    };
    for x in &mut metres {
        *x = measured(f64::from(*x));
    }
    settle(at, [width, height], metres, size)
}

/// `true` if floats are metres and not millimetres by their size and their fractions.
fn are_metres(numbers: &[f32]) -> bool {
    let measured = || numbers.iter().filter(|x| x.is_finite() && **x > 0.0);
    measured().all(|x| *x < FARTHEST_METRES) && measured().any(|x| x.fract() != 0.0)
}

/// Depth from a 16-bit PNG image; `metres` converts its numbers.
pub(in crate::raw) fn from_png(
    at: &str,
    bytes: &[u8],
    size: Size,
    metres: impl Fn(u16) -> f64,
) -> Result<DepthImage, Error> {
    let samples = png::decode(at, bytes, true, |found| alike(at, found, size))?;
    if samples.channels != 1 || !samples.deep {
        let bits = if samples.deep { 16 } else { 8 };
        return Err(Error::Dtype {
            at: at.to_owned(),
            found: format!("{} channels of {bits} bits", samples.channels),
            needed: NEEDED,
        });
    }
    let numbers = samples.data.as_chunks().0.iter().map(|b| u16::from_be_bytes(*b));
    settle(at, samples.size, numbers.map(|n| measured(metres(n))).collect(), size)
}

/// The distances [m] of an image of size `found` on the camera's grid.
pub(in crate::raw) fn settle(
    at: &str,
    found: Size,
    metres: Vec<f32>,
    size: Size,
) -> Result<DepthImage, Error> {
    let [width, height] = found;
    if metres.len() != width * height {
        return Err(damaged(at, "it holds another number of pixels than its header says"));
    }
    Ok(onto_grid(Image { width, height, pixels: metres }, size))
}

/// 0 for what is no distance.
pub(in crate::raw) fn measured(m: f64) -> f32 {
    if m.is_finite() && m > 0.0 { m as f32 } else { 0.0 }
}

/// Checks that one image shows the same section as another: only its resolution may be lower or
/// higher, by at most 8.
pub(in crate::raw) fn alike(at: &str, found: Size, needed: Size) -> Result<(), Error> {
    let [w, h] = found.map(|n| n as f64);
    let [width, height] = needed.map(|n| n as f64);
    // Within half a pixel of the coarser image in each direction.
    let same_section = (w * height - h * width).abs() <= 0.5 * width.max(w).max(height).max(h);
    let near = (width / 8.0..=width * 8.0).contains(&w);
    // An array may have no rows, and still be within half a pixel of a very flat image.
    let any = w > 0.0 && h > 0.0;
    if same_section && near && any {
        return Ok(());
    }
    Err(Error::ImageSize { at: at.to_owned(), found, needed })
}

/// The image on another grid by its nearest neighbours. Depth is not interpolated: between an edge
/// and what lies behind it there is nothing.
fn onto_grid(image: DepthImage, [width, height]: Size) -> DepthImage {
    if [image.width, image.height] == [width, height] {
        return image;
    }
    let column = |c: usize| ((2 * c + 1) * image.width / (2 * width)).min(image.width - 1);
    let columns: Vec<usize> = (0..width).map(column).collect();
    let mut pixels = Vec::with_capacity(width * height);
    for r in 0..height {
        let row = image.row(((2 * r + 1) * image.height / (2 * height)).min(image.height - 1));
        pixels.extend(columns.iter().map(|c| row[*c]));
    }
    Image { width, height, pixels }
}

//! Gaussians in space, and derivatives of a loss by their parameters.

use crate::{
    Error,
    constants::{MOST_GAUSSIANS, MOST_VALUE},
    scan::first_wrong,
};

/// Gaussians in space. G is their number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gaussians {
    /// Means in the world [m], shape [G, 3].
    pub means_m: Vec<[f32; 3]>,
    /// Standard deviations along the axes of each [m], shape [G, 3]; positive.
    pub scales_m: Vec<[f32; 3]>,
    /// Rotations from the axes of each to the world as quaternions x, y, z, w, shape [G, 4]; of
    /// any length but zero.
    pub rotations: Vec<[f32; 4]>,
    /// Opacities, 0..1, shape [G].
    pub opacities: Vec<f32>,
    /// Colours as images have them (sRGB), 0..1 where they are inside of the gamut, shape [G, 3].
    pub colors: Vec<[f32; 3]>,
}

/// d loss / d Gaussians. G is their number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GaussiansBar {
    /// Gradient by means [1/m], shape [G, 3].
    pub means_m: Vec<[f32; 3]>,
    /// Gradient by scales [1/m], shape [G, 3].
    pub scales_m: Vec<[f32; 3]>,
    /// Gradient by the components of the quaternions, shape [G, 4]; orthogonal to the quaternions,
    /// since their lengths do not matter.
    pub rotations: Vec<[f32; 4]>,
    /// Gradient by opacities, shape [G].
    pub opacities: Vec<f32>,
    /// Gradient by colours, shape [G, 3].
    pub colors: Vec<[f32; 3]>,
    /// Lengths of the derivative by the projected centre [1/px], shape [G]: used by densification.
    pub screen: Vec<f32>,
}

impl Gaussians {
    /// Number of Gaussians G.
    pub fn len(&self) -> usize {
        self.means_m.len()
    }

    /// True without Gaussians.
    pub fn is_empty(&self) -> bool {
        self.means_m.is_empty()
    }

    /// Adds a Gaussian of another set.
    pub fn push_from(&mut self, other: &Self, index: usize) {
        self.means_m.push(other.means_m[index]);
        self.scales_m.push(other.scales_m[index]);
        self.rotations.push(other.rotations[index]);
        self.opacities.push(other.opacities[index]);
        self.colors.push(other.colors[index]);
    }

    /// Some of the Gaussians, in this order.
    ///
    /// # Panics
    /// If an index does not exist.
    #[must_use]
    pub fn select(&self, indices: &[usize]) -> Self {
        let mut chosen = Self::default();
        indices.iter().for_each(|&i| chosen.push_from(self, i));
        chosen
    }

    /// Checks that lengths agree, that all numbers are finite and in their ranges.
    ///
    /// # Errors
    /// The first parameter that is wrong, with its value.
    pub fn check(&self) -> Result<(), Error> {
        let expected = self.len();
        if expected > MOST_GAUSSIANS {
            return Err(Error::TooMany {
                what: "Gaussians",
                count: expected,
                most: MOST_GAUSSIANS,
            });
        }
        let lengths = [
            ("scales", self.scales_m.len()),
            ("rotations", self.rotations.len()),
            ("opacities", self.opacities.len()),
            ("colours", self.colors.len()),
        ];
        if let Some((what, got)) = lengths.into_iter().find(|(_, got)| *got != expected) {
            return Err(Error::Lengths { expected, of: "means of Gaussians", got, what });
        }
        let within = |x: f32| x.abs() <= MOST_VALUE;
        each(&self.means_m, "a mean [m] of", "it must be finite, up to 1e6", within)?;
        each(&self.scales_m, "a scale [m] of", "it must be positive, up to 1e6", |x| {
            x > 0.0 && within(x)
        })?;
        each(&self.rotations, "a quaternion with", "it must be finite, up to 1e6", within)?;
        each(&self.colors, "a colour of", "it must be finite, up to 1e6", within)?;
        let is_share = |x: f32| (0.0..=1.0).contains(&x);
        if let Some(index) = first_wrong(&self.opacities, is_share) {
            let value = self.opacities[index];
            return Err(Error::Gaussian {
                index,
                what: "opacity",
                value,
                rule: "it must be 0 to 1",
            });
        }
        let square = |q: &[f32; 4]| q.iter().map(|x| x * x).sum::<f32>();
        if let Some(index) = first_wrong(&self.rotations, |q| square(&q) >= LEAST_SQUARE) {
            return Err(Error::Gaussian {
                index,
                what: "a quaternion of squared length",
                value: square(&self.rotations[index]),
                rule: "it must be 1e-12 at least",
            });
        }
        Ok(())
    }
}

/// Squared length of a quaternion below which it has no direction.
const LEAST_SQUARE: f32 = 1e-12;

/// Fails with the first number that does not keep the rule.
fn each<const N: usize>(
    values: &[[f32; N]],
    what: &'static str,
    rule: &'static str,
    keeps: impl Fn(f32) -> bool + Sync,
) -> Result<(), Error> {
    let numbers = values.as_flattened();
    let wrong = first_wrong(numbers, keeps);
    wrong.map_or(Ok(()), |i| Err(Error::Gaussian { index: i / N, what, value: numbers[i], rule }))
}

impl GaussiansBar {
    /// Zeros for `count` Gaussians.
    pub fn zeros(count: usize) -> Self {
        Self {
            means_m: vec![[0.0; 3]; count],
            scales_m: vec![[0.0; 3]; count],
            rotations: vec![[0.0; 4]; count],
            opacities: vec![0.0; count],
            colors: vec![[0.0; 3]; count],
            screen: vec![0.0; count],
        }
    }

    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.means_m.len()
    }

    /// True without Gaussians.
    pub fn is_empty(&self) -> bool {
        self.means_m.is_empty()
    }
}

#[cfg(test)]
mod tests;

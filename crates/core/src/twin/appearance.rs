//! Appearance of a twin: colours of its skin, and Gaussians that its nodes carry.

use crate::{Point, Skin};

/// The look of a twin. M is the number of its skin points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Colour of each skin point as in images (sRGB), shape [M, 3]; empty if they are not known.
    pub skin_colors: Vec<[u8; 3]>,
    /// Gaussians that were trained or brought along.
    pub splats: Option<Splats>,
}

/// Gaussians that nodes carry. G is their number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Splats {
    /// The nodes that carry each mean, and where it is at rest.
    pub carriers: Skin,
    /// Standard deviations along the axes of each Gaussian [m], shape [G, 3].
    pub scales_m: Vec<Point>,
    /// Rotation of each Gaussian's axes at rest, unit quaternions x, y, z, w, shape [G, 4].
    pub rotations: Vec<[f32; 4]>,
    /// Opacity at each mean, 0..=1, shape [G].
    pub opacities: Vec<f32>,
    /// Colours as in images (sRGB), 0..=1 where an image can show them, shape [G, 3].
    pub colors: Vec<Point>,
}

/// Most Gaussians of a twin: readers of files know how much work there may be.
pub const MOST_SPLATS: usize = 1_000_000;
/// Largest deviation of a rotation's length from 1.
const UNIT_TOLERANCE: f32 = 1e-3;
/// Largest absolute value of a colour.
const MOST_COLOR: f32 = 100.0;

impl Appearance {
    /// Checks that there is one colour for each of `skin_count` skin points or none, and the splats.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, skin_count: usize, node_count: usize) -> Result<(), String> {
        let colors = self.skin_colors.len();
        if colors != 0 && colors != skin_count {
            return Err(format!(
                "{colors} colours for {skin_count} skin points: one each, or none"
            ));
        }
        self.splats.as_ref().map_or(Ok(()), |splats| splats.check(node_count))
    }
}

impl Splats {
    /// Number of Gaussians G.
    pub fn len(&self) -> usize {
        self.carriers.len()
    }

    /// True without Gaussians.
    pub fn is_empty(&self) -> bool {
        self.carriers.is_empty()
    }

    /// Checks that lengths agree, nodes exist and numbers are finite and in range.
    ///
    /// # Errors
    /// The first contradiction found, as a sentence.
    pub fn check(&self, node_count: usize) -> Result<(), String> {
        let count = self.len();
        if count > MOST_SPLATS {
            return Err(format!("{count} Gaussians, at most {MOST_SPLATS} may be"));
        }
        self.carriers.check(node_count).map_err(|why| format!("of the Gaussians: {why}"))?;
        let lengths = [
            ("scales", self.scales_m.len()),
            ("rotations", self.rotations.len()),
            ("opacities", self.opacities.len()),
            ("colours", self.colors.len()),
        ];
        if let Some((what, len)) = lengths.into_iter().find(|(_, len)| *len != count) {
            return Err(format!("{count} Gaussians but {len} {what}"));
        }
        if !self.scales_m.iter().flatten().all(|s| s.is_finite() && *s > 0.0) {
            return Err("a scale of a Gaussian is not a positive number".into());
        }
        let is_unit = |q: &[f32; 4]| {
            (q.iter().map(|x| x * x).sum::<f32>().sqrt() - 1.0).abs() < UNIT_TOLERANCE
        };
        if !self.rotations.iter().all(is_unit) {
            return Err("a rotation of a Gaussian is not a unit quaternion".into());
        }
        if !self.opacities.iter().all(|o| (0.0..=1.0).contains(o)) {
            return Err("an opacity of a Gaussian is not in 0 to 1".into());
        }
        if !self.colors.iter().flatten().all(|c| c.abs() <= MOST_COLOR) {
            return Err(format!("a colour of a Gaussian is beyond {MOST_COLOR}"));
        }
        Ok(())
    }
}

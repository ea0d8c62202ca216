//! Appearance in the twin file: colours of the skin, and Gaussians, both optional.

use safetensors::Dtype;

use super::{FormatError, Raw, Tensors, carried::Carried, raw};
use crate::{Appearance, Splats};

/// The tensor that a file with colours of the skin has.
const COLORS: &str = "skin.color";
/// The tensor that a file with Gaussians has.
const SCALES: &str = "splats.scale";
/// The tensors of the means of Gaussians.
const CARRIERS: Carried = Carried {
    counts: "splats.weight_count",
    nodes: "splats.weight_node",
    weights: "splats.weight",
    frames: "splats.frame",
    offsets: "splats.offset",
};

/// Tensors of an appearance.
pub(super) fn tensors(appearance: &Appearance) -> Vec<(&'static str, Raw<'static>)> {
    let mut tensors = Vec::new();
    let colors = &appearance.skin_colors;
    if !colors.is_empty() {
        tensors.push((COLORS, raw(Dtype::U8, &[colors.len(), 3], colors)));
    }
    if let Some(splats) = &appearance.splats {
        let count = splats.len();
        tensors.extend(CARRIERS.tensors(&splats.carriers));
        tensors.extend([
            (SCALES, raw(Dtype::F32, &[count, 3], &splats.scales_m)),
            ("splats.rotation", raw(Dtype::F32, &[count, 4], &splats.rotations)),
            ("splats.opacity", raw(Dtype::F32, &[count], &splats.opacities)),
            ("splats.color", raw(Dtype::F32, &[count, 3], &splats.colors)),
        ]);
    }
    tensors
}

impl Tensors<'_> {
    /// True if the file has a part of an appearance.
    pub(super) fn has_appearance(&self) -> bool {
        self.has(COLORS) || self.has(SCALES)
    }

    /// The appearance.
    pub(super) fn appearance(&self) -> Result<Appearance, FormatError> {
        let skin_colors = match self.has(COLORS) {
            true => self.read(COLORS, Dtype::U8, Some(3))?,
            false => Vec::new(),
        };
        let splats = self.has(SCALES).then(|| self.splats()).transpose()?;
        Ok(Appearance { skin_colors, splats })
    }

    fn splats(&self) -> Result<Splats, FormatError> {
        Ok(Splats {
            carriers: self.carried(&CARRIERS)?,
            scales_m: self.read(SCALES, Dtype::F32, Some(3))?,
            rotations: self.read("splats.rotation", Dtype::F32, Some(4))?,
            opacities: self.read("splats.opacity", Dtype::F32, None)?,
            colors: self.read("splats.color", Dtype::F32, Some(3))?,
        })
    }
}

//! The surface in the twin file. A file of any version may have one: programs that do not know it simulate the
//! same twin.

use safetensors::Dtype;

use super::{FormatError, Raw, Tensors, carried::Carried, raw};
use crate::{Surface, Tube};

/// The tensor that a file with a surface has.
const TRIANGLES: &str = "surface.triangle";
/// The tensor that a file with colours of the surface has.
const COLORS: &str = "surface.color";
/// The tensor that a file with tubes has.
const TUBES: &str = "surface.tube_length";
/// The tensors of the vertices.
const CARRIERS: Carried = Carried {
    counts: "surface.weight_count",
    nodes: "surface.weight_node",
    weights: "surface.weight",
    frames: "surface.frame",
    offsets: "surface.offset",
};

/// Tensors of a surface.
pub(super) fn tensors(surface: &Surface) -> Vec<(&'static str, Raw<'static>)> {
    let mut tensors = Vec::from(CARRIERS.tensors(&surface.carriers));
    let triangles = &surface.triangles;
    tensors.push((TRIANGLES, raw(Dtype::U32, &[triangles.len(), 3], triangles)));
    if !surface.colors.is_empty() {
        tensors.push((COLORS, raw(Dtype::U8, &[surface.colors.len(), 3], &surface.colors)));
    }
    if !surface.tubes.is_empty() {
        let tubes = &surface.tubes;
        let lengths: Vec<u32> = tubes.iter().map(|tube| tube.nodes.len() as u32).collect();
        let nodes: Vec<u32> = tubes.iter().flat_map(|tube| tube.nodes.iter().copied()).collect();
        let radii: Vec<f32> = tubes.iter().map(|tube| tube.radius_m).collect();
        tensors.extend([
            (TUBES, raw(Dtype::U32, &[tubes.len()], &lengths)),
            ("surface.tube_node", raw(Dtype::U32, &[nodes.len()], &nodes)),
            ("surface.tube_radius", raw(Dtype::F32, &[tubes.len()], &radii)),
        ]);
    }
    tensors
}

impl Tensors<'_> {
    /// The surface, if the file has one.
    pub(super) fn surface(&self) -> Result<Option<Surface>, FormatError> {
        if !self.has(TRIANGLES) {
            return Ok(None);
        }
        Ok(Some(Surface {
            carriers: self.carried(&CARRIERS)?,
            triangles: self.read(TRIANGLES, Dtype::U32, Some(3))?,
            colors: match self.has(COLORS) {
                true => self.read(COLORS, Dtype::U8, Some(3))?,
                false => Vec::new(),
            },
            tubes: if self.has(TUBES) { self.tubes()? } else { Vec::new() },
        }))
    }

    fn tubes(&self) -> Result<Vec<Tube>, FormatError> {
        let lengths: Vec<u32> = self.read(TUBES, Dtype::U32, None)?;
        let radii: Vec<f32> = self.read("surface.tube_radius", Dtype::F32, None)?;
        let nodes: Vec<u32> = self.read("surface.tube_node", Dtype::U32, None)?;
        let total: u64 = lengths.iter().copied().map(u64::from).sum();
        if radii.len() != lengths.len() || total != nodes.len() as u64 {
            let why = format!(
                "{} tubes with {total} nodes, but {} radii and {} nodes",
                lengths.len(),
                radii.len(),
                nodes.len()
            );
            return Err(FormatError::Inconsistent(why));
        }
        let mut rest = nodes.into_iter();
        let tube = |(length, radius_m): (&u32, f32)| Tube {
            nodes: rest.by_ref().take(*length as usize).collect(),
            radius_m,
        };
        Ok(lengths.iter().zip(radii).map(tube).collect())
    }
}

//! Points that nodes carry, in the twin file: those of the skin, of Gaussians and of the surface have the same five
//! tensors. Weights stand one point after another.

use safetensors::Dtype;

use super::{FormatError, Raw, Tensors, raw};
use crate::{Graph, Skin};

/// Names of the tensors of carried points.
pub(super) struct Carried {
    pub(super) counts: &'static str,
    pub(super) nodes: &'static str,
    pub(super) weights: &'static str,
    pub(super) frames: &'static str,
    pub(super) offsets: &'static str,
}

impl Carried {
    /// Tensors of points, without the tracked points that they are.
    pub(super) fn tensors(&self, points: &Skin) -> [(&'static str, Raw<'static>); 5] {
        let (count, weights) = (points.len(), points.nodes.len());
        let counts: Vec<u32> = points.starts.windows(2).map(|w| w[1] - w[0]).collect();
        [
            (self.counts, raw(Dtype::U32, &[count], &counts)),
            (self.nodes, raw(Dtype::U32, &[weights], &points.nodes)),
            (self.weights, raw(Dtype::F32, &[weights], &points.weights)),
            (self.frames, raw(Dtype::U32, &[count, 3], &points.frames)),
            (self.offsets, raw(Dtype::F32, &[count, 3], &points.offsets_m)),
        ]
    }
}

impl Tensors<'_> {
    /// Points that are no tracked points.
    pub(super) fn carried(&self, names: &Carried) -> Result<Skin, FormatError> {
        let counts: Vec<u32> = self.read(names.counts, Dtype::U32, None)?;
        Ok(Skin {
            observed_points: vec![Graph::NOT_OBSERVED; counts.len()],
            starts: starts(names.counts, &counts)?,
            nodes: self.read(names.nodes, Dtype::U32, None)?,
            weights: self.read(names.weights, Dtype::F32, None)?,
            frames: self.read(names.frames, Dtype::U32, Some(3))?,
            offsets_m: self.read(names.offsets, Dtype::F32, Some(3))?,
        })
    }
}

/// The first weight of each point and the end of the last, of the numbers of weights that a tensor holds.
fn starts(tensor: &str, counts: &[u32]) -> Result<Vec<u32>, FormatError> {
    let mut starts = Vec::with_capacity(counts.len() + 1);
    starts.push(0_u32);
    for &count in counts {
        let last = starts[starts.len() - 1];
        let Some(end) = last.checked_add(count) else {
            let why = format!("{tensor} adds up to more than indices can name");
            return Err(FormatError::Inconsistent(why));
        };
        starts.push(end);
    }
    Ok(starts)
}

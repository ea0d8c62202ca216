//! Facts of a twin that requests are checked against.

use crate::v1::Fidelity;

/// Facts of a twin that requests are checked against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TwinShape {
    /// Number of nodes N.
    pub nodes: u64,
    /// Number of springs.
    pub springs: u64,
    /// Number of triplets.
    pub triplets: u64,
    /// Number of control points C.
    pub controls: u64,
    /// Number of points of its skin, where it is known: a server that stored the twin before it
    /// counted them does not. The skin is the surface nodes then.
    pub skin_points: Option<u64>,
    /// Number of rods, where it is known: the server's database does not hold it.
    pub rods: Option<u64>,
    /// Substeps per frame of the exact twin.
    pub substeps: u32,
    /// Substeps per frame of its fast variant, if it has one.
    pub fast_substeps: Option<u32>,
    /// True if the twin names a capture of its own, in a frame of which rollouts may start.
    pub has_capture: bool,
}

impl TwinShape {
    /// Work of one instance over `frames` frames of one substep among surroundings that are as much
    /// work for each node as so many elements, in element substeps.
    pub(super) fn substep_work(&self, frames: u64, surroundings: u64) -> u128 {
        let elements = u128::from(self.nodes) * (1 + u128::from(surroundings))
            + u128::from(self.springs)
            + u128::from(self.triplets);
        u128::from(frames) * elements
    }

    /// Work of one instance as a worker counts it when it cuts a batch into slices, in element
    /// substeps.
    pub(super) fn slice_work(&self, fidelity: Fidelity, frames: u64) -> f64 {
        let elements =
            u128::from(self.nodes) + u128::from(self.springs) + 2 * u128::from(self.triplets);
        let substeps = self.substeps(fidelity);
        elements.max(1) as f64 * f64::from(substeps) * frames.max(1) as f64
    }

    /// Number of points of its skin, at most.
    pub(super) fn most_skin_points(&self) -> u64 {
        self.skin_points.unwrap_or(self.nodes)
    }

    /// Substeps per frame as fitted, or of the fast variant.
    pub(super) fn substeps(&self, fidelity: Fidelity) -> u32 {
        match fidelity {
            Fidelity::Fast => self.fast_substeps.unwrap_or(self.substeps),
            Fidelity::Exact | Fidelity::Unspecified => self.substeps,
        }
    }
}

//! Facts of a twin that requests are checked against.

use bendtwin_proto::v1::Fidelity;

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
    /// Shape of the planner's twin, if there is one.
    pub planner: Option<PlannerShape>,
    /// True if the twin names its capture, in a frame of which rollouts may start.
    pub has_capture: bool,
}

/// Size of a planner's twin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlannerShape {
    /// Number of nodes.
    pub nodes: u64,
    /// Number of springs.
    pub springs: u64,
    /// Number of triplets.
    pub triplets: u64,
    /// Substeps per frame.
    pub substeps: u32,
}

impl TwinShape {
    /// Work of one instance over `frames` frames of one substep, among surroundings that cost each
    /// node the work of `surroundings` elements; in element substeps.
    pub(super) fn substep_work(&self, fidelity: Fidelity, frames: u64, surroundings: u64) -> u128 {
        let [nodes, springs, triplets] = self.simulated(fidelity);
        u128::from(frames) * (nodes * (1 + u128::from(surroundings)) + springs + triplets)
    }

    /// Work of one instance as a worker counts it when it cuts a batch into slices, in element
    /// substeps.
    pub(super) fn slice_work(&self, fidelity: Fidelity, frames: u64) -> f64 {
        let [nodes, springs, triplets] = self.simulated(fidelity);
        let elements = nodes + springs + 2 * triplets;
        let substeps = self.substeps(fidelity);
        elements.max(1) as f64 * f64::from(substeps) * frames.max(1) as f64
    }

    /// Nodes, springs and triplets that are simulated.
    fn simulated(&self, fidelity: Fidelity) -> [u128; 3] {
        let of_planner = self.planner.filter(|_| fidelity == Fidelity::Planner);
        let own = [self.nodes, self.springs, self.triplets];
        of_planner.map_or(own, |p| [p.nodes, p.springs, p.triplets]).map(u128::from)
    }

    /// Springs, triplets and rods of the model that is simulated, at most: a planner's twin is smaller than
    /// its twin, but a file's may have more of them.
    pub(super) fn most_elements(&self, fidelity: Fidelity) -> u64 {
        let of_planner = self.planner.filter(|_| fidelity == Fidelity::Planner);
        let (springs, triplets) = of_planner.map_or((0, 0), |p| (p.springs, p.triplets));
        let all = [self.springs.max(springs), self.triplets.max(triplets), self.rods.unwrap_or(0)];
        all.into_iter().fold(0, u64::saturating_add)
    }

    /// Number of points of its skin, at most.
    pub(super) fn most_skin_points(&self) -> u64 {
        self.skin_points.unwrap_or(self.nodes)
    }

    /// Substeps per frame as fitted, or of the fast variant or the planner's twin.
    pub(super) fn substeps(&self, fidelity: Fidelity) -> u32 {
        let other = match fidelity {
            Fidelity::Fast => self.fast_substeps,
            Fidelity::Planner => self.planner.map(|planner| planner.substeps),
            Fidelity::Exact | Fidelity::Unspecified => None,
        };
        other.unwrap_or(self.substeps)
    }
}

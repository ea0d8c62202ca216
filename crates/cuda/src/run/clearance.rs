//! Arrays of contact of the skin: the distances at which nodes touch surfaces in a frame.

use bendtwin_engine::{Error, backend::Instance};

use crate::{
    device::{
        args::{ClearanceAdjointArgs, FindClearancesArgs, InstanceArgs},
        kernels,
        launch::Launch,
        memory::{Buffer, end_of},
        queue::Queue,
    },
    plan::resident::has_skin_contact,
    run::group::InstanceSpan,
};
use cudarc::driver::CudaStream;

/// Size of an instance's clearances; zero without contact of the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ClearanceSize {
    /// Nodes by ground and colliders.
    entries: usize,
    /// Points of the skin.
    points: usize,
}

impl ClearanceSize {
    pub(crate) fn of(instance: &Instance) -> Self {
        let model = instance.model.model();
        if !has_skin_contact(model) {
            return Self::default();
        }
        let rows = 1 + instance.world.colliders.len();
        Self { entries: rows * model.graph.node_count(), points: model.skin.len() }
    }

    /// Bytes that they take, with their adjoint where that is asked for.
    pub(crate) fn bytes(self, adjoint: bool) -> u64 {
        let an_entry = if adjoint { 28 } else { 8 };
        (an_entry * self.entries + 12 * self.points) as u64
    }
}

/// Clearances of simulations that run concurrently.
pub(crate) struct Clearances {
    distances: Buffer<f32>,
    points: Buffer<u32>,
    /// Empty where no adjoint is asked for, as `by_points`.
    bars: Buffer<f32>,
    by_points: Buffer<[f32; 4]>,
    places: Buffer<f32>,
    /// First entry and first point of each.
    starts: Vec<usize>,
    point_starts: Vec<usize>,
}

impl Clearances {
    /// Clearances of simulations of these sizes.
    pub(crate) fn new(
        queue: &Queue,
        sizes: impl Iterator<Item = ClearanceSize>,
        adjoint: bool,
    ) -> Result<Self, Error> {
        let (mut starts, mut point_starts) = (vec![0], vec![0]);
        for size in sizes {
            starts.push(end_of(&starts) + size.entries);
            point_starts.push(end_of(&point_starts) + size.points);
        }
        let (entries, stream) = (end_of(&starts), &queue.stream);
        let of_adjoint = if adjoint { entries } else { 0 };
        Ok(Self {
            distances: Buffer::empty(stream, entries)?,
            points: Buffer::empty(stream, entries)?,
            bars: Buffer::zeros(stream, of_adjoint)?,
            by_points: Buffer::empty(stream, of_adjoint)?,
            places: Buffer::empty(stream, 3 * end_of(&point_starts))?,
            starts,
            point_starts,
        })
    }

    /// Gives an instance the arrays of one of the simulations.
    pub(crate) fn place(&self, index: usize, args: &mut InstanceArgs) {
        let at = self.starts[index];
        args.clearance.distances = self.distances.at(at);
        args.clearance.points = self.points.at(at);
        args.clearance.places = self.places.at(3 * self.point_starts[index]);
        if self.bars.len() > 0 {
            args.clearance.bars = self.bars.at(at);
            args.clearance.by_points = self.by_points.at(at);
        }
    }
}

/// Finds the clearances of a frame of instances that have them.
pub(crate) fn find_clearances(
    queue: &Queue,
    stream: &CudaStream,
    of: InstanceSpan,
    frame: u32,
) -> Result<(), Error> {
    let args = FindClearancesArgs { instances: of.address, frame, pad: 0 };
    let launch = Launch::new(&queue.device, stream, [of.count as u32, 1, 1]);
    // SAFETY: the instances have arrays for all nodes, surfaces and points, and the skin by node; the
    // kernel reads frames that exist.
    unsafe { kernels::find_clearances(&launch, &args) }
}

/// Passes d loss / d the clearances of a frame on to the state that it begins in.
pub(crate) fn clearance_adjoint(
    queue: &Queue,
    stream: &CudaStream,
    of: InstanceSpan,
) -> Result<(), Error> {
    let args = ClearanceAdjointArgs { instances: of.address };
    let launch = Launch::new(&queue.device, stream, [of.count as u32, 1, 1]);
    // SAFETY: as above, with arrays of their adjoint.
    unsafe { kernels::clearance_adjoint(&launch, &args) }
}

//! Derivatives by what surrounds an object: sums of windows, and where those of poses and rolls go.

use std::sync::Arc;

use bendtwin_engine::Error;
use cudarc::driver::CudaStream;

use super::Backward;
use crate::{
    device::{
        args::{CollectMotionArgs, Pointer},
        kernels,
        memory::{Buffer, end_of},
        queue::Queue,
        specialization::WorldParts,
    },
    run::group::{Group, InstanceSpan},
};

/// Entries of the poses at the two ends of a frame.
const POSE_ENTRIES: usize = 24;

/// Sums of windows that one kernel takes backward.
pub(super) struct WorldBars {
    _hold_sums: Buffer<f32>,
    _body_sums: Buffer<f32>,
    _roll_sums: Buffer<f32>,
    /// d loss / d places by window.
    pub(super) places: Buffer<[f32; 4]>,
    pub(super) place_starts: Vec<usize>,
    _arrivals: Buffer<[f32; 4]>,
}

/// Bytes of a window's.
pub(super) fn bytes_of(nodes: usize, bodies: usize, rods: usize) -> usize {
    nodes * (36 + 32 + 4 * POSE_ENTRIES * bodies) + 4 * rods
}

impl WorldBars {
    /// Motion of a group's windows, which get their addresses; `None` without surroundings.
    pub(super) fn new(stream: &Arc<CudaStream>, group: &mut Group) -> Result<Option<Self>, Error> {
        let world = group.plan.specialization.world;
        let still = WorldParts { smooth: world.smooth, ..WorldParts::default() };
        if world == still {
            return Ok(None);
        }
        let (mut nodes, mut bodies, mut rods) = (vec![0], vec![0], vec![0]);
        for args in group.instances() {
            let n = args.topology.node_count as usize;
            nodes.push(end_of(&nodes) + n);
            let entries = POSE_ENTRIES * args.world.body_count as usize;
            bodies.push(end_of(&bodies) + entries * n);
            rods.push(end_of(&rods) + args.topology.rod_count as usize);
        }
        let hold_sums = Buffer::zeros(stream, 9 * end_of(&nodes))?;
        let body_sums = Buffer::zeros(stream, end_of(&bodies))?;
        let roll_sums = Buffer::zeros(stream, end_of(&rods))?;
        let places = Buffer::zeros(stream, end_of(&nodes))?;
        let arrivals = Buffer::zeros(stream, end_of(&nodes))?;
        for (k, (_, args)) in group.members_mut().enumerate() {
            args.world.hold_sums = hold_sums.at(9 * nodes[k]);
            args.world.body_sums = body_sums.at(bodies[k]);
            args.world.roll_sums = roll_sums.at(rods[k]);
            args.world.place_bars = places.at(nodes[k]);
            args.world.arrive_bars = arrivals.at(nodes[k]);
        }
        Ok(Some(Self {
            _hold_sums: hold_sums,
            _body_sums: body_sums,
            _roll_sums: roll_sums,
            places,
            place_starts: nodes,
            _arrivals: arrivals,
        }))
    }
}

/// Outputs for d loss / d poses and rolls, of some windows.
pub(super) struct MotionOuts {
    poses: Option<Buffer<Pointer<f32>>>,
    rolls: Option<Buffer<Pointer<f32>>>,
}

impl MotionOuts {
    /// Outputs of the windows of these instances.
    pub(super) fn new(backward: &Backward<'_>, instances: &[usize]) -> Result<Self, Error> {
        if !backward.request.motion {
            return Ok(Self { poses: None, rolls: None });
        }
        let (out, stream) = (backward.out, &backward.forward.simulation.queue.stream);
        let at = |starts: &[usize], of: &Buffer<f32>| {
            let addresses: Vec<_> = instances.iter().map(|&i| of.at(starts[i])).collect();
            Buffer::of(stream, &addresses)
        };
        Ok(Self {
            poses: Some(at(&out.pose_starts, &out.poses)?),
            rolls: Some(at(&out.roll_starts, &out.rolls)?),
        })
    }

    /// Adds what has come together in a frame of some instances, of which `first` is the first here.
    pub(super) fn collect(
        &self,
        queue: &Queue,
        of: InstanceSpan,
        first: usize,
        starts: bool,
    ) -> Result<(), Error> {
        let at = |outs: &Option<Buffer<Pointer<f32>>>| {
            outs.as_ref().map_or_else(Pointer::default, |o| o.at(first))
        };
        let args = CollectMotionArgs {
            instances: of.address,
            poses: at(&self.poses),
            rolls: at(&self.rolls),
            starts: u32::from(starts),
            pad: 0,
        };
        // SAFETY: the instances have their sums and the outputs a row for every boundary.
        unsafe { kernels::collect_motion(&queue.grid(of.count as u32, 1, 1), &args) }
    }
}

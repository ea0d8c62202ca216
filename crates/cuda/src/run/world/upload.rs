//! The constant parts of surroundings as kernels have them. Instances of a batch often share them:
//! each is uploaded once.

use std::{collections::HashMap, sync::Arc};

use bendtwin_engine::{
    Error,
    backend::Instance,
    world::{self, Attachment, Motion, Phase, Region, Shape, World},
};
use cudarc::driver::CudaStream;

use super::controls_of;
use crate::device::{
    args::{self, WorldArgs},
    memory::Buffer,
    specialization::WorldParts,
};

/// No body: the world itself.
const NO_BODY: u32 = u32::MAX;

/// Surroundings of the instances of a batch, and their motion.
pub(super) struct Parts {
    poses: Buffer<[f32; 4]>,
    closed: Buffer<u32>,
    rolls: Buffer<f32>,
    colliders: Buffer<args::Collider>,
    faces: Buffer<[f32; 4]>,
    grasps: Buffer<args::Grasp>,
    members: Buffer<u32>,
    grasp_of: Buffer<i32>,
    places: Vec<Place>,
}

/// Starts of the parts of an instance.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    world: WorldPlace,
    motion: MotionPlace,
    has_rolls: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct WorldPlace {
    colliders: usize,
    grasps: usize,
    /// `None` if all control points always hold.
    grasp_of: Option<usize>,
}

#[derive(Clone, Copy, Debug, Default)]
struct MotionPlace {
    poses: usize,
    closed: usize,
    rolls: usize,
}

/// The parts on the host.
#[derive(Default)]
struct HostParts {
    poses: Vec<[f32; 4]>,
    closed: Vec<u32>,
    rolls: Vec<f32>,
    colliders: Vec<args::Collider>,
    faces: Vec<[f32; 4]>,
    grasps: Vec<args::Grasp>,
    members: Vec<u32>,
    grasp_of: Vec<i32>,
}

impl Parts {
    pub(super) fn new(
        stream: &Arc<CudaStream>,
        instances: &[Instance],
        parts: &[WorldParts],
    ) -> Result<Self, Error> {
        let mut all = HostParts::default();
        let mut worlds: HashMap<(*const World, usize), WorldPlace> = HashMap::new();
        let mut motions: HashMap<*const Motion, MotionPlace> = HashMap::new();
        let mut places = Vec::with_capacity(instances.len());
        for (instance, parts) in instances.iter().zip(parts) {
            if *parts == WorldParts::default() {
                places.push(Place::default());
                continue;
            }
            let controls = instance.model.model().graph.control_count();
            let world = *worlds
                .entry((Arc::as_ptr(&instance.world), controls))
                .or_insert_with(|| all.add_world(&instance.world, controls));
            let motion = *motions
                .entry(Arc::as_ptr(&instance.motion))
                .or_insert_with(|| all.add_motion(&instance.motion));
            places.push(Place { world, motion, has_rolls: parts.rolls });
        }
        Ok(Self {
            poses: Buffer::of(stream, &all.poses)?,
            closed: Buffer::of(stream, &all.closed)?,
            rolls: Buffer::of(stream, &all.rolls)?,
            colliders: Buffer::of(stream, &all.colliders)?,
            faces: Buffer::of(stream, &all.faces)?,
            grasps: Buffer::of(stream, &all.grasps)?,
            members: Buffer::of(stream, &all.members)?,
            grasp_of: Buffer::of(stream, &all.grasp_of)?,
            places,
        })
    }

    /// Addresses of an instance's parts.
    pub(super) fn args(&self, index: usize) -> WorldArgs {
        let Place { world, motion, has_rolls } = self.places[index];
        let mut args = WorldArgs {
            poses: self.poses.at(motion.poses),
            colliders: self.colliders.at(world.colliders),
            faces: self.faces.address(),
            grasps: self.grasps.at(world.grasps),
            members: self.members.address(),
            closed: self.closed.at(motion.closed),
            ..WorldArgs::default()
        };
        if let Some(at) = world.grasp_of {
            args.grasp_of = self.grasp_of.at(at);
        }
        if has_rolls {
            args.rolls = self.rolls.at(motion.rolls);
        }
        args
    }
}

impl HostParts {
    fn add_world(&mut self, world: &World, controls: usize) -> WorldPlace {
        let mut place = WorldPlace {
            colliders: self.colliders.len(),
            grasps: self.grasps.len(),
            grasp_of: None,
        };
        for collider in &world.colliders {
            self.add_collider(collider);
        }
        for grasp in &world.grasps {
            self.add_grasp(grasp);
        }
        if world.grasps.iter().any(|g| controls_of(&g.region).is_some()) {
            let first = self.grasp_of.len();
            self.grasp_of.resize(first + controls, -1);
            for (g, grasp) in world.grasps.iter().enumerate() {
                for &c in controls_of(&grasp.region).unwrap_or_default() {
                    if let Some(of) = self.grasp_of.get_mut(first + c as usize) {
                        *of = g as i32;
                    }
                }
            }
            place.grasp_of = Some(first);
        }
        place
    }

    fn add_collider(&mut self, collider: &world::Collider) {
        let mut made = args::Collider {
            friction: collider.friction,
            restitution: collider.restitution,
            body: collider.body.unwrap_or(NO_BODY),
            face: self.faces.len() as u32,
            ..args::Collider::default()
        };
        match &collider.shape {
            Shape::Capsule { from, to, radius_m } => {
                made.from = *from;
                made.axis = std::array::from_fn(|k| to[k] - from[k]);
                made.radius = *radius_m;
            }
            Shape::Convex(faces) => {
                let packed = |f: &world::Face| [f.normal[0], f.normal[1], f.normal[2], f.offset_m];
                self.faces.extend(faces.iter().map(packed));
                made.faces = faces.len() as u32;
            }
        }
        self.colliders.push(made);
    }

    fn add_grasp(&mut self, grasp: &world::Grasp) {
        let mut made = args::Grasp {
            body: grasp.body,
            member: self.members.len() as u32,
            max_force: grasp.max_force,
            ..args::Grasp::default()
        };
        match &grasp.region {
            Region::Sphere { center, radius_m } => {
                (made.region, made.low, made.high) = (0, *center, [*radius_m; 3]);
            }
            Region::Box { low, high } => {
                (made.region, made.low, made.high) = (1, *low, *high);
            }
            Region::Nodes(nodes) => {
                made.region = 2;
                let mut nodes: Vec<u32> = nodes.to_vec();
                nodes.sort_unstable();
                made.members = nodes.len() as u32;
                self.members.extend(nodes);
            }
            Region::Controls(_) => made.region = 3,
        }
        if let Attachment::Spring { stiffness, damping } = grasp.attachment {
            (made.attachment, made.stiffness, made.damping) = (1, stiffness, damping);
        }
        self.grasps.push(made);
    }

    fn add_motion(&mut self, motion: &Motion) -> MotionPlace {
        let place = MotionPlace {
            poses: self.poses.len(),
            closed: self.closed.len(),
            rolls: self.rolls.len(),
        };
        self.poses.extend(motion.poses.as_flattened());
        self.closed.extend(motion.closed.iter().map(|&c| u32::from(c)));
        self.rolls.extend(&motion.rolls);
        place
    }
}

/// A phase's number in the kernels.
pub(super) fn encode_phase(phase: Phase) -> u32 {
    phase as u32
}

/// Phases that an instance's grasps begin with.
pub(super) fn initial_phases(instance: &Instance) -> Vec<u32> {
    let given = &instance.initial.grasping.phases;
    let default = |g: &world::Grasp| match g.region {
        Region::Controls(_) => Phase::Closed,
        _ => Phase::Open,
    };
    let grasps = instance.world.grasps.iter().enumerate();
    grasps.map(|(g, grasp)| encode_phase(given.get(g).copied().unwrap_or(default(grasp)))).collect()
}

/// Holder of each node of an instance at its start.
pub(super) fn initial_holds(instance: &Instance) -> Vec<args::Hold> {
    let nothing = args::Hold { place: [0.0; 3], grasp: -1 };
    let mut holds = vec![nothing; instance.model.model().graph.node_count()];
    for hold in &instance.initial.grasping.holds {
        if let Some(of) = holds.get_mut(hold.node as usize) {
            *of = args::Hold { place: hold.place, grasp: hold.grasp as i32 };
        }
    }
    holds
}

//! A model on the device: its graph and skin, shared by all parameters on them, and its parameters, packed for
//! each shape of launch that has asked for them.

use std::sync::Arc;

use bendtwin_core::{Params, environment::ControlVelocity};
use bendtwin_engine::{Error, Loaded, Model};

use crate::{
    device::{
        Device,
        args::{
            ContactArgs, Ground, InstanceArgs, Law, PackBendsArgs, PackHalfSpringsArgs,
            ParameterArgs, StepArgs, TapeArgs,
        },
        kernels,
        launch::Launch,
        memo::Memo,
        memory::Buffer,
        specialization::THREADS,
    },
    plan::{
        choice::Shapes,
        graph::{CutGraph, DeviceGraph},
        layouts::Cut,
        skin::DeviceSkin,
    },
};

/// Numbers behind the arrays of elements: drag, and restitution and friction of ground and objects.
pub(crate) const LAWS: usize = 5;

/// A loaded model.
pub(crate) struct Resident {
    pub(crate) device: Arc<Device>,
    pub(crate) graph: Arc<DeviceGraph>,
    pub(crate) skin: Arc<DeviceSkin>,
    /// Stiffness, dashpot, rest length [E each]; bend stiffness, bend damping, rest angle [T each];
    /// twist stiffness, twist damping, rest twist [R each]; [`LAWS`] more.
    pub(crate) params: Buffer<f32>,
    /// The dashpot of all springs, if it is the same: then it is not loaded per spring.
    pub(crate) dashpot: Option<f32>,
    packed: Memo<Cut, Arc<Packed>>,
}

/// Parameters as one shape of launch wants them.
pub(crate) struct Packed {
    pub(crate) cut: Arc<CutGraph>,
    rates: Buffer<[f32; 4]>,
    others: Buffer<u32>,
    dashpots: Buffer<[f32; 2]>,
    bends: Buffer<[f32; 4]>,
}

impl Resident {
    pub(crate) fn new(
        device: &Arc<Device>,
        graph: Arc<DeviceGraph>,
        skin: Arc<DeviceSkin>,
        params: &Params,
    ) -> Result<Self, Error> {
        let first = params.spring_dashpot.first().copied().unwrap_or_default();
        let alike = params.spring_dashpot.iter().all(|&d| d == first);
        Ok(Self {
            params: Buffer::of(&device.normal, &flatten(params))?,
            dashpot: alike.then_some(first),
            device: device.clone(),
            graph,
            skin,
            packed: Memo::default(),
        })
    }

    /// The model with other parameters.
    pub(crate) fn with_params(&self, params: &Params) -> Result<Self, Error> {
        Self::new(&self.device, self.graph.clone(), self.skin.clone(), params)
    }

    /// The model, prepared for parameters that change on the device.
    pub(crate) fn varying(self) -> Self {
        Self { dashpot: None, ..self }
    }

    /// Inputs to the choice of a team.
    pub(crate) fn shapes(&self) -> Shapes<'_> {
        Shapes {
            layouts: &self.graph.layouts,
            uniform_dashpot: self.dashpot.is_some(),
            team: self.device.team,
        }
    }

    /// Packed for a cut; made at first use, on the stream that fits and loads use.
    pub(crate) fn packed(&self, cut: Cut) -> Result<Arc<Packed>, Error> {
        self.packed.get_or_make(cut, || Ok(Arc::new(self.pack(cut)?)))
    }

    fn pack(&self, cut: Cut) -> Result<Packed, Error> {
        let stream = &self.device.normal;
        let cut = self.graph.cut(&self.device, cut)?;
        let pairs = cut.springs.len() / 2;
        let rates = Buffer::empty(stream, pairs)?;
        let others = Buffer::empty(stream, pairs)?;
        let dashpots = Buffer::empty(stream, pairs)?;
        let bends = Buffer::empty(stream, cut.triplet_of.len())?;
        let packed = Packed { cut, rates, others, dashpots, bends };
        self.fill(&packed)?;
        crate::device::synchronize(stream)?;
        Ok(packed)
    }

    fn fill(&self, packed: &Packed) -> Result<(), Error> {
        let (device, cut) = (&self.device, &packed.cut);
        let graph = &self.graph.graph;
        let (spring_count, triplet_count) =
            (graph.springs.len() as u32, graph.triplets.len() as u32);
        let (pairs, triplets) = (packed.rates.len() as u32, cut.triplet_of.len() as u32);
        let args = PackHalfSpringsArgs {
            rates: packed.rates.address(),
            packed_others: packed.others.address(),
            dashpots: packed.dashpots.address(),
            springs: cut.springs.address(),
            others: cut.others.address(),
            params: self.params.address(),
            pair_count: pairs,
            spring_count,
        };
        let launch = Launch::new(device, &device.normal, [pairs.div_ceil(THREADS), 1, 1]);
        // SAFETY: outputs and indices have the launched number of pairs, parameters are laid out
        // for E springs.
        unsafe { kernels::pack_half_springs(&launch, &args)? };
        let args = PackBendsArgs {
            out: packed.bends.address(),
            triplets: cut.triplet_of.address(),
            params: self.params.address(),
            count: triplets,
            spring_count,
            triplet_count,
            pad: 0,
        };
        let launch = Launch::new(device, &device.normal, [triplets.div_ceil(THREADS), 1, 1]);
        // SAFETY: as above, for T triplets.
        unsafe { kernels::pack_bends(&launch, &args) }
    }

    /// Packs the half-springs again, after the parameters on the device have changed.
    pub(crate) fn repack(&self) -> Result<(), Error> {
        self.packed.values().iter().try_for_each(|p| self.fill(p))
    }
}

impl Packed {
    /// The arguments of a model's instance, without those that depend on the instance.
    pub(crate) fn instance_args(&self, model: &Model) -> InstanceArgs {
        let (contact, drag) = (&model.params.contact, f64::from(model.params.drag));
        let dt = model.timing.dt_s();
        let gravity = model.environment.gravity;
        let ground = model.environment.ground;
        InstanceArgs {
            topology: self.cut.topology,
            parameters: ParameterArgs {
                rates: self.rates.address(),
                others: self.others.address(),
                dashpots: self.dashpots.address(),
                bends: self.bends.address(),
                ground_law: Law {
                    restitution: contact.ground_restitution,
                    friction: contact.ground_friction,
                },
                object_law: Law {
                    restitution: contact.object_restitution,
                    friction: contact.object_friction,
                },
                decay: (-dt * drag).exp() as f32,
                ..ParameterArgs::default()
            },
            step: StepArgs {
                kick: gravity.map(|g| g * dt as f32),
                ground: ground.map_or_else(Ground::default, |g| Ground {
                    normal: g.normal,
                    offset: g.offset_m,
                }),
                dt: dt as f32,
                frame_s: model.timing.frame_s() as f32,
                substeps: model.timing.substeps,
                controls_move: u32::from(model.control_velocity == ControlVelocity::True),
                pad: 0,
            },
            tape: TapeArgs { slot_of: self.cut.tape_slots.address(), ..TapeArgs::default() },
            contact: ContactArgs {
                collision_distance: contact.collision_distance_m,
                between_objects: u32::from(contact.between_objects),
                within_object: u32::from(contact.within_object),
                ..ContactArgs::default()
            },
            ..InstanceArgs::default()
        }
    }
}

/// True if nodes of a model can collide with each other.
pub(crate) fn has_contact(model: &Model) -> bool {
    let contact = &model.params.contact;
    let several = || model.graph.object_ids.windows(2).any(|w| w[0] != w[1]);
    contact.collision_distance_m > 0.0
        && (contact.within_object || (contact.between_objects && several()))
}

/// True if ground and colliders meet the skin of a model.
pub(crate) fn has_skin_contact(model: &Model) -> bool {
    model.params.contact.skin && !model.skin.is_empty()
}

/// Parameters in the kernels' order.
pub(crate) fn flatten(p: &Params) -> Vec<f32> {
    let c = &p.contact;
    let laws =
        [p.drag, c.ground_restitution, c.ground_friction, c.object_restitution, c.object_friction];
    let arrays = [
        &p.spring_stiffness,
        &p.spring_dashpot,
        &p.rest_lengths_m,
        &p.bend_stiffness,
        &p.bend_damping,
        &p.rest_angles_rad,
        &p.twist_stiffness,
        &p.twist_damping,
        &p.rest_twists_rad,
    ];
    let mut all = arrays.map(Vec::as_slice).concat();
    all.extend(laws);
    all
}

/// This backend's copy of a model.
pub(crate) fn resident(loaded: &Loaded) -> Result<&Resident, Error> {
    loaded.resident().ok_or_else(|| {
        Error::InvalidInput("the model was loaded by another backend: load it here".into())
    })
}

/// Parameters from the kernels' order; NaN is replaced by the value in `base`.
pub(crate) fn unflatten(base: &Params, flat: &[f32]) -> Params {
    let mut rest = flat;
    let mut take = |count: usize| {
        let (own, more) = rest.split_at(count.min(rest.len()));
        rest = more;
        own.to_vec()
    };
    let (e, t) = (base.spring_stiffness.len(), base.bend_stiffness.len());
    let (spring_stiffness, spring_dashpot, rest_lengths_m) = (take(e), take(e), take(e));
    let (bend_stiffness, bend_damping, rest_angles_rad) = (take(t), take(t), take(t));
    let r = base.twist_stiffness.len();
    let (twist_stiffness, twist_damping, rest_twists_rad) = (take(r), take(r), take(r));
    let law = |k: usize| rest.get(k).copied().unwrap_or_default();
    Params {
        spring_stiffness,
        spring_dashpot,
        rest_lengths_m,
        bend_stiffness,
        bend_damping,
        rest_angles_rad,
        twist_stiffness,
        twist_damping,
        rest_twists_rad,
        drag: law(0),
        contact: bendtwin_core::Contact {
            ground_restitution: law(1),
            ground_friction: law(2),
            object_restitution: law(3),
            object_friction: law(4),
            ..base.contact
        },
    }
}

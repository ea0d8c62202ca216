//! The one coarse trait between the physics and everything that uses it: load a
//! model, roll out a batch, loss of a batch, loss and gradient of a batch.
//! Batch-first: one rollout is a batch of one. Instances of a batch may have
//! different graphs. Same input, build and device: bit-identical output.

use std::{any::Any, sync::Arc};

use bendtwin_core::{CancelToken, Environment, Params, Point, Problem};

use crate::{
    model::{Model, State},
    objective::Objective,
    optimizer::{Decay, Optimizer, OptimizerInit},
    world::{Motion, Pose, World},
};

/// An error of a backend: a refusal or a failure.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Problem)]
pub enum Error {
    /// The model contradicts itself.
    #[error("the model is inconsistent: {0}")]
    #[problem(InvalidArgument, "INVALID_MODEL")]
    InvalidModel(String),
    /// The input does not fit the model.
    #[error("the rollout's input is wrong: {0}")]
    #[problem(InvalidArgument, "INVALID_ROLLOUT_INPUT")]
    InvalidInput(String),
    /// The substep is longer than the stability estimate allows.
    #[error(
        "{substeps} substeps a frame are too few for this model: it is stable from {needed} \
         (stiffest node {node}); raise the substeps or lower the stiffness there"
    )]
    #[problem(InvalidArgument, "TOO_FEW_SUBSTEPS")]
    Unstable {
        /// Substeps asked for.
        substeps: u32,
        /// Fewest stable substeps.
        needed: u32,
        /// Node with the largest share in the stiffest mode.
        node: usize,
    },
    /// The device has too little memory.
    #[error(
        "the device has {available} bytes free, the model needs {needed}: use a coarser twin or a smaller batch"
    )]
    #[problem(ResourceExhausted, "DEVICE_OUT_OF_MEMORY")]
    OutOfMemory {
        /// Bytes needed.
        needed: u64,
        /// Bytes free.
        available: u64,
    },
    /// The work was cancelled through its token.
    #[error("cancelled")]
    #[problem(Cancelled, "CANCELLED")]
    Cancelled,
    /// The device failed.
    #[error("the compute device failed: {0}")]
    #[problem(Internal, "DEVICE_FAILED")]
    Device(String),
}

/// The frame and node at which a simulation diverged: left the finite numbers, or went farther than
/// 1 km from the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// Frame during which it happened, 1-based.
    pub frame: usize,
    /// First node concerned.
    pub node: usize,
}

/// A model on the device. Cheap to clone.
#[derive(Clone)]
pub struct Loaded {
    model: Arc<Model>,
    resident: Arc<dyn Any + Send + Sync>,
}

impl Loaded {
    /// A loaded model, from the model and the backend's own part of it.
    pub fn new(model: Arc<Model>, resident: Arc<dyn Any + Send + Sync>) -> Self {
        Self { model, resident }
    }
    /// The model as loaded.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }
    /// The backend's own part, to be shared with another model of the same graph and parameters.
    pub fn shared(&self) -> Arc<dyn Any + Send + Sync> {
        self.resident.clone()
    }
    /// The backend's own part, if it is of type `T`.
    pub fn resident<T: Any + Send + Sync>(&self) -> Option<&T> {
        self.resident.downcast_ref()
    }
}

impl std::fmt::Debug for Loaded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Loaded")
            .field("nodes", &self.model.graph.node_count())
            .finish_non_exhaustive()
    }
}

/// A simulation to run.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The loaded model.
    pub model: Loaded,
    /// State at the start; pinned nodes are moved onto their control points and take their
    /// velocity.
    pub initial: Arc<State>,
    /// Control point positions at frame boundaries [m], shape [F + 1, C, 3]; row 0 belongs to the
    /// initial state, F is the number of frames to simulate. With no control points, F comes from
    /// `frames`.
    pub controls: Arc<Vec<Point>>,
    /// Number of frames F to simulate.
    pub frames: usize,
    /// Terms to measure.
    pub objective: Objective,
    /// Surroundings of the object; empty for the ground alone.
    pub world: Arc<World>,
    /// Their motion.
    pub motion: Arc<Motion>,
}

/// The outputs that a rollout returns beside its costs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Record the positions of every k-th frame (frames k, 2k, ...); 0 records no frame.
    pub every: usize,
    /// Record frame 0 too.
    pub initial: bool,
    /// Nodes to record; `None` means all.
    pub nodes: Option<Arc<Vec<u32>>>,
    /// Return the final state.
    pub final_state: bool,
    /// The [`Diagnostics`] to compute.
    pub diagnose: Diagnose,
    /// Record velocities where positions are recorded: those of the states.
    pub velocities: bool,
    /// Record [`Forces`].
    pub forces: bool,
    /// Return the objective's values frame by frame.
    pub frame_costs: bool,
}

impl Outputs {
    /// Nothing beside the costs.
    pub const NONE: Self = Self {
        every: 0,
        initial: false,
        nodes: None,
        final_state: false,
        diagnose: Diagnose::Nothing,
        velocities: false,
        forces: false,
        frame_costs: false,
    };
}

/// The numbers of [`Diagnostics`] that a rollout computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagnose {
    /// No diagnostics are returned.
    #[default]
    Nothing,
    /// Strains and speeds alone; energies are NaN, and no node counts as being on the ground. They
    /// need no final state, which a device would have to send for.
    Extremes,
    /// All of them.
    All,
}

/// Forces on the object at unit node mass, each the mean over a frame [N], which is the impulse
/// divided by the frame's length. For pinned nodes it is the force that makes them follow their
/// prescribed motion, starting from the velocity in the initial state; an initial offset from their
/// places is not included. F is the number of frames recorded with `forces`: all of them,
/// regardless of [`Outputs::every`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// Forces from control points, shape [F, C, 3].
    pub controls: Vec<Point>,
    /// Forces from the grasps of the world, shape [F, G, 6]: force, then torque about the origin of
    /// the grasp's body in that body's pose at the end of the frame [N m], both along the world's
    /// axes.
    pub grasps: Vec<[f32; 6]>,
    /// Forces from the ground, shape [F, 3].
    pub ground: Vec<Point>,
    /// Forces from colliders, shape [F, K, 6], laid out like `grasps`; about the world's origin
    /// without a body.
    pub colliders: Vec<[f32; 6]>,
}

/// Physical plausibility of a rollout; of one that diverged, of the frames before that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// Largest |l/l0 - 1| of any spring between two nodes at any frame end.
    pub max_strain: f32,
    /// Largest strain of springs to control points; their rest lengths are short, so it may be
    /// large.
    pub max_control_strain: f32,
    /// Largest speed of a node at any frame end [m/s]; of the initial state if there is no frame.
    pub max_speed_m_s: f32,
    /// Kinetic energy at the end [J per unit mass scale]; NaN if it diverged.
    pub kinetic_energy: f32,
    /// Elastic energy at the end [J per unit mass scale]; NaN if it diverged.
    pub elastic_energy: f32,
    /// Nodes on the ground (less than 1 mm above it, they or with contact of the skin what they bear
    /// of that) at the end, or in the last frame before it diverged.
    pub ground_contacts: u32,
}

/// Result of one instance's rollout.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rollout {
    /// Frames that were recorded.
    pub frames: Vec<usize>,
    /// Recorded positions [m], shape [frames.len(), recorded nodes, 3].
    pub positions: Vec<Point>,
    /// Recorded velocities if asked for [m/s], as `positions`.
    pub velocities: Vec<Point>,
    /// Forces if asked for.
    pub forces: Option<Forces>,
    /// Weighted sums per frame and group if asked for, shape [F + 1, groups]; frame 0 is the initial
    /// state. Infinite from the frame of a divergence on.
    pub frame_costs: Vec<f64>,
    /// Weighted sum of the objective; infinite if it diverged.
    pub cost: f64,
    /// Weighted sums per group, shape [groups]; infinite if it diverged.
    pub group_costs: Vec<f64>,
    /// Final state if asked for.
    pub final_state: Option<State>,
    /// Diagnostics if asked for.
    pub diagnostics: Option<Diagnostics>,
    /// The divergence, if any; nothing is recorded from that frame on, diagnostics are of the frames
    /// before, and there is no final state.
    pub diverged: Option<Divergence>,
}

/// Loss of one instance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loss {
    /// Weighted sum of the objective; infinite if it diverged.
    pub total: f64,
    /// Weighted sums per group; infinite if it diverged.
    pub groups: Vec<f64>,
    /// The divergence, if any.
    pub diverged: Option<Divergence>,
}

/// The gradients to compute, and their reach back in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GradientRequest {
    /// Cut the gradient at every k-th frame boundary (0: never): the state's adjoint is zeroed
    /// there, as in PhysTwin with 1. The terms of a boundary's own frame count for the window that
    /// ends there; frame 0 is no boundary, so the first window's gradient reaches the initial
    /// state.
    pub cut_every: usize,
    /// Also return gradients with respect to the controls.
    pub controls: bool,
    /// Also return the gradient with respect to the initial state.
    pub initial: bool,
    /// Also return the state after the last frame (the next frame of a stepwise simulation starts
    /// there).
    pub final_state: bool,
    /// Also return gradients with respect to the poses and rolls of [`Motion`].
    pub motion: bool,
    /// Also return the norm of the gradient at every frame boundary.
    pub norms: bool,
}

impl GradientRequest {
    /// Gradients by parameters alone, over the whole rollout.
    pub const PARAMS: Self = Self {
        cut_every: 0,
        controls: false,
        initial: false,
        final_state: false,
        motion: false,
        norms: false,
    };
}

/// Loss and gradient of one instance. Gradients by controls, motion and initial state are NaN where
/// it diverged; those by parameters are zero there, so that a fit can add them up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// The loss.
    pub loss: Loss,
    /// d loss / d params, arrays and fields as in [`Params`] (contact switches and the collision
    /// distance, which has no derivative, stay at their defaults or zero). The occurrence and the
    /// partners of an impact, and the node nearest to a target, count as fixed; an impact's time
    /// and impulse are differentiated.
    pub params: Params,
    /// True if a component of `params` was not finite, or beyond f32; NaN is returned as zero then,
    /// and too large a number as the largest.
    pub overflowed: bool,
    /// d loss / d controls, shape [F + 1, C, 3]; empty if not asked for. Includes what reaches
    /// the loss through pinned nodes and through the controls' velocities.
    pub controls: Vec<Point>,
    /// d loss / d poses of bodies if asked for, shape [F + 1, B].
    pub poses: Vec<Pose>,
    /// d loss / d rolls if asked for, shape [F + 1, R, 2]; empty if the motion has none.
    pub rolls: Vec<f32>,
    /// Norm of d loss / d positions of all nodes at each frame boundary if requested [loss per m],
    /// shape [F + 1]; pinned nodes, whose positions are prescribed, count as zero. NaN if it
    /// diverged.
    pub norms: Vec<f64>,
    /// d loss / d initial state if asked for; zero for pinned nodes, which start on their control
    /// points. Of what grasps hold only the places have a gradient, in the holds of the initial
    /// state.
    pub initial: Option<State>,
    /// State after the last frame if asked for.
    pub final_state: Option<State>,
}

/// The device of a backend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// `cpu` or `cuda`.
    pub kind: String,
    /// Name of the device for people.
    pub name: String,
    /// Number of instances that run concurrently.
    pub lanes: usize,
}

/// Memory of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Bytes in use, by any process.
    pub used: u64,
    /// Bytes in all.
    pub total: u64,
}

/// An implementation of the physics on some device.
pub trait Backend: Send + Sync {
    /// The device that it runs on.
    fn device(&self) -> Device;

    /// Checks a model (indices, lengths, finiteness, stability of its substep) and makes it
    /// resident.
    ///
    /// # Errors
    /// If the model is inconsistent, unstable, or does not fit the device.
    fn load(&self, model: Arc<Model>) -> Result<Loaded, Error>;

    /// The same graph with other parameters: cheaper than loading it again.
    ///
    /// # Errors
    /// Those of [`Backend::load`], except that stability is not checked again.
    fn with_params(&self, loaded: &Loaded, params: Params) -> Result<Loaded, Error>;

    /// The same graph and parameters in another environment.
    ///
    /// # Errors
    /// If the environment is not finite, or the model is of another backend.
    fn with_environment(&self, loaded: &Loaded, environment: Environment) -> Result<Loaded, Error>;

    /// Simulates a batch. A diverging instance reports so in its own result.
    ///
    /// # Errors
    /// If an instance's input does not fit its model, on cancellation, or if the device fails.
    fn roll_out(
        &self,
        batch: &[Instance],
        outputs: &Outputs,
        cancel: &CancelToken,
    ) -> Result<Vec<Rollout>, Error>;

    /// Losses of a batch.
    ///
    /// # Errors
    /// Those of [`Backend::roll_out`].
    fn losses(&self, batch: &[Instance], cancel: &CancelToken) -> Result<Vec<Loss>, Error>;

    /// Losses and gradients of a batch.
    ///
    /// # Errors
    /// Those of [`Backend::roll_out`].
    fn gradients(
        &self,
        batch: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<Gradient>, Error>;

    /// An optimizer of several runs side by side; the models in `inits` were loaded by this
    /// backend.
    ///
    /// A backend whose device keeps no parameters and gradients returns a
    /// [`crate::optimizer::HostOptimizer`] over itself.
    ///
    /// # Errors
    /// Those of [`OptimizerInit::check`] and [`Backend::with_params`].
    fn optimizer(
        &self,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Box<dyn Optimizer>, Error>;

    /// Memory of the device; `None` where it is not known.
    fn memory(&self) -> Option<Memory> {
        None
    }

    /// A second queue onto the same device, for work that should go before this one's; it takes the
    /// models that this one loaded, and computes even while all work of this one is held at a check
    /// of its [`CancelToken`] ([`CancelToken::with_pause`]). `None` where the device has one queue: cut batches into slices there.
    fn urgent(&self) -> Option<Arc<dyn Backend>> {
        None
    }

    /// A description for reports of how a batch of this many instances of a model would run.
    fn plan(&self, model: &Loaded, batch: usize) -> Option<String> {
        let _ = (model, batch);
        None
    }
}

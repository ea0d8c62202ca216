//! Frames of a twin's own physics in a registration: control points and what is held stay, obstacles
//! stand where they are.

use std::sync::Arc;

use bendtwin_core::{CancelToken, geometry::point};
use bendtwin_engine::{
    Backend, Loaded, Motion, Objective, World,
    backend::{Instance, Outputs},
    model::State,
    world::{Attachment, Grasp, IDENTITY, Region},
};
use nalgebra::Vector3;

use super::RegisterOptions;
use crate::Error;

/// A model in the surroundings of a registration.
pub(super) struct Physics<'a> {
    backend: &'a dyn Backend,
    loaded: &'a Loaded,
    world: Arc<World>,
    motion: Arc<Motion>,
}

impl<'a> Physics<'a> {
    pub(super) fn new(
        backend: &'a dyn Backend,
        loaded: &'a Loaded,
        options: &RegisterOptions,
    ) -> Self {
        let mut world = World::default();
        let mut closed = Vec::new();
        let mut hold = |region, is_closed| {
            let (attachment, max_force) = (Attachment::Pin, f32::INFINITY);
            world.grasps.push(Grasp { body: 0, region, attachment, max_force });
            closed.push(is_closed);
        };
        if !options.around.loose.is_empty() {
            hold(Region::Controls(Arc::new(options.around.loose.clone())), false);
        }
        if !options.held.is_empty() {
            let mut nodes: Vec<u32> = options.held.iter().map(|(node, _)| *node).collect();
            nodes.sort_unstable();
            nodes.dedup();
            hold(Region::Nodes(Arc::new(nodes)), true);
        }
        // What holds is a body that stands still.
        world.bodies = usize::from(!world.grasps.is_empty());
        let obstacles = &options.around.obstacles;
        world.colliders = obstacles.iter().map(|o| o.collider.clone()).collect();
        let motion = Motion { poses: vec![IDENTITY; 2 * world.bodies], closed, rolls: Vec::new() };
        Self { backend, loaded, world: Arc::new(world), motion: Arc::new(motion) }
    }

    /// The state after a frame in which the control points stay.
    pub(super) fn frame(
        &self,
        state: &State,
        controls: &[Vector3<f64>],
        cancel: &CancelToken,
    ) -> Result<State, Error> {
        let both = controls.iter().chain(controls).map(|p| point(*p)).collect();
        let instance = Instance {
            model: self.loaded.clone(),
            initial: Arc::new(State { grasping: Default::default(), ..state.clone() }),
            controls: Arc::new(both),
            frames: 1,
            objective: Objective::default(),
            world: Arc::clone(&self.world),
            motion: Arc::clone(&self.motion),
        };
        let outputs = Outputs { final_state: true, ..Outputs::NONE };
        let rollout = self.backend.roll_out(&[instance], &outputs, cancel)?.into_iter().next();
        rollout.and_then(|r| r.final_state).ok_or_else(|| {
            Error::Invalid("the twin explodes in the shape of the points: raise noise_m".into())
        })
    }
}

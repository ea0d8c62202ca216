//! Starts of instances: the states that they were given, with pinned nodes on their control points.

use std::{collections::HashMap, sync::Arc};

use bendtwin_core::environment::ControlVelocity;
use bendtwin_engine::{Error, backend::Instance, model::State};
use cudarc::driver::CudaStream;

use crate::{
    device::{
        args::{InitialArgs, Pointer, StartArgs},
        kernels,
        launch::MOST_BLOCKS,
        memory::Buffer,
        specialization::THREADS,
    },
    plan::resident::resident,
    run::simulation::Simulation,
};

/// States that instances were given, on the device; they may share them.
pub(super) struct InitialStates {
    planes: Buffer<f32>,
    /// Beginnings of each instance's own, and of its twists.
    places: Vec<(usize, usize)>,
}

impl InitialStates {
    pub(super) fn new(stream: &Arc<CudaStream>, instances: &[Instance]) -> Result<Self, Error> {
        let each = instances.iter().map(|i| (&*i.initial, i.model.model().graph.rods.len()));
        let (planes, places) = initial_planes(each);
        Ok(Self { planes: Buffer::of(stream, &planes)?, places })
    }

    /// Address of an instance's, as planes.
    pub(super) fn of(&self, index: usize) -> Pointer<f32> {
        self.planes.at(self.places[index].0)
    }

    fn twists_of(&self, index: usize) -> Pointer<f32> {
        self.planes.at(self.places[index].1)
    }
}

/// Puts initial states to where each instance's first frame is.
pub(super) fn start(this: &Simulation<'_>) -> Result<(), Error> {
    let stream = &this.queue.stream;
    let mut starts = Vec::with_capacity(this.instances.len());
    for (i, instance) in this.instances.iter().enumerate() {
        let model = instance.model.model();
        let moves = model.control_velocity == ControlVelocity::True && instance.frames > 0;
        let (pin_of, pins) = resident(&instance.model)?.graph.pins();
        starts.push(InitialArgs {
            initial: this.initial.of(i),
            initial_twists: this.initial.twists_of(i),
            twists: this.twists_of(i),
            rod_count: model.graph.rods.len() as u32,
            states: this.states_of(i),
            controls: this.controls_of(i),
            pin_of,
            pins,
            frame_s: model.timing.frame_s() as f32,
            node_count: model.graph.node_count() as u32,
            control_count: model.graph.control_count() as u32,
            controls_move: u32::from(moves),
            frame_count: instance.frames as u32,
            world: this.worlds.args(i),
        });
    }
    let most = starts.iter().map(|s| s.node_count).max().unwrap_or(0);
    let on_device = Buffer::of(stream, &starts)?;
    for first in (0..starts.len()).step_by(MOST_BLOCKS) {
        let count = MOST_BLOCKS.min(starts.len() - first) as u32;
        let args = StartArgs { instances: on_device.at(first) };
        let launch = this.queue.grid(most.div_ceil(THREADS), count, 1);
        // SAFETY: every start has its instance's nodes, controls of its first frames, and room for
        // its states.
        unsafe { kernels::start(&launch, &args)? };
    }
    Ok(())
}

/// States as planes, each state followed by its twists, and where both of each instance's begin.
/// Instances may share a state though their models have different numbers of rods: it is stored
/// once for each number.
fn initial_planes<'a>(
    initial: impl Iterator<Item = (&'a State, usize)>,
) -> (Vec<f32>, Vec<(usize, usize)>) {
    let mut known: HashMap<(*const State, usize), (usize, usize)> = HashMap::new();
    let mut planes: Vec<f32> = Vec::new();
    let mut place = |(state, rods): (&'a State, usize)| {
        *known.entry((std::ptr::from_ref(state), rods)).or_insert_with(|| {
            let at = planes.len();
            let State { positions, velocities, twists, .. } = state;
            for points in [positions, velocities] {
                (0..3).for_each(|k| planes.extend(points.iter().map(|p| p[k])));
            }
            let twists_at = planes.len();
            planes.extend((0..rods).map(|r| twists.get(r).copied().unwrap_or(0.0)));
            (at, twists_at)
        })
    };
    let places = initial.map(&mut place).collect();
    (planes, places)
}

#[cfg(test)]
mod tests;

//! Gradients of a batch on the host: fetched from the device, and cut into those of its instances.

use bendtwin_core::{Params, graph::Pin};
use bendtwin_engine::{
    Error, Model,
    backend::{Gradient, GradientRequest, Instance, Loss},
    model::State,
};

use crate::{
    device::queue::Queue,
    plan::resident::unflatten,
    run::{backward::Gradients, world},
};

/// Gradients of a batch, fetched; those of the initial state are empty unless asked for.
pub(super) struct FetchedGradients<'a> {
    of: &'a Gradients,
    request: &'a GradientRequest,
    params: Vec<f32>,
    controls: Vec<[f32; 3]>,
    initial: Vec<[f32; 4]>,
    initial_twists: Vec<f32>,
    poses: Vec<f32>,
    rolls: Vec<f32>,
    places: Vec<[f32; 4]>,
    norms: Vec<f64>,
}

impl<'a> FetchedGradients<'a> {
    pub(super) fn new(
        queue: &Queue,
        of: &'a Gradients,
        request: &'a GradientRequest,
    ) -> Result<Self, Error> {
        let needs_start = request.initial || request.controls;
        Ok(Self {
            of,
            request,
            params: queue.fetch(&of.params)?,
            controls: queue.fetch(&of.controls)?,
            initial: if needs_start { queue.fetch(&of.initial)? } else { Vec::new() },
            initial_twists: if request.initial {
                queue.fetch(&of.initial_twists)?
            } else {
                Vec::new()
            },
            poses: queue.fetch(&of.poses)?,
            rolls: queue.fetch(&of.rolls)?,
            places: if request.initial { queue.fetch(&of.places)? } else { Vec::new() },
            norms: queue.fetch(&of.norms)?,
        })
    }

    /// The gradient of the i-th instance.
    pub(super) fn gradient(
        &self,
        i: usize,
        instance: &Instance,
        loss: Loss,
        final_state: Option<State>,
    ) -> Gradient {
        let (of, model) = (self.of, instance.model.model());
        let ended = loss.diverged.is_none();
        // Where it diverged nothing was differentiated, and zero would say that nothing matters.
        let motion = |x: &f32| if ended { narrow(*x) } else { f32::NAN };
        let own = &self.params[of.starts[i]..of.starts[i + 1]];
        let flat: Vec<f32> = own.iter().map(|x| if ended { narrow(*x) } else { 0.0 }).collect();
        let span = of.control_starts[i]..of.control_starts[i + 1];
        let mut paths: Vec<[f32; 3]> =
            self.controls[span].iter().map(|p| p.map(|x| of_ended(ended, x))).collect();
        let mut at_start = self.at_start(i, instance, ended);
        // Pinned nodes start on their control points.
        let is_held = |pin: &&Pin| ended && !world::begins_released(instance, pin.control);
        for pin in model.graph.pins.iter().filter(is_held) {
            let x = std::mem::take(&mut at_start.positions[pin.node as usize]);
            if let Some(path) = paths.get_mut(pin.control as usize) {
                (0..3).for_each(|k| path[k] += x[k]);
            }
        }
        let mut norms = self.norms[of.norm_starts[i]..of.norm_starts[i + 1]].to_vec();
        if !ended {
            norms.fill(f64::NAN);
        }
        let poses = &self.poses[of.pose_starts[i]..of.pose_starts[i + 1]];
        let poses: Vec<f32> = poses.iter().map(motion).collect();
        let rows =
            |rows: &[f32; 12]| std::array::from_fn(|r| std::array::from_fn(|c| rows[4 * r + c]));
        let rolls = &self.rolls[of.roll_starts[i]..of.roll_starts[i + 1]];
        Gradient {
            loss,
            overflowed: ended && own.iter().any(|x| !x.is_finite()),
            params: gradient_params(model, &flat),
            controls: paths,
            poses: poses.as_chunks().0.iter().map(rows).collect(),
            rolls: rolls.iter().map(motion).collect(),
            norms,
            initial: self.request.initial.then_some(at_start),
            final_state,
        }
    }

    /// The gradient of an instance's initial state.
    fn at_start(&self, i: usize, instance: &Instance, ended: bool) -> State {
        let graph = &instance.model.model().graph;
        let (n, r) = (graph.node_count(), graph.rods.len());
        let point = |p: &[f32; 4]| [p[0], p[1], p[2]].map(|x| of_ended(ended, x));
        let (first, at) = (self.of.initial_starts[i], self.of.initial_twist_starts[i]);
        let points = |first: usize| match self.initial.get(first..first + n) {
            Some(bars) => bars.iter().map(point).collect(),
            None => vec![point(&[0.0; 4]); n],
        };
        let twists = self.initial_twists.get(at..at + r);
        let places = self.places.get(self.of.place_starts[i]..self.of.place_starts[i + 1]);
        State {
            positions: points(first),
            velocities: points(first + n),
            twists: match twists {
                Some(bars) => bars.iter().map(|x| of_ended(ended, *x)).collect(),
                None => vec![of_ended(ended, 0.0); r],
            },
            grasping: places.map_or_else(Default::default, |bars| {
                world::start(instance, |node| match bars.get(node) {
                    Some(bar) if ended => point(bar),
                    _ => [0.0; 3],
                })
            }),
        }
    }
}

/// Gradients as parameters; those without a derivative stay at their default or zero.
fn gradient_params(model: &Model, flat: &[f32]) -> Params {
    let mut params = unflatten(&model.params, flat);
    params.contact = bendtwin_core::Contact {
        collision_distance_m: 0.0,
        between_objects: bendtwin_core::Contact::default().between_objects,
        within_object: bendtwin_core::Contact::default().within_object,
        skin: bendtwin_core::Contact::default().skin,
        ..params.contact
    };
    params
}

/// A number in the range of f32 of a simulation that ended; NaN of one that diverged.
fn of_ended(ended: bool, x: f32) -> f32 {
    if ended { saturate(x) } else { f32::NAN }
}

/// A number in the range of f32; NaN becomes zero.
fn narrow(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { saturate(x) }
}

/// A number in the range of f32, or NaN.
fn saturate(x: f32) -> f32 {
    x.clamp(-f32::MAX, f32::MAX)
}

//! Training of Gaussians on the views of a recording, carried by the twin's predicted motion.
//!
//! They begin as the coloured points of the skin. Each step draws one view of one training frame
//! and moves all parameters by Adam along the gradient; at intervals those whose projections the
//! gradients pull hardest are split and transparent ones removed. Then all are bound to the nodes
//! again, at rest: between two bindings a mean moves in the frame of its nodes.
//!
//! The same input gives the same Gaussians, regardless of interruptions.

mod adam;
mod density;
mod loss;
mod parameters;

use bendtwin_core::{Graph, Point, Skin, Splats, Twin, Views, twin::appearance::MOST_SPLATS};
use bendtwin_graph::{SurfacePoints, bind_skin};
use bendtwin_splat::{Carrier, GaussiansBar, Rasteriser};
use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use self::{
    adam::Adam,
    density::Pull,
    parameters::{Gradient, Limits, Parameters},
};
use crate::{
    Error, Motion, camera,
    dressed::{extent_m, of_skin},
    target::{Rectangle, Target},
};

/// Steps between two changes of the number of Gaussians.
const DENSIFY_EVERY: u32 = 150;
/// Share of all steps in which their number changes.
const DENSIFY_UNTIL: f64 = 0.6;

/// Options of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingOptions {
    /// Most Gaussians.
    pub gaussians: usize,
    /// Steps in all.
    pub steps: u32,
    /// Gaussians that are round.
    pub isotropic: bool,
    /// Training frames used, from the first (0: all).
    pub max_frames: usize,
    /// Cameras, counted from 0, that are not used.
    pub held_out: Vec<u32>,
    /// Seed of the order of views.
    pub seed: u64,
}

/// A step of a training.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Steps that were made.
    pub done: u32,
    /// Loss of the view that was drawn.
    pub loss: f64,
    /// Number of Gaussians.
    pub gaussians: usize,
    /// True if a checkpoint here costs little work: the number of Gaussians was just changed.
    pub settled: bool,
}

/// A training in progress.
pub struct Training<'a> {
    twin: &'a Twin,
    motion: Motion<'a>,
    views: &'a Views,
    options: TrainingOptions,
    /// Index of the camera and of its view, of all that are trained on.
    samples: Vec<[usize; 2]>,
    /// Size of the object [m].
    extent_m: f32,
    state: State,
    carrier: Carrier,
}

/// Everything that changes. G is the number of Gaussians.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct State {
    done: u32,
    parameters: Parameters,
    adam: Adam,
    pull: Pull,
    /// Places of the means when they were bound to the nodes [m], shape [G, 3].
    bound_m: Vec<Point>,
}

impl<'a> Training<'a> {
    /// A training from the coloured skin.
    ///
    /// # Errors
    /// [`Error::NoViews`] if there is no view of a training frame.
    pub fn new(
        twin: &'a Twin,
        motion: Motion<'a>,
        views: &'a Views,
        colors: &[[u8; 3]],
        options: TrainingOptions,
    ) -> Result<Self, Error> {
        let frames = motion.training_frames(options.max_frames);
        let cameras = views.cameras.iter().enumerate();
        let used = cameras.filter(|(c, _)| !options.held_out.iter().any(|h| *h as usize == *c));
        let samples: Vec<[usize; 2]> = used
            .flat_map(|(c, camera)| {
                let own = camera.views.iter().enumerate();
                let frames = frames.clone();
                own.filter(move |(_, view)| frames.contains(&(view.frame as usize)))
                    .map(move |(v, _)| [c, v])
            })
            .collect();
        if samples.is_empty() {
            return Err(Error::NoViews);
        }
        let skin = of_skin(twin, colors);
        let rest = twin.graph.rest_positions.as_slice();
        let means = skin.carriers.positions(rest);
        let parameters = Parameters::new(&means, &skin);
        let state = State {
            done: 0,
            adam: Adam::new(parameters.len()),
            pull: Pull::new(parameters.len()),
            bound_m: means,
            parameters,
        };
        let carrier = Carrier::new(&twin.graph, &bound(&twin.graph, &state.bound_m))?;
        let extent_m = extent_m(rest);
        Ok(Self { twin, motion, views, options, samples, extent_m, state, carrier })
    }

    /// Resumes from a checkpoint of the same training.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] if it is damaged or of another one.
    pub fn restore(&mut self, checkpoint: &[u8]) -> Result<(), Error> {
        let state: State = postcard::from_bytes(checkpoint)
            .map_err(|error| Error::Checkpoint(error.to_string()))?;
        let count = state.parameters.len();
        let fits = state.parameters.is_whole()
            && state.adam.len() == count
            && state.pull.len() == count
            && state.bound_m.len() == count
            && count <= self.options.gaussians.clamp(self.twin.skin.len(), MOST_SPLATS)
            && state.done <= self.options.steps;
        if !fits {
            return Err(Error::Checkpoint("its parts do not belong together".to_owned()));
        }
        self.carrier = Carrier::new(&self.twin.graph, &bound(&self.twin.graph, &state.bound_m))?;
        self.state = state;
        Ok(())
    }

    /// State from which training can resume.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] if it cannot be written down.
    pub fn checkpoint(&self) -> Result<Vec<u8>, Error> {
        postcard::to_stdvec(&self.state).map_err(|error| Error::Checkpoint(error.to_string()))
    }

    /// True after the last step.
    pub fn is_done(&self) -> bool {
        self.state.done >= self.options.steps
    }

    /// Runs a training step.
    ///
    /// # Errors
    /// If the rasteriser fails.
    pub fn step(&mut self, rasteriser: &mut dyn Rasteriser) -> Result<Step, Error> {
        let [camera, view] = self.sample();
        let camera = &self.views.cameras[camera];
        let view = &camera.views[view];
        let target = Target::new(view, Rectangle::of(view));
        let crop = camera::whole(camera, view.frame).crop(
            view.corner[0],
            view.corner[1],
            view.size[0],
            view.size[1],
        );
        // A frame that the motion lacks was not taken as a sample.
        let nodes = self.motion.at(view.frame as usize).unwrap_or_default();
        let carried = self.carrier.at(nodes)?;
        let gaussians = carried.place(&self.state.parameters.gaussians())?;
        let image = rasteriser.render(&gaussians, &crop)?;
        let (loss, bar) = loss::loss(&image, &target)?;
        let by_placed = rasteriser.gradients(&gaussians, &crop, &bar)?;
        let bar = carried.adjoint(&by_placed)?;
        self.learn(&bar);
        self.state.done += 1;
        let densify = f64::from(self.state.done) < DENSIFY_UNTIL * f64::from(self.options.steps);
        let settled = self.state.done.is_multiple_of(DENSIFY_EVERY);
        if settled {
            self.settle(densify)?;
        }
        let gaussians = self.state.parameters.len();
        Ok(Step { done: self.state.done, loss, gaussians, settled })
    }

    /// The camera and view of the step: all of them in a shuffled order, repeatedly.
    fn sample(&self) -> [usize; 2] {
        let count = self.samples.len();
        let (round, place) = (self.state.done as usize / count, self.state.done as usize % count);
        let mut order: Vec<usize> = (0..count).collect();
        let seed = self.options.seed.wrapping_add(round as u64);
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        self.samples[order[place]]
    }

    fn learn(&mut self, bar: &GaussiansBar) {
        let state = &mut self.state;
        state.pull.add(bar);
        let (extent_m, isotropic) = (self.extent_m, self.options.isotropic);
        let (gradient, limits) = (Gradient::new(bar, isotropic), Limits::new(extent_m, isotropic));
        let done = f64::from(state.done) / f64::from(self.options.steps);
        state.adam.step(&mut state.parameters, &gradient, &limits, done, extent_m);
    }

    /// Changes the number of Gaussians, if it is time, and binds them to the nodes where they are.
    fn settle(&mut self, densify: bool) -> Result<(), Error> {
        let state = &mut self.state;
        if densify {
            let most = self.options.gaussians.max(self.twin.skin.len());
            density::change(&mut state.parameters, &mut state.adam, &state.pull, most);
        }
        state.pull = Pull::new(state.parameters.len());
        state.bound_m = state.parameters.means_m();
        self.carrier = Carrier::new(&self.twin.graph, &bound(&self.twin.graph, &state.bound_m))?;
        Ok(())
    }

    /// The current Gaussians.
    pub fn splats(&self) -> Splats {
        let gaussians = self.state.parameters.gaussians();
        Splats {
            carriers: bound(&self.twin.graph, &gaussians.means_m),
            scales_m: gaussians.scales_m,
            rotations: gaussians.rotations,
            opacities: gaussians.opacities,
            colors: gaussians.colors,
        }
    }
}

/// Points bound to a graph at rest.
fn bound(graph: &Graph, positions: &[Point]) -> Skin {
    let observed_points = vec![Graph::NOT_OBSERVED; positions.len()];
    bind_skin(graph, &SurfacePoints { positions: positions.to_vec(), observed_points })
}

#[cfg(test)]
mod tests;
